#include "core/base/partial_files.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <vector>

#include "core/base/atomic_write.h"
#include "tests/support/shared_data.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

// A process that ran and does not any more.
pid_t EndedProcess() {
  const pid_t child = fork();
  if (child == 0) _exit(0);
  waitpid(child, nullptr, 0);
  return child;
}

TEST(PartialFiles, OfEndedProgramsAreRemovedAndNothingElse) {
  const TemporaryFolder folder;
  const std::string ended = std::to_string(EndedProcess()), here = std::to_string(getpid());
  fs::create_directories(folder / "below");
  for (const std::string& name :
       {"block.json." + ended + "-0.part", "new.gpkg." + ended + "-0.part-wal",
        "a.b.ties.json." + ended + "-3.part", "a.ortho.tif." + ended + "-0.part.ovr.tmp",
        "a.ortho.tif." + ended + "-0.part.msk.ovr.tmp"})
    WriteFileAtomically(folder / name, "half");
  const std::vector<std::string> kept = {"block.json",
                                         "block.json." + here + "-0.part",
                                         "spare.part",
                                         "new.gpkg." + here + "-0.part-wal",
                                         "a." + ended + ".tif",
                                         "archive." + ended + "-01.part",
                                         "below/a.json." + ended + "-0.part"};
  for (const std::string& name : kept) WriteFileAtomically(folder / name, "whole");
  RemovePartialFiles(folder / "");
  std::size_t files = 0;
  for (const auto& entry : fs::recursive_directory_iterator(folder / ""))
    files += entry.is_regular_file() ? 1 : 0;
  EXPECT_EQ(files, kept.size());
  for (const std::string& name : kept) EXPECT_TRUE(fs::exists(folder / name)) << name;
  RemovePartialFiles(folder / "absent");
}

TEST(PartialFiles, AreKnownByTheirNames) {
  for (const char* name : {"block.json.12-0.part", "new.gpkg.12-3.part-wal"})
    EXPECT_TRUE(IsPartialFile(name)) << name;
  for (const char* name : {"block.json", "spare.part", "archive.12-01.part", ".part", ""})
    EXPECT_FALSE(IsPartialFile(name)) << name;
  EXPECT_TRUE(IsBeingWritten("block.json." + std::to_string(getpid()) + "-0.part"));
  EXPECT_FALSE(IsBeingWritten("block.json." + std::to_string(EndedProcess()) + "-0.part"));
  EXPECT_FALSE(IsBeingWritten("block.json"));
}

}  // namespace
}  // namespace orient
