#include "tools/cluster/uploaded_files.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "core/base/error.h"
#include "tests/support/expect_error.h"
#include "tools/cluster/store_object.h"

namespace orient {
namespace {

TEST(UploadedFiles, AreReadAsTheyWereWritten) {
  UploadedFiles list;
  list.files["photos/Überblick \"1\".json"] = {1, "cbf29ce484222325"};
  list.files["mosaic.tif"] = {std::uint64_t{5} << 40, ""};  // to come
  list.id = "ab";
  for (const bool complete : {false, true}) {
    list.complete = complete;
    const UploadedFiles read = ReadUploadedFiles(TextOf(list), "list");
    EXPECT_EQ(read.id, "ab");
    EXPECT_EQ(read.complete, complete);
    EXPECT_EQ(read.files, list.files);
  }
}

TEST(UploadedFiles, AnotherTextIsNoList) {
  const std::string files = R"({"kind": "orient upload", "id": "a", "complete": true, "files": )";
  std::vector<std::string> others = {
      "",
      "[]",
      "{",
      "{}",
      R"({"kind": "orient upload", "id": "a", "complete": true})",
      R"({"kind": "other", "id": "a", "complete": true, "files": {}})",
      R"({"kind": "orient upload", "id": 1, "complete": true, "files": {}})",
      R"({"kind": "orient upload", "id": "a", "complete": 1, "files": {}})",
      files + "[]}"};
  for (const char* entry : {"1", R"({"bytes": -1})", R"({"digest": "a"})",
                            R"({"bytes": "1", "digest": "a"})", R"({"bytes": 1, "digest": 2})"})
    others.push_back(files + R"({"a.tif": )" + entry + "}}");
  EXPECT_TRUE(ReadUploadedFiles(files + "{}}", "list").complete);
  for (const std::string& text : others)
    ExpectError<InputError>([&] { ReadUploadedFiles(text, "s3://b/list"); },
                            {"s3://b/list", "not a list of an upload"});
}

TEST(Store, IsWhatTakesObjects) {
  for (const char* place : {"/vsis3/bucket", "/vsigs/bucket/a/", "/vsiaz/container/a b/..c"})
    EXPECT_TRUE(IsStore(place)) << place;
  for (const char* place : {"/vsis3/", "/vsis3//", "/vsis3//a", "/vsis3/b//a", "/vsis3/b/../c",
                            "/vsis3/b/.", "/vsis3/b//", "/vsigs/b/a?token=c", "/vsicurl/http://h/a",
                            "/vsizip/a.zip", "out", "", "s3://bucket"})
    EXPECT_FALSE(IsStore(place)) << place;
  EXPECT_EQ(std::string(NoStore("http://me:secret@h/a").what()).find("secret"), std::string::npos);
}

}  // namespace
}  // namespace orient
