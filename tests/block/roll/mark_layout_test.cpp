// Layouts of marks from simulated scans of them, turned, scaled and noisy.
#include "block/roll/mark_layout.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <random>

#include "core/geometry/transform2d.h"

namespace orient::block {
namespace {

using Eigen::Vector2d;

const std::vector<Vector2d> kCorners = {{-106, -106}, {106, 106}, {-106, 106}, {106, -106}};

ScanOfMarks Scan(const std::vector<Vector2d>& marks, double turn_rad, double scale, double noise_mm,
                 unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0, noise_mm > 0 ? noise_mm : 1);
  ScanOfMarks scan{"s", {}};
  for (const Vector2d& mark : marks) {
    Vector2d place = scale * (Eigen::Rotation2Dd(turn_rad) * mark) + Vector2d(130, -120);
    if (noise_mm > 0) place += Vector2d(noise(random), noise(random));
    scan.place_mm.emplace_back(place);
  }
  return scan;
}

double LargestError(const MarkLayout& layout, const std::vector<Vector2d>& truth) {
  double largest = 0;
  for (size_t i = 0; i < truth.size(); ++i)
    largest = std::max(largest, (layout.position_mm[i] - truth[i]).norm());
  return largest;
}

MarkDistance Between(size_t from, size_t to, double sigma_mm = 0.01) {
  return {from, to, (kCorners[to] - kCorners[from]).norm(), sigma_mm};
}

TEST(MarkLayout, OfOneUprightScanIsThatScansAboutWhereOppositeMarksMeet) {
  const auto layout = EstimateLayout({Scan(kCorners, 0, 1, 0, 1)}, {}, 0.02);
  ASSERT_TRUE(layout);
  EXPECT_LT(LargestError(*layout, kCorners), 1e-6);
}

TEST(MarkLayout, IsTurnedUpright) {
  const auto layout = EstimateLayout({Scan(kCorners, 0.03, 1, 0, 1)}, {}, 0.02);
  ASSERT_TRUE(layout);
  EXPECT_LT(LargestError(*layout, kCorners), 1e-6);
}

TEST(MarkLayout, HasTheScaleOfMostScansWhicheverIsFirst) {
  const std::vector<ScanOfMarks> scans = {Scan(kCorners, 0, 2, 0, 1), Scan(kCorners, 0.1, 1, 0, 2),
                                          Scan(kCorners, 0, 1, 0, 3)};
  const auto layout = EstimateLayout(scans, {}, 0.02);
  ASSERT_TRUE(layout);
  EXPECT_LT(LargestError(*layout, kCorners), 1e-5);
  EXPECT_NEAR(layout->scale_difference, 1, 1e-9);
}

TEST(MarkLayout, TakesItsScaleFromOneDistance) {
  const auto layout = EstimateLayout({Scan(kCorners, 0, 1.02, 0, 1)}, {Between(0, 1)}, 0.02);
  ASSERT_TRUE(layout);
  EXPECT_LT(LargestError(*layout, kCorners), 1e-5);
}

TEST(MarkLayout, FollowsPreciseDistancesAgainstACoarseScan) {
  const std::vector<MarkDistance> distances = {Between(0, 1), Between(2, 3), Between(0, 2),
                                               Between(0, 3), Between(1, 2), Between(1, 3)};
  const auto layout = EstimateLayout({Scan(kCorners, 0, 1, 0.5, 3)}, distances, 0.5);
  ASSERT_TRUE(layout);
  for (size_t i = 0; i < distances.size(); ++i) {
    const MarkDistance& d = distances[i];
    const double adjusted = (layout->position_mm[d.to] - layout->position_mm[d.from]).norm();
    EXPECT_NEAR(adjusted, d.distance_mm, 0.02);
    EXPECT_NEAR(layout->distance_residual_mm[i], d.distance_mm - adjusted, 1e-9);
  }
}

// Beside the truth's own shift, rotation and scale, which no scan tells.
TEST(MarkLayout, SigmasAreThoseOfTheErrors) {
  double stated = 0, errors = 0;
  for (unsigned draw = 0; draw < 200; ++draw) {
    const auto layout = EstimateLayout(
        {Scan(kCorners, 0, 1, 0.05, 2 * draw), Scan(kCorners, 0.01, 1, 0.05, 2 * draw + 1)}, {},
        0.05);
    ASSERT_TRUE(layout);
    std::vector<PointPair2d> pairs;
    for (size_t i = 0; i < kCorners.size(); ++i)
      pairs.push_back({layout->position_mm[i], kCorners[i]});
    const auto fit = FitSimilarity(pairs, false);
    for (size_t i = 0; i < kCorners.size(); ++i) {
      errors += fit->residuals[i].squaredNorm();
      stated += layout->sigma_mm[i].squaredNorm();
    }
  }
  EXPECT_NEAR(errors / stated, 1, 0.2);
}

TEST(MarkLayout, OfScansThatShowDifferentMarksJoinsThem) {
  ScanOfMarks first = Scan(kCorners, 0, 1, 0, 1), second = Scan(kCorners, 0.02, 1, 0, 2);
  first.place_mm[3] = std::nullopt;
  second.place_mm[0] = std::nullopt;
  const auto layout = EstimateLayout({first, second}, {}, 0.02);
  ASSERT_TRUE(layout);
  EXPECT_LT(LargestError(*layout, kCorners), 1e-6);
}

TEST(MarkLayout, OfAMarkThatNoScanShowsIsNone) {
  ScanOfMarks scan = Scan(kCorners, 0, 1, 0, 1);
  scan.place_mm[2] = std::nullopt;
  EXPECT_FALSE(EstimateLayout({scan}, {}, 0.02));
}

// Any of eight marks may be missing: corners and sides.
TEST(MarkLayout, OfSevenOfEightMarksHasItsOriginInTheMiddle) {
  std::vector<Vector2d> all = kCorners;
  for (const Vector2d& side :
       {Vector2d(110, 0), Vector2d(-110, 0), Vector2d(0, 110), Vector2d(0, -110)})
    all.push_back(side);
  for (size_t missing = 0; missing < all.size(); ++missing) {
    std::vector<Vector2d> marks = all;
    marks.erase(marks.begin() + static_cast<std::ptrdiff_t>(missing));
    const auto layout = EstimateLayout({Scan(marks, 0, 1, 0, 1)}, {}, 0.02);
    ASSERT_TRUE(layout);
    EXPECT_TRUE(layout->origin_known);
    EXPECT_LT(LargestError(*layout, marks), 1e-6) << missing;
  }
}

TEST(MarkLayout, OfFourCornersAndOneSideHasItsOriginInTheMiddle) {
  std::vector<Vector2d> marks = kCorners;
  marks.emplace_back(0, 113);
  const auto layout = EstimateLayout({Scan(marks, 0, 1, 0, 1)}, {}, 0.02);
  ASSERT_TRUE(layout);
  EXPECT_LT(LargestError(*layout, marks), 1e-6);
}

TEST(MarkLayout, WithoutOppositeMarksSaysThatItsOriginIsNotKnown) {
  const std::vector<Vector2d> marks = {{-100, 0}, {0, 100}, {90, 60}};
  const auto layout = EstimateLayout({Scan(marks, 0, 1, 0, 1)}, {}, 0.02);
  ASSERT_TRUE(layout);
  EXPECT_FALSE(layout->origin_known);
}

TEST(MarkLayout, NamesThePlaceThatTheOthersContradict) {
  ScanOfMarks second = Scan(kCorners, 0.01, 1, 0.01, 2);
  *second.place_mm[2] += Vector2d(0.4, 0);
  const auto layout = EstimateLayout(
      {Scan(kCorners, 0, 1, 0.01, 1), second, Scan(kCorners, 0, 1, 0.01, 3)}, {}, 0.02);
  ASSERT_TRUE(layout && layout->contradiction);
  EXPECT_EQ(layout->contradiction->scan, std::optional<size_t>(1));
  EXPECT_EQ(layout->contradiction->mark, std::optional<size_t>(2));
  EXPECT_NEAR(layout->contradiction->off_mm, 0.4, 0.15);
}

TEST(MarkLayout, OfNoiseAloneContradictsNothing) {
  for (unsigned draw = 0; draw < 100; ++draw) {
    const auto layout = EstimateLayout(
        {Scan(kCorners, 0, 1, 0.05, 3 * draw), Scan(kCorners, 0.01, 1, 0.05, 3 * draw + 1)},
        {Between(0, 1), Between(2, 3)}, 0.05);
    ASSERT_TRUE(layout);
    EXPECT_FALSE(layout->contradiction);
  }
}

TEST(MarkLayout, OfTwoMarksIsNone) {
  EXPECT_FALSE(EstimateLayout({Scan({{-100, 0}, {100, 0}}, 0, 1, 0, 1)}, {}, 0.02));
}

TEST(MarkLayout, OfThreeCornersHasItsOriginInTheRectanglesMiddle) {
  const std::vector<Vector2d> marks(kCorners.begin(), kCorners.begin() + 3);
  const auto layout = EstimateLayout({Scan(marks, 0, 1, 0, 1)}, {}, 0.02);
  ASSERT_TRUE(layout);
  EXPECT_LT(LargestError(*layout, marks), 1e-6);
}

TEST(MarkLayout, OfFiveMarksHasItsOriginWhereTheOuterFourMeet) {
  std::vector<Vector2d> marks = kCorners;
  marks.emplace_back(0.7, -0.4);
  const auto layout = EstimateLayout({Scan(marks, 0, 1, 0, 1)}, {}, 0.02);
  ASSERT_TRUE(layout);
  EXPECT_LT(LargestError(*layout, marks), 0.02);
}

}  // namespace
}  // namespace orient::block
