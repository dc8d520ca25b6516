#include "core/base/partial_files.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
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

// The name that this process would have given, with another process's number or machine.
std::string NameOf(const std::string& target, pid_t process, int n = 0,
                   const std::string& machine = "") {
  const std::string name = PartialName(target, n);
  const std::size_t end = name.rfind(".part") - 8;
  return target + "." + std::to_string(process) + "-" + std::to_string(n) + "-" +
         (machine.empty() ? name.substr(end, 8) : machine) + ".part";
}

void Age(const std::string& path, int hours) {
  fs::last_write_time(path, fs::file_time_type::clock::now() - std::chrono::hours(hours));
}

TEST(PartialFiles, OfEndedProgramsAreRemovedAndNothingElse) {
  const TemporaryFolder folder;
  const pid_t ended = EndedProcess(), here = getpid();
  fs::create_directories(folder / "below");
  for (const std::string& name :
       {NameOf("block.json", ended), NameOf("new.gpkg", ended) + "-wal",
        NameOf("a.b.ties.json", ended, 3), NameOf("a.ortho.tif", ended) + ".ovr.tmp",
        NameOf("a.ortho.tif", ended) + ".msk.ovr.tmp"})
    WriteFileAtomically(folder / name, "half");
  const std::vector<std::string> kept = {"block.json",
                                         NameOf("block.json", here),
                                         "spare.part",
                                         NameOf("new.gpkg", here) + "-wal",
                                         "a." + std::to_string(ended) + ".tif",
                                         "archive." + std::to_string(ended) + "-01.part",
                                         "below/" + NameOf("a.json", ended)};
  for (const std::string& name : kept) WriteFileAtomically(folder / name, "whole");
  RemovePartialFiles(folder / "");
  std::size_t files = 0;
  for (const auto& entry : fs::recursive_directory_iterator(folder / ""))
    files += entry.is_regular_file() ? 1 : 0;
  EXPECT_EQ(files, kept.size());
  for (const std::string& name : kept) EXPECT_TRUE(fs::exists(folder / name)) << name;
  RemovePartialFiles(folder / "absent");
}

TEST(PartialFiles, OfAnotherMachineStayForADayWhateverItsProcess) {
  const TemporaryFolder folder;
  const std::string young = folder / NameOf("a.json", EndedProcess(), 0, "0badcafe");
  const std::string old = folder / NameOf("b.json", getpid(), 0, "0badcafe");
  for (const std::string& path : {young, old}) WriteFileAtomically(path, "half");
  Age(young, 23);
  Age(old, 25);
  EXPECT_TRUE(IsBeingWritten(young));
  EXPECT_FALSE(IsBeingWritten(old));
  RemovePartialFiles(folder.Path());
  EXPECT_TRUE(fs::exists(young));
  EXPECT_FALSE(fs::exists(old));
}

TEST(PartialFiles, AreKnownByTheirNames) {
  EXPECT_EQ(NameOf("a/block.json", getpid(), 7), PartialName("a/block.json", 7));
  for (const char* name :
       {"block.json.12-0-0badcafe.part", "new.gpkg.12-3-0badcafe.part-wal", "a.12-0.part"})
    EXPECT_TRUE(IsPartialFile(name)) << name;
  for (const char* name : {"block.json", "spare.part", "archive.12-01-0badcafe.part",
                           "a.12-0-cafe.part", "a.12-0-0BADCAFE.part", ".part", ""})
    EXPECT_FALSE(IsPartialFile(name)) << name;
  EXPECT_TRUE(IsBeingWritten(NameOf("block.json", getpid())));
  EXPECT_FALSE(IsBeingWritten(NameOf("block.json", EndedProcess())));
  EXPECT_FALSE(IsBeingWritten("block.json"));
}

}  // namespace
}  // namespace orient
