#include "exterior/search/keypoint_pairs.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <random>
#include <vector>

#include "core/geometry/collinearity.h"
#include "exterior/steps/photo_to_orient.h"
#include "tests/support/shared_data.h"

namespace orient::exterior {
namespace {

constexpr double kGsd_m = 0.4, kApart_px = 60;

// Keypoints of chips, one each, on the ground and in the photo; pairs of both.
class BackedPairsOfAPhoto : public testing::Test {
 protected:
  // Where a vertical photo shows what lies there, its film scanned as it lies (rows downwards) or
  // through its back; kappa as KappaOf has it for the turn.
  static Eigen::Vector2d Seen(const Eigen::Vector2d& ground_m, double turn_rad, bool mirrored) {
    constexpr double kPixel_mm = 0.02;
    FilmPosition position;
    position.photo_from_pixel.A =
        Eigen::Vector2d(mirrored ? -kPixel_mm : kPixel_mm, -kPixel_mm).asDiagonal();
    position.photo_from_pixel.t = position.photo_from_pixel.A * Eigen::Vector2d(-1500, -1500);
    Camera camera;
    camera.principal_distance_mm = 100;
    const double height_m = camera.principal_distance_mm * kGsd_m / kPixel_mm;
    const Pose pose{{0, 0, 100 + height_m}, {0, 0, KappaOf(turn_rad, position)}};
    const auto photo_mm = PhotoFromGround(camera, pose, {ground_m.x(), ground_m.y(), 100});
    return position.photo_from_pixel.Inverse() * *photo_mm;
  }
  Eigen::Vector2d Anywhere(double half) {
    std::uniform_real_distribution<double> any(-half, half);
    return {any(random_), any(random_)};
  }
  void Add(const Eigen::Vector2d& ground_m, const Eigen::Vector2d& pixel, double turn_rad) {
    std::normal_distribution<double> normal;
    const std::size_t i = pairs_.size();
    chips_.chip.push_back(i);
    chips_.middles_m.emplace_back(ground_m.x(), ground_m.y(), 100);
    chips_.ground_m.emplace_back(ground_m.x(), ground_m.y(), 100 + 10 * normal(random_));
    photo_.pixels.push_back(pixel);
    pairs_.push_back({.match = {i, i},
                      .turn_rad = turn_rad + 0.05 * normal(random_),
                      .gsd_m = kGsd_m * std::exp(0.1 * normal(random_)),
                      .middle_px = pixel});
  }
  void AddRight(int count, double turn_rad, bool mirrored) {
    for (int i = 0; i < count; ++i) {
      const Eigen::Vector2d ground_m = Anywhere(500);
      Add(ground_m, Seen(ground_m, turn_rad, mirrored), turn_rad);
    }
  }
  void AddWrong(int count, double turn_rad) {
    for (int i = 0; i < count; ++i)
      Add(Anywhere(500), Eigen::Vector2d(1500, 1500) + Anywhere(1200), turn_rad);
  }

  std::mt19937 random_{TestSeed()};
  ChipKeypoints chips_;
  Keypoints photo_;
  std::vector<Pair> pairs_;
};

TEST_F(BackedPairsOfAPhoto, RightOnesBackOneAnotherAtAnyTurnAndMirrored) {
  for (const bool mirrored : {false, true})
    for (const double turn_rad : {0.0, 1.3, 3.1, -2.0}) {
      chips_ = {};
      photo_ = {};
      pairs_.clear();
      AddRight(12, turn_rad, mirrored);
      AddWrong(60, turn_rad);
      const std::vector<int> backing = SupportCounts(pairs_, photo_, chips_, mirrored, kApart_px);
      double right = 0, wrong = 0;
      for (std::size_t i = 0; i < backing.size(); ++i) (i < 12 ? right : wrong) += backing[i];
      EXPECT_GT(right / 12, 7) << turn_rad << ' ' << mirrored;
      EXPECT_LT(wrong / 60, 4) << turn_rad << ' ' << mirrored;
    }
}

TEST_F(BackedPairsOfAPhoto, OneChipBacksAnotherOnceAndNeverItself) {
  Add({-300, 0}, Seen({-300, 0}, 0.4, false), 0.4);
  Add({300, 100}, Seen({300, 100}, 0.4, false), 0.4);
  for (int i = 0; i < 5; ++i) {  // more of the first chip's
    Add(chips_.ground_m[0].head<2>(), photo_.pixels[0], 0.4);
    chips_.chip.back() = 0;
  }
  const std::vector<int> backing = SupportCounts(pairs_, photo_, chips_, false, kApart_px);
  EXPECT_EQ(backing[0], 1);
  EXPECT_EQ(backing[1], 1);
}

TEST_F(BackedPairsOfAPhoto, ChipsOfTheSameGroundDoNotBackOneAnother) {
  for (const double east_m : {0.0, 5.0, 10.0}) Add({east_m, 0}, Seen({east_m, 0}, 0.4, false), 0.4);
  EXPECT_EQ(SupportCounts(pairs_, photo_, chips_, false, kApart_px), std::vector<int>({0, 0, 0}));
}

TEST_F(BackedPairsOfAPhoto, OfNoPairsThereIsNone) {
  EXPECT_TRUE(SupportCounts({}, photo_, chips_, false, kApart_px).empty());
}

}  // namespace
}  // namespace orient::exterior
