#include "core/base/atomic_write.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>

#include "core/base/error.h"
#include "core/base/partial_files.h"
#include "tests/support/expect_error.h"
#include "tests/support/shared_data.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

size_t FilesIn(const std::string& folder) {
  return static_cast<size_t>(
      std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
}

TEST(AtomicWrite, Roundtrip) {
  const TemporaryFolder folder;
  const std::string contents("line\n\0binary\xff", 13);
  WriteFileAtomically(folder / "a", contents);
  EXPECT_EQ(ReadFile(folder / "a"), contents);
  const std::string long_text(300000, 'x');
  WriteFileAtomically(folder / "a", long_text);
  EXPECT_EQ(ReadFile(folder / "a"), long_text);
  WriteFileAtomically(folder / "a", "");
  EXPECT_EQ(ReadFile(folder / "a"), "");
}

TEST(AtomicWrite, NothingElseIsLeftInTheFolder) {
  const TemporaryFolder folder;
  WriteFileAtomically(folder / "a", "1");
  WriteFileAtomically(folder / "a", "2");
  EXPECT_EQ(FilesIn(folder.Path()), 1u);
}

TEST(AtomicWrite, AFailedWriteLeavesTheOldContentsAndNoRest) {
  const TemporaryFolder folder;
  fs::create_directory(folder / "target");  // a folder cannot be replaced by a file
  ExpectError<InputError>([&] { WriteFileAtomically(folder / "target", "x"); },
                          {folder / "target"});
  EXPECT_TRUE(fs::is_directory(folder / "target"));
  EXPECT_EQ(FilesIn(folder.Path()), 1u);
}

TEST(AtomicWrite, LeftoversOfAKilledRunAreNotInTheWay) {
  const TemporaryFolder folder;
  const std::string leftover = PartialName(folder / "a", 0);
  WriteFileAtomically(leftover, "half");
  WriteFileAtomically(folder / "a", "whole");
  EXPECT_EQ(ReadFile(folder / "a"), "whole");
  EXPECT_EQ(ReadFile(leftover), "half");
}

TEST(AtomicWrite, AMissingFolderIsNamedWithWhatToDo) {
  const TemporaryFolder folder;
  ExpectError<InputError>([&] { WriteFileAtomically(folder / "no/a.json", "x"); },
                          {folder / "no/a.json", "create its folder"});
}

TEST(AtomicWrite, AMissingFileIsNamed) {
  ExpectError<InputError>([] { ReadFile("no/such/file.toml"); }, {"no/such/file.toml"});
  const TemporaryFolder folder;
  ExpectError<InputError>([&] { ReadFile(folder.Path()); }, {folder.Path()});
}

}  // namespace
}  // namespace orient
