#include "core/base/new_file.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>

#include "core/base/atomic_write.h"
#include "core/base/error.h"
#include "core/base/partial_files.h"
#include "tests/support/expect_error.h"
#include "tests/support/shared_data.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

bool IsAlone(const std::string& path) {
  const fs::path folder = fs::path(path).parent_path();
  return std::distance(fs::directory_iterator(folder), fs::directory_iterator()) == 1;
}

TEST(NewFile, HasItsNameOnlyOnceItIsKept) {
  const TemporaryFolder folder;
  const std::string path = folder / "a";
  NewFile file(path);
  file.Write("text");
  EXPECT_FALSE(fs::exists(path));
  file.Keep();
  EXPECT_EQ(ReadFile(path), "text");
  EXPECT_TRUE(IsAlone(path));
}

TEST(NewFile, OneThatIsNotKeptLeavesWhatWasThere) {
  const TemporaryFolder folder;
  const std::string path = folder / "a";
  WriteFileAtomically(path, "old");
  { NewFile(path).Write("new"); }
  EXPECT_EQ(ReadFile(path), "old");
  EXPECT_TRUE(IsAlone(path));
}

TEST(NewFile, ALinkOfThePartialNameIsNotFollowed) {
  const TemporaryFolder folder;
  const std::string path = folder / "a", victim = folder / "victim";
  WriteFileAtomically(victim, "precious");
  fs::create_symlink(victim, PartialName(path, 0));
  WriteFileAtomically(path, "text");
  EXPECT_EQ(ReadFile(victim), "precious");
  EXPECT_EQ(ReadFile(path), "text");
}

TEST(NewFile, DevicesAndPipesAreNotReplaced) {
  const TemporaryFolder folder;
  ASSERT_EQ(mkfifo((folder / "pipe").c_str(), 0600), 0);
  for (const std::string& path : {folder / "pipe", std::string("/dev/null"),
                                  std::string("/dev/stdout"), std::string("/dev/no_such_device")})
    ExpectError<InputError>([&] { NewFile file(path); }, {path, "name a file"});
}

TEST(NewFile, ALinkPutInItsPlaceMeanwhileIsRefused) {
  const TemporaryFolder folder;
  const std::string path = folder / "a", victim = folder / "victim";
  WriteFileAtomically(victim, "precious");
  NewFile file(path);
  fs::remove(file.PartialPath());
  fs::create_symlink(victim, file.PartialPath());
  ExpectError<InputError>([&] { file.Keep(); }, {path});
  EXPECT_FALSE(fs::exists(path));
  EXPECT_EQ(ReadFile(victim), "precious");
}

TEST(NewFile, WhatALibraryWroteByNameIsKept) {
  const TemporaryFolder folder;
  NewFile file(folder / "a");
  WriteFileAtomically(file.PartialPath(), "of a library");  // another file of the same name
  file.Keep();
  EXPECT_EQ(ReadFile(folder / "a"), "of a library");
}

TEST(NewFile, AsNewItReplacesNothing) {
  const TemporaryFolder folder;
  const std::string path = folder / "a";
  NewFile first(path), second(path);
  first.Write("first");
  second.Write("second");
  first.KeepAsNew();
  ExpectError<InputError>([&] { second.KeepAsNew(); }, {path, "exists already"});
  EXPECT_EQ(ReadFile(path), "first");
}

TEST(NewFile, AFailedLibraryIsNamedWithItsReason) {
  const TemporaryFolder folder;
  const NewFile file(folder / "a");
  ExpectError<InputError>([&] { file.Fail("the format is unknown"); },
                          {folder / "a", "the format is unknown"});
}

}  // namespace
}  // namespace orient
