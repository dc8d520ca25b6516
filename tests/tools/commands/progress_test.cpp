#include "tools/commands/progress.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>

#include "core/base/atomic_write.h"
#include "tests/support/shared_data.h"
#include "tools/console/run_output.h"

namespace orient {
namespace {

TEST(Progress, TextSaysHowFarAndHowLong) {
  EXPECT_EQ(ProgressText("matching", 12, 40, 54), "matching  12 of 40, 30 %, 2 min 6 s left");
  EXPECT_EQ(ProgressText("matching", 1, 101, 90), "matching  1 of 101, 0 %, 2 h 30 min left");
  EXPECT_EQ(ProgressText("matching", 3, 4, 30), "matching  3 of 4, 75 %, 10 s left");
}

TEST(Progress, AStepThatTakesLongIsNamed) {
  EXPECT_EQ(ProgressText("matching", 0, 40, 90, 90),
            "matching  0 of 40, 0 %, the next one takes 1 min 30 s already");
  EXPECT_EQ(ProgressText("matching", 40, 40, 90, 90), "matching  40 of 40, 100 %");
}

TEST(Progress, WithoutAStepDoneNoTimeIsKnown) {
  EXPECT_EQ(ProgressText("matching", 0, 40, 5), "matching  0 of 40, 0 %");
}

TEST(Progress, AtTheEndAndForNothingToDoNoTimeIsLeft) {
  EXPECT_EQ(ProgressText("matching", 40, 40, 5), "matching  40 of 40, 100 %");
  EXPECT_EQ(ProgressText("matching", 0, 0, 5), "matching  0 of 0");
}

TEST(Progress, ALogHasALineAtTheEndOfATask) {
  const TemporaryFolder folder;
  std::ostringstream out, err;
  {
    RunOutput output({.log = folder / "run.log", .quiet = true}, "orient 0: orient", out, err);
    ProgressLine progress("matching", 3);
    progress.Advance(3);
    progress.Finish();
  }
  const std::string log = ReadFile(folder / "run.log");
  EXPECT_NE(log.find("Z matching  3 of 3 in 0 s\n"), std::string::npos) << log;
  EXPECT_EQ(std::count(log.begin(), log.end(), '\n'), 2) << log;
  EXPECT_EQ(out.str() + err.str(), "");
}

TEST(Progress, ShortRunsAreSilent) {
  testing::internal::CaptureStderr();
  {
    ProgressLine progress("matching", 3);
    for (int i = 0; i < 3; ++i) progress.Advance();
  }
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

}  // namespace
}  // namespace orient
