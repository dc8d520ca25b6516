#include "block/stages/jobs.h"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <atomic>
#include <filesystem>
#include <map>

#include "block/inputs/digest.h"
#include "core/base/atomic_write.h"
#include "core/base/error.h"
#include "tests/block/stages/fake_stage.h"
#include "tests/support/shared_data.h"

namespace orient::block {
namespace {

std::map<std::string, std::string> FilesOf(const ResultStore& store) {
  std::map<std::string, std::string> files;
  for (const std::string& name : store.Jobs()) files[name] = ReadFile(store.PathOf(name));
  return files;
}

class RunJobsTest : public ::testing::Test {
 protected:
  Job Counted(const std::string& name, const Inputs& inputs) {
    return FakeJob(store_, name, inputs, [this] { ++runs_; });
  }
  Job Failing(const std::string& name, const std::string& why) {
    return {name, {{"scan", "x"}}, [why] { throw InputError(why); }};
  }

  TemporaryFolder folder_;
  ResultStore store_{folder_.Path(), ".json"};
  std::atomic<int> runs_ = 0;
};

TEST_F(RunJobsTest, KeepsWhatIsCurrentAndDoesTheRest) {
  std::vector<Job> jobs;
  for (const char* name : {"a", "b", "c"}) jobs.push_back(Counted(name, {{"scan", name}}));
  for (const KnownResult& known : RunJobs(jobs, store_))
    EXPECT_EQ(known.state, ResultState::kAbsent);
  EXPECT_EQ(runs_, 3);
  jobs[1] = Counted("b", {{"scan", "another"}});
  store_.Drop("c");
  int done = 0;
  const auto known = RunJobs(jobs, store_, {2, true, false, [&] { ++done; }});
  EXPECT_EQ(known[0].state, ResultState::kCurrent);
  EXPECT_EQ(known[1].state, ResultState::kChanged);
  EXPECT_EQ(known[1].changed, std::vector<std::string>{"scan"});
  EXPECT_EQ(known[2].state, ResultState::kAbsent);
  EXPECT_EQ(runs_, 5);
  EXPECT_EQ(done, 3);
  RunJobs(jobs, store_, {1, false});
  EXPECT_EQ(runs_, 8);
}

TEST_F(RunJobsTest, OneThatThrowsTakesNothingFromItsNeighbours) {
  for (const int at_a_time : {1, 4}) {
    std::vector<Job> jobs;
    for (int i = 0; i < 20; ++i) {
      const std::string name = "job" + std::to_string(i);
      jobs.push_back(i == 7 || i == 13 ? Failing(name, name + " is damaged")
                                       : Counted(name, {{"scan", name}}));
    }
    WriteFakeResult(store_, "job7", {{"scan", "an earlier one"}});
    try {
      RunJobs(jobs, store_, {at_a_time, false});
      FAIL() << "nothing was thrown";
    } catch (const InputError& error) {
      EXPECT_STREQ(error.what(), "job7 is damaged");  // the first in their order
    }
    EXPECT_EQ(store_.Jobs().size(), 18u);
    EXPECT_FALSE(std::filesystem::exists(store_.PathOf("job7")));
    for (const std::string& name : store_.Jobs())
      EXPECT_TRUE(store_.IsCurrent(name, {{"scan", name}}));
  }
}

TEST_F(RunJobsTest, WhatAJobWroteBeforeItThrewIsNoResult) {
  const Inputs inputs = {{"scan", "x"}};
  const Job job = {"a", inputs, [&] {
                     WriteFakeResult(store_, "a", inputs);
                     throw std::runtime_error("out of disk");
                   }};
  EXPECT_THROW(RunJobs({job}, store_), std::runtime_error);
  EXPECT_EQ(store_.Check("a", inputs).state, ResultState::kAbsent);
}

TEST_F(RunJobsTest, AnInterruptedRunIsContinuedToWhatAFreshOneGives) {
  std::vector<Job> jobs;
  for (int i = 0; i < 6; ++i)
    jobs.push_back(Counted("job" + std::to_string(i), {{"scan", std::to_string(i)}}));
  std::vector<Job> interrupted = jobs;
  for (int i = 3; i < 6; ++i)
    interrupted[static_cast<std::size_t>(i)] = Failing("job" + std::to_string(i), "killed");
  EXPECT_THROW(RunJobs(interrupted, store_), InputError);
  EXPECT_EQ(store_.Jobs().size(), 3u);
  RunJobs(jobs, store_);
  EXPECT_EQ(runs_, 6);
  const TemporaryFolder fresh;
  const ResultStore fresh_store(fresh.Path(), ".json");
  for (int i = 0; i < 6; ++i)
    WriteFakeResult(fresh_store, "job" + std::to_string(i), {{"scan", std::to_string(i)}});
  EXPECT_EQ(FilesOf(store_), FilesOf(fresh_store));
}

TEST_F(RunJobsTest, AResultThatCannotBeReadWhenItIsKeptIsMadeAgain) {
  Job job = Counted("a", {{"scan", "x"}});
  RunJobs({job}, store_);
  job.keep = [] { throw InputError("a number where a name should be"); };
  EXPECT_EQ(RunJobs({job}, store_)[0].state, ResultState::kUnreadable);
  EXPECT_EQ(runs_, 2);
}

TEST_F(RunJobsTest, AResultThatDoesNotSayWhatItWasMadeFromIsKeptWhereThatIsWanted) {
  const Job job = Counted("a", {{"scan", "x"}});
  WriteFileAtomically(store_.PathOf("a"), "{}");
  EXPECT_EQ(RunJobs({job}, store_, {1, true, true})[0].state, ResultState::kCurrent);
  EXPECT_EQ(runs_, 0);
  EXPECT_EQ(RunJobs({job}, store_)[0].state, ResultState::kUnstated);
  EXPECT_EQ(runs_, 1);
}

TEST_F(RunJobsTest, NoTwoJobsWriteOneResult) {
  EXPECT_THROW(RunJobs({Counted("a", {}), Counted("a", {})}, store_), std::invalid_argument);
  EXPECT_THROW(RequireOwnNames({"one/p.tif", "two/p.tif"}), UsageError);
  EXPECT_THROW(RequireOwnNames({"one/p\nq.tif"}), UsageError) << "no table can name it";
  RequireOwnNames({"one/p.tif", "one/q.tif"});
  EXPECT_TRUE(RunJobs({}, store_).empty());
}

// Two stages, like exterior orientation and ties: the second one's jobs are made from the results
// of the first one, their own and the next one's.
class TwoStages {
 public:
  explicit TwoStages(const std::string& folder)
      : poses(folder, ".pose.json"), ties(folder, ".ties.json") {}

