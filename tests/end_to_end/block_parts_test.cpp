// Several runs share a block's work, each a part of it, in one folder.
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <map>

#include "core/base/atomic_write.h"
#include "tests/end_to_end/simulated_block.h"
#include "tests/support/run_orient.h"
#include "tests/support/shared_data.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

// The real program in processes of its own, side by side; their exit codes.
std::vector<int> SideBySideRuns(const std::vector<std::vector<std::string>>& commands) {
  std::vector<pid_t> children;
  for (const std::vector<std::string>& words : commands) {
    std::vector<char*> arguments = {const_cast<char*>("orient")};
    for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
    arguments.push_back(nullptr);
    const pid_t child = fork();
    if (child == 0) {
      execv(ORIENT_PROGRAM, arguments.data());
      _exit(127);
    }
    children.push_back(child);
  }
  std::vector<int> codes;
  for (const pid_t child : children) {
    int status = 0;
    waitpid(child, &status, 0);
    codes.push_back(WIFEXITED(status) ? WEXITSTATUS(status) : -1);
  }
  return codes;
}

// What a run leaves but for times of day.
std::map<std::string, std::string> Contents(const std::string& out) {
  std::map<std::string, std::string> contents;
  for (const auto& entry : fs::recursive_directory_iterator(out)) {
    const std::string name = fs::relative(entry.path(), out).string();
    const bool of_the_run = name == "run.json" || name == "report.html" || name == "block.gpkg" ||
                            name == "block.qgz" || entry.path().filename() == "not_yet_learnt";
    if (entry.is_regular_file() && !of_the_run) contents[name] = ReadFile(entry.path().string());
  }
  return contents;
}

std::vector<std::string> Differences(const std::string& a, const std::string& b) {
  const auto one = Contents(a), other = Contents(b);
  std::vector<std::string> names;
  for (const auto& [name, text] : one)
    if (!other.contains(name) || other.at(name) != text) names.push_back(name);
  for (const auto& [name, text] : other)
    if (!one.contains(name)) names.push_back(name);
  return names;
}

class BlockParts : public testing::Test {
 protected:
  BlockParts() {
    Simulate(QuickFilm(4), folder_ / "one");
    HarvestOldPhotos(folder_ / "one", folder_ / "one/patches.gpkg", 200);
    fs::copy(folder_ / "one", folder_ / "parts", fs::copy_options::recursive);
    // Results say of what DEM they were made: of content and time of change.
    fs::last_write_time(folder_ / "parts/dem.tif", fs::last_write_time(folder_ / "one/dem.tif"));
  }

  std::vector<std::vector<std::string>> Parts(const std::string& stage, int of) const {
    std::vector<std::vector<std::string>> commands;
    for (int i = 1; i <= of; ++i)
      commands.push_back({"block", Path(), "--stage", stage, "--part",
                          std::to_string(i) + "/" + std::to_string(of), "--jobs", "1"});
    return commands;
  }
  std::string Path() const { return folder_ / "parts/block.toml"; }

  const TemporaryFolder folder_;
};

TEST_F(BlockParts, TogetherAreTheBlock) {
  const ProgramRun one = RunOrient({"block", folder_ / "one/block.toml"});
  ASSERT_EQ(one.exit_code, 0) << one.out << one.err;
  const std::vector<int> all_done(3, 0);
  EXPECT_EQ(SideBySideRuns(Parts("interior", 3)), all_done);
  EXPECT_FALSE(fs::exists(folder_ / "parts/out/interior.csv"));
  EXPECT_EQ(RunOrient({"block", Path(), "--stage", "interior"}).exit_code, 0);
  EXPECT_TRUE(fs::exists(folder_ / "parts/out/interior.csv"));
  // A part that was lost: the others are done, and the whole run does the rest.
  auto parts = Parts("exterior", 3);
  parts.pop_back();
  EXPECT_EQ(SideBySideRuns(parts), std::vector<int>(2, 0));
  const ProgramRun status = RunOrient({"block", Path(), "--status"});
  EXPECT_NE(status.out.find("exterior       4   3     0       0     1"), std::string::npos)
      << status.out;
  EXPECT_NE(status.out.find("not finished"), std::string::npos) << status.out;
  const std::string kept = ExteriorResultPath(folder_ / "parts/out/stages/exterior", "new_1_1");
  const auto made = fs::last_write_time(kept);
  const ProgramRun whole = RunOrient({"block", Path()});
  EXPECT_EQ(whole.exit_code, 0) << whole.out << whole.err;
  EXPECT_EQ(fs::last_write_time(kept), made);
  EXPECT_EQ(Differences(folder_ / "parts/out", folder_ / "one/out"), std::vector<std::string>());
  EXPECT_NE(RunOrient({"block", Path(), "--status"}).out.find("finished\n"), std::string::npos);
}

TEST_F(BlockParts, WhatCannotBeAPartIsRefused) {
  const auto refused = [&](const std::vector<std::string>& more, const std::string& part) {
    std::vector<std::string> words = {"block", Path()};
    words.insert(words.end(), more.begin(), more.end());
    const ProgramRun run = RunOrient(words);
    EXPECT_EQ(run.exit_code, 1) << run.out;
    EXPECT_NE(run.err.find(part), std::string::npos) << run.err;
  };
  for (const char* part : {"0/3", "4/3", "3", "a/b", "1/", "/2", "1/2/3", "-1/2", "1/0"})
    refused({"--stage", "interior", "--part", part}, "must be K/N");
  refused({"--part", "1/2"}, "--part needs --stage");
  refused({"--stage", "interior", "--overwrite"}, "--stage goes with none");
  refused({"--stage", "interior", "--learn"}, "--stage goes with none");
  refused({"--stage", "control"}, "has no [control]");
  refused({"--status", "--stage", "interior"}, "give it alone");
  refused({"--stage", "exterior"}, "run --stage interior first");
}

}  // namespace
}  // namespace orient
