#include "exterior/steps/residual_trends.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

namespace orient::exterior {
namespace {

using Trend = std::function<Eigen::Vector2d(const Eigen::Vector2d& place)>;

// Noise of 0.3 px at places all over a photo of 4000 px, two sources side by side, and a trend as a
// function of the place from -1 to 1.
TrendInput Simulated(int count, unsigned seed, const Trend& trend) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> place(-1, 1);
  std::normal_distribution<double> noise(0, 0.3);
  TrendInput input;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector2d at(place(random), place(random));
    input.pixels.push_back(2000 * (at + Eigen::Vector2d::Ones()));
    input.residuals_px.push_back(trend(at) + Eigen::Vector2d(noise(random), noise(random)));
    input.sources.push_back(at.x() < 0 ? 7 : 8);
  }
  return input;
}

Eigen::Vector2d None(const Eigen::Vector2d& /*place*/) { return Eigen::Vector2d::Zero(); }

TEST(FindTrends, NoiseHasATrendLessThanOnceInAThousandPhotos) {
  int alarms = 0;
  for (unsigned seed = 0; seed < 2000; ++seed)
    alarms += FindTrends(Simulated(100, seed, None)).empty() ? 0 : 1;
  EXPECT_LE(alarms, 8);  // 2 are expected; residuals do not know their variance better
}

TEST(FindTrends, OutwardsInEveryQuadrantIsARadialTrend) {
  const auto trends = FindTrends(Simulated(
      200, 1, [](const Eigen::Vector2d& place) { return 0.3 * place * place.squaredNorm(); }));
  ASSERT_FALSE(trends.empty());
  EXPECT_EQ(trends.front().kind, TrendKind::kRadial);
  EXPECT_FALSE(trends.front().source);
  EXPECT_NEAR(trends.front().rms_px, 0.22, 0.05);
}

TEST(FindTrends, EachQuadrantShiftedByItselfIsNamed) {
  const auto trends = FindTrends(Simulated(200, 1, [](const Eigen::Vector2d& place) {
    return place.x() * place.y() < 0 ? Eigen::Vector2d(0.3, 0) : Eigen::Vector2d(-0.3, 0);
  }));
  ASSERT_FALSE(trends.empty());
  EXPECT_EQ(trends.front().kind, TrendKind::kQuadrants);
}

TEST(FindTrends, OneSourceAgainstTheOtherIsItsShift) {
  const auto trends = FindTrends(Simulated(200, 1, [](const Eigen::Vector2d& place) {
    return place.x() < 0 ? Eigen::Vector2d(0, 0.25) : Eigen::Vector2d(0, -0.25);
  }));
  const auto of_source = [&](std::int64_t source) {
    return std::any_of(trends.begin(), trends.end(), [&](const ResidualTrend& trend) {
      return trend.source == source && trend.kind == TrendKind::kShift &&
             std::abs(trend.rms_px - 0.18) < 0.05;
    });
  };
  EXPECT_TRUE(of_source(7));
  EXPECT_TRUE(of_source(8));
}

TEST(FindTrends, RotationAndScaleOfOneSourceAreNamed) {
  for (const TrendKind kind : {TrendKind::kRotation, TrendKind::kScale}) {
    const auto trends = FindTrends(Simulated(400, 1, [&](const Eigen::Vector2d& place) {
      const Eigen::Vector2d from = place - Eigen::Vector2d(-0.5, 0);
      if (place.x() >= 0) return Eigen::Vector2d(0, 0);
      return kind == TrendKind::kScale ? Eigen::Vector2d(0.4 * from)
                                       : Eigen::Vector2d(-0.4 * from.y(), 0.4 * from.x());
    }));
    EXPECT_TRUE(std::any_of(trends.begin(), trends.end(), [&](const ResidualTrend& trend) {
      return trend.source == 7 && trend.kind == kind;
    }));
  }
}

TEST(FindTrends, FewResidualsOrThoseOnALineAreNoReasonForAlarm) {
  const auto shifted = [](const Eigen::Vector2d& /*place*/) { return Eigen::Vector2d(5, 5); };
  EXPECT_TRUE(FindTrends(Simulated(29, 1, shifted)).empty());
  EXPECT_TRUE(FindTrends({}).empty());
  TrendInput at_one_place = Simulated(50, 1, None);
  for (Eigen::Vector2d& pixel : at_one_place.pixels) pixel = {5, 5};
  EXPECT_TRUE(FindTrends(at_one_place).empty());
}

}  // namespace
}  // namespace orient::exterior
