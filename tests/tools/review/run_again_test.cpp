#include "tools/review/run_again.h"

#include <gtest/gtest.h>

#include <chrono>
#include <future>

#include "core/base/error.h"

namespace orient {
namespace {

void WaitForEnd(const RunAgain& run) {
  for (int i = 0; run.Progress().running && i < 5000; ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
}

TEST(RunAgain, TellsHowFarItIsAndRunsOnceAtATime) {
  std::promise<void> half_way, go_on;
  RunAgain run([&](ProgressListener* listener) {
    const ProgressTask task(listener, "interior orientation", 4);
    listener->Advance(2);
    half_way.set_value();
    go_on.get_future().wait();
  });
  EXPECT_FALSE(run.Progress().running);
  ASSERT_TRUE(run.Start());
  half_way.get_future().wait();
  const RunProgress now = run.Progress();
  EXPECT_TRUE(now.running);
  EXPECT_EQ(now.task, "interior orientation");
  EXPECT_EQ(now.done, 2);
  EXPECT_EQ(now.total, 4);
  EXPECT_FALSE(run.Start()) << "one is running";
  go_on.set_value();
  WaitForEnd(run);
  EXPECT_FALSE(run.Progress().running);
  EXPECT_EQ(run.Progress().error, "");
}

TEST(RunAgain, AFailedRunIsToldAndAnotherMayFollow) {
  bool fails = true;
  RunAgain run([&](ProgressListener*) {
    if (fails) throw InputError("dem.tif: no such file");
  });
  ASSERT_TRUE(run.Start());
  WaitForEnd(run);
  EXPECT_EQ(run.Progress().error, "dem.tif: no such file");
  fails = false;
  ASSERT_TRUE(run.Start());
  WaitForEnd(run);
  EXPECT_EQ(run.Progress().error, "");
  EXPECT_EQ(run.Progress().runs, 2);
}

}  // namespace
}  // namespace orient
