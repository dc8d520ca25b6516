#include "core/base/side_by_side.h"

#include <gtest/gtest.h>

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

}  // namespace
}  // namespace orient
