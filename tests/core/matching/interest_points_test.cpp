#include "core/matching/interest_points.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>

#include "tests/support/texture.h"

namespace orient {
namespace {

constexpr double kCrossingPx = 0.02;
// A blurred corner's lines meet a little inside of it.
constexpr double kCornerPx = 0.35;

// A step of an image with a point spread of 0.6 px: an ideally sharp one is not band-limited.
double Step(double distance) { return std::erf(distance / (std::numbers::sqrt2 * 0.6)); }

// Two edges that cross at `at`, turned by `angle`: opposite quadrants bright.
Image Crossing(const Eigen::Vector2d& at, double angle) {
  const Eigen::Rotation2Dd turn(-angle);
  return DrawArea(50, 40, 8, [&](const Eigen::Vector2d& p) {
    const Eigen::Vector2d q = turn * (p - at);
    return 125 + 75 * Step(q.x()) * Step(q.y());
  });
}

TEST(InterestPoints, CrossingIsLocatedWithoutHalfPixelBias) {
  for (const double angle : {0.0, 0.3, 0.7}) {
    for (const Eigen::Vector2d& at :
         {Eigen::Vector2d(23, 17), Eigen::Vector2d(23.5, 17.5), Eigen::Vector2d(23.27, 17.81)}) {
      const auto points = FindInterestPoints(Crossing(at, angle));
      ASSERT_FALSE(points.empty());
      EXPECT_NEAR(points[0].pixel.x(), at.x(), kCrossingPx) << angle;
      EXPECT_NEAR(points[0].pixel.y(), at.y(), kCrossingPx) << angle;
      EXPECT_GT(points[0].roundness, 0.8);
    }
  }
}

TEST(InterestPoints, CornerAndSpotAreLocated) {
  const Eigen::Vector2d at(20.3, 19.6);
  const auto corner = FindInterestPoints(DrawArea(40, 40, 8, [&](const Eigen::Vector2d& p) {
    return p.x() > at.x() && p.y() > at.y() ? 200.0 : 50.0;
  }));
  ASSERT_EQ(corner.size(), 1u);
  EXPECT_LT((corner[0].pixel - at).norm(), kCornerPx);
  const auto spot = FindInterestPoints(DrawArea(
      40, 40, 8, [&](const Eigen::Vector2d& p) { return 125 + 75 * Step(2.5 - (p - at).norm()); }));
  ASSERT_FALSE(spot.empty());
  EXPECT_LT((spot[0].pixel - at).norm(), kCrossingPx);
}

TEST(InterestPoints, StraightEdgeAndFlatImageGiveNone) {
  EXPECT_TRUE(FindInterestPoints(DrawArea(40, 40, 8, [](const Eigen::Vector2d& p) {
                return p.x() + 0.3 * p.y() > 25 ? 200.0 : 50.0;
              })).empty());
  EXPECT_TRUE(FindInterestPoints(Image(40, 40, 5)).empty());
  EXPECT_TRUE(FindInterestPoints(Image()).empty());
  EXPECT_TRUE(FindInterestPoints(Image(3, 3, 5)).empty());
}

TEST(InterestPoints, NanAndItsNeighbourhoodGiveNone) {
  const Texture texture(4, 5);
  Image image = Draw(120, 60, [&](const auto& p) { return texture.At(p); });
  InterestOptions all;
  all.min_weight_ratio = 0;
  all.min_distance_px = 0;
  const auto before = FindInterestPoints(image, all);
  for (int r = 0; r < 60; ++r)
    for (int c = 30; c < 40; ++c) image.At(c, r) = kNoData;
  const auto after = FindInterestPoints(image, all);
  EXPECT_GT(after.size(), 5u);
  EXPECT_GT(before.size(), after.size());
  for (const InterestPoint& point : after) {
    EXPECT_TRUE(point.pixel.x() < 28 || point.pixel.x() > 42);
    EXPECT_TRUE(std::any_of(before.begin(), before.end(), [&](const auto& other) {
      return (other.pixel - point.pixel).norm() < 1e-9;
    })) << "made by the gap";
  }
}

TEST(InterestPoints, OrderedByWeightAndApart) {
  const Texture texture(9, 5);
  const auto points =
      FindInterestPoints(Draw(100, 100, [&](const auto& p) { return texture.At(p); }));
  ASSERT_GT(points.size(), 5u);
  for (size_t i = 0; i < points.size(); ++i) {
    EXPECT_GE(points[i > 0 ? i - 1 : 0].weight, points[i].weight);
    EXPECT_GE(points[i].roundness, 0.5);
    for (size_t j = 0; j < i; ++j) EXPECT_GE((points[i].pixel - points[j].pixel).norm(), 5);
  }
}

TEST(InterestPoints, CovarianceIsThatOfUnitNoise) {
  // Monte-Carlo at a crossing: the spread of the located point against noise * covariance.
  const Image clean = Crossing({25.2, 20.1}, 0.4);
  std::mt19937 random(11);
  constexpr double kNoise = 2;
  double ratio = 0;
  constexpr int kRuns = 200;
  const Eigen::Vector2d centre = FindInterestPoints(clean)[0].pixel;
  for (int i = 0; i < kRuns; ++i) {
    const auto point = FindInterestPoints(WithNoise(clean, kNoise, &random))[0];
    const Eigen::Vector2d error = point.pixel - centre;
    ratio += error.dot((kNoise * kNoise * point.covariance).inverse() * error) / 2;
  }
  // The formula takes gradients' noise as white with the grey values' own deviation; smoothing
  // in the derivative makes the truth smaller.
  EXPECT_LT(std::sqrt(ratio / kRuns), 1.2);
  EXPECT_GT(std::sqrt(ratio / kRuns), 0.2);
}

}  // namespace
}  // namespace orient
