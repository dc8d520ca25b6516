#include "core/base/remote_files.h"

#include <gtest/gtest.h>

namespace orient {
namespace {

TEST(RemoteFiles, AddressesBecomeGdalsNames) {
  EXPECT_EQ(GdalName("s3://bucket/roll 7/1.tif"), "/vsis3/bucket/roll 7/1.tif");
  EXPECT_EQ(GdalName("gs://bucket/1.tif"), "/vsigs/bucket/1.tif");
  EXPECT_EQ(GdalName("az://container/1.tif"), "/vsiaz/container/1.tif");
  EXPECT_EQ(GdalName("https://host/1.tif?sig=a/b"), "/vsicurl/https://host/1.tif?sig=a/b");
  EXPECT_EQ(GdalName("http://host:8080/1.tif"), "/vsicurl/http://host:8080/1.tif");
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

TEST(RemoteFiles, PatienceEndsWithTheFirstAnswerOrTheLastAttempt) {
  int attempts = 0;
  EXPECT_TRUE(Patiently([&] { return ++attempts == 2; }));
  EXPECT_EQ(attempts, 2);
}

}  // namespace
}  // namespace orient
