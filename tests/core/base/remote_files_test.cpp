#include "core/base/remote_files.h"

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "tests/support/expect_error.h"

namespace orient {
namespace {

TEST(RemoteFiles, AddressesBecomeGdalsNames) {
  EXPECT_EQ(GdalName("s3://bucket/roll 7/1.tif"), "/vsis3/bucket/roll 7/1.tif");
  EXPECT_EQ(GdalName("gs://bucket/1.tif"), "/vsigs/bucket/1.tif");
  EXPECT_EQ(GdalName("az://container/1.tif"), "/vsiaz/container/1.tif");
  EXPECT_EQ(GdalName("https://host/1.tif?sig=a/b"), "/vsicurl/https://host/1.tif?sig=a/b");
  EXPECT_EQ(GdalName("http://host:8080/1.tif"), "/vsicurl/http://host:8080/1.tif");
}

TEST(RemoteFiles, MessagesNameTheAddressThatWasTyped) {
  for (const char* name : {"s3://bucket/roll 7/1.tif", "gs://b/1.tif", "az://c/1.tif",
                           "https://host/1.tif", "http://host:8080/1.tif", "scans/1.tif"})
    EXPECT_EQ(TypedName(GdalName(name)), name);
}

TEST(RemoteFiles, APatternInTheFolderOfAnAddressIsRefused) {
  ExpectError<InputError>([] { RemoteMatches("/vsis3/bucket/roll*/1_*.tif"); },
                          {"s3://bucket/roll*/1_*.tif", "only the last part"});
}

TEST(RemoteFiles, OtherNamesStay) {
  for (const char* name : {"scans/1.tif", "/vsis3/bucket/1.tif", "s3:/1.tif", "WMS:http://x", ""})
    EXPECT_EQ(GdalName(name), name);
}

TEST(RemoteFiles, OnlyNamesOfTheNetworkAreRemote) {
  for (const char* name : {"/vsis3/a/1.tif", "/vsicurl/http://h/1.tif", "/vsicurl?url=x"})
    EXPECT_TRUE(IsRemote(name) && IsVirtual(name)) << name;
  EXPECT_TRUE(IsVirtual("/vsizip/a.zip/1.tif") && !IsRemote("/vsizip/a.zip/1.tif"));
  EXPECT_FALSE(IsVirtual("scans/1.tif") || IsRemote("https://host/1.tif"));
}

TEST(RemoteFiles, NamesAreReadWithoutEscapesAndQuestions) {
  EXPECT_EQ(WithoutEscapes("/vsicurl/http://h/roll%207/x%231.tif?sig=a/b%20"),
            "/vsicurl/http://h/roll 7/x#1.tif");
  EXPECT_EQ(WithoutEscapes("/vsis3/b/50%.tif"), "/vsis3/b/50%.tif");
  EXPECT_EQ(WithoutEscapes("/vsis3/b/%zz%2"), "/vsis3/b/%zz%2");
}

TEST(RemoteFiles, SecretsAreNotWrittenDown) {
  EXPECT_EQ(WithoutSecrets("orient interior 'https://me:pw@h/1.tif?X-Sig=abc' --out o"),
            "orient interior 'https://h/1.tif' --out o");
  EXPECT_EQ(WithoutSecrets("orient interior scans/what?.tif"), "orient interior scans/what?.tif");
}

TEST(RemoteFiles, PatienceEndsWithTheFirstAnswerOrTheLastAttempt) {
  int attempts = 0;
  EXPECT_TRUE(WithRetries([&] { return ++attempts == 2; }));
  EXPECT_EQ(attempts, 2);
  attempts = 0;
  EXPECT_FALSE(WithRetries([&] { return ++attempts == 0; }));
  EXPECT_EQ(attempts, 4);
}

}  // namespace
}  // namespace orient