  // Killed when `left` jobs have been done.
  void Run(const std::vector<int>& scans, int camera, int left) const {
    std::atomic<int> still = left;
    const auto survive = [&] {
      if (still-- <= 0) throw InputError("killed");
    };
    std::vector<Job> jobs;
    for (std::size_t i = 0; i < scans.size(); ++i)
      jobs.push_back(FakeJob(
          poses, Name(i), {{"camera", std::to_string(camera)}, {"scan", std::to_string(scans[i])}},
          survive));
    RunJobs(jobs, poses, {2});
    jobs.clear();
    for (std::size_t i = 0; i < scans.size(); ++i)
      jobs.push_back(FakeJob(ties, Name(i),
                             {{"own", DigestOfFile(poses.PathOf(Name(i)))},
                              {"next", DigestOfFile(poses.PathOf(Name((i + 1) % scans.size())))}},
                             survive));
    RunJobs(jobs, ties, {2});
  }
  static std::string Name(std::size_t i) { return "photo" + std::to_string(i); }

  ResultStore poses, ties;
};

constexpr int kPhotos = 4;
constexpr int kAllJobs = 2 * kPhotos;

// One thing that happens to a folder between two runs, or during one.
void SomethingHappens(const TwoStages& stages, std::vector<int>* scans, int* camera) {
  const auto photo = static_cast<std::size_t>(*rc::gen::inRange(0, kPhotos));
  const ResultStore& store = *rc::gen::arbitrary<bool>() ? stages.poses : stages.ties;
  const std::string path = store.PathOf(TwoStages::Name(photo));
  const bool there = std::filesystem::exists(path);
  switch (*rc::gen::inRange(0, 6)) {
    case 0:
      (*scans)[photo] = *rc::gen::inRange(0, 3);  // an earlier scan may come back
      break;
    case 1:
      *camera = *rc::gen::inRange(0, 2);
      break;
    case 2:
      std::filesystem::remove(path);
      break;
    case 3:
      // The last character is a newline, without which it is as good.
      if (there)
        std::filesystem::resize_file(
            path, std::filesystem::file_size(path) * *rc::gen::inRange<std::uintmax_t>(0, 9) / 10);
      break;
    case 4:
      WriteFileAtomically(path, "no JSON, or of another program\n");
      break;
    default:
      try {
        stages.Run(*scans, *camera, *rc::gen::inRange(0, kAllJobs));
      } catch (const InputError&) {  // killed
      }
  }
}

TEST(RunJobs, WhateverHappenedBeforeARunEndsAsAFreshOne) {
  EXPECT_TRUE(rc::check([] {
    const TemporaryFolder used, fresh;
    const TwoStages stages(used.Path()), other(fresh.Path());
    std::vector<int> scans(kPhotos, 0);
    int camera = 0;
    const int events = *rc::gen::inRange(0, 12);
    for (int i = 0; i < events; ++i) SomethingHappens(stages, &scans, &camera);
    stages.Run(scans, camera, kAllJobs);
    other.Run(scans, camera, kAllJobs);
    RC_ASSERT(FilesOf(stages.poses) == FilesOf(other.poses));
    RC_ASSERT(FilesOf(stages.ties) == FilesOf(other.ties));
    // Nothing is left to be done.
    stages.Run(scans, camera, 0);
  }));
}

}  // namespace
}  // namespace orient::block
