#include "tools/cluster/uploaded_files.h"

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "tests/support/expect_error.h"
#include "tools/cluster/upload.h"

namespace orient {
namespace {

TEST(UploadedFiles, AreReadAsTheyWereWritten) {
  UploadedFiles list;
  list.files["photos/Überblick \"1\".json"] = {1, "cbf29ce484222325"};
  list.files["mosaic.tif"] = {std::uint64_t{5} << 40, "85944171f73967e8"};
  for (const bool complete : {false, true}) {
    list.complete = complete;
    const UploadedFiles read = ReadUploadedFiles(TextOf(list), "list");
    EXPECT_EQ(read.complete, complete);
    EXPECT_EQ(read.files, list.files);
  }
}

TEST(UploadedFiles, AnotherTextIsNoList) {
  for (const char* text : {"", "[]", "{", "{}", R"({"kind": "orient upload", "complete": true})",
                           R"({"kind": "other", "complete": true, "files": {}})",
                           R"({"kind": "orient upload", "complete": 1, "files": {}})",
                           R"({"kind": "orient upload", "complete": true, "files": []})"})
    ExpectError<InputError>([&] { ReadUploadedFiles(text, "s3://b/list"); },
                            {"s3://b/list", "no list of an upload"});
  for (const char* entry : {"1", R"({"bytes": -1, "digest": ""})", R"({"bytes": 1})",
                            R"({"bytes": "1", "digest": "a"})", R"({"bytes": 1, "digest": 2})"})
    ExpectError<InputError>(
        [&] {
          ReadUploadedFiles(R"({"kind": "orient upload", "complete": true, "files": {"a.tif": )" +
                                std::string(entry) + "}}",
                            "s3://b/list");
        },
        {"s3://b/list", "a.tif"});
}

TEST(Store, IsWhatTakesObjects) {
  for (const char* place : {"/vsis3/bucket", "/vsigs/bucket/a", "/vsiaz/container/a b"})
    EXPECT_TRUE(IsStore(place)) << place;
  for (const char* place :
       {"/vsis3/", "/vsicurl/http://h/a", "/vsizip/a.zip", "out", "", "s3://bucket"})
    EXPECT_FALSE(IsStore(place)) << place;
  EXPECT_EQ(std::string(NoStore("http://me:secret@h/a").what()).find("secret"), std::string::npos);
}

}  // namespace
}  // namespace orient
