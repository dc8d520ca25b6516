#include "core/base/side_by_side.h"

#include <gtest/gtest.h>
#include <tbb/parallel_for.h>

#include <stdexcept>
#include <string>
#include <vector>

namespace orient {
namespace {

TEST(SideBySide, DoesEveryPieceOnce) {
  std::vector<int> done(1000, 0);
  SideBySide(done.size(), [&](std::size_t i) { ++done[i]; });
  EXPECT_EQ(done, std::vector<int>(1000, 1));
}

TEST(SideBySide, ThrowsWhatTheFirstPieceThrowsWhicheverThreadIsQuicker) {
  for (int round = 0; round < 50; ++round) {
    std::string message;
    try {
      SideBySide(400, [](std::size_t i) {
        // The first to fail takes longest to do so.
        volatile double sum = 0;
        for (std::size_t k = 0; i == 3 && k < 200000; ++k) sum = sum + static_cast<double>(k);
        if (i >= 3) throw std::runtime_error("piece " + std::to_string(i));
      });
    } catch (const std::runtime_error& error) {
      message = error.what();
    }
    ASSERT_EQ(message, "piece 3");
  }
}

// As when the photo beside it throws: what is done must be done whole.
TEST(SideBySide, DoesEveryPieceWhereTheWorkAroundItIsCancelled) {
  for (int round = 0; round < 20; ++round) {
    tbb::task_group_context around;
    tbb::parallel_for(
        0, 2,
        [&](int) {
          around.cancel_group_execution();
          std::vector<int> own(1000, 0);
          SideBySide(own.size(), [&](std::size_t i) { own[i] = 1; });
          EXPECT_EQ(own, std::vector<int>(own.size(), 1));
        },
        around);
  }
}

}  // namespace
}  // namespace orient
