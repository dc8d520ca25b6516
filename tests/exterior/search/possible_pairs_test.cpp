#include "exterior/search/possible_pairs.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <random>

#include "core/geometry/collinearity.h"
#include "core/geometry/rotation.h"

namespace orient::exterior {
namespace {

constexpr double kHeight_m = 1500, kGsd_m = 0.25;

// A camera, a film lying in the scan so, and keypoints of the ground as a photo of any kappa shows
// them.
class PossiblePairsTest : public ::testing::TestWithParam<bool> {
 protected:
  PossiblePairsTest() {
    camera_.principal_distance_mm = 150;
    camera_.frame_mm = {60, 60};
    camera_.principal_point_mm = {0.3, -0.2};
    position_.photo_from_pixel.A = Eigen::Rotation2Dd(0.4).toRotationMatrix() *
                                   Eigen::Vector2d(GetParam() ? -1 : 1, -1).asDiagonal() * 0.025;
    position_.photo_from_pixel.t = {-30, 30};
    pose_ = {{500000, 5000000, kHeight_m}, {0.02, -0.03, RadFromDeg(77)}};
    std::mt19937 random(3);
    std::uniform_real_distribution<double> at(-250, 250), angle(-3, 3);
    for (int i = 0; i < 60; ++i) Add({at(random), at(random)}, angle(random), 1 + 0.1 * i);
  }

  // `chip_rad`: direction of the keypoint in the chip, which is mirrored where the photo is.
  void Add(const Eigen::Vector2d& offset_m, double chip_rad, double size_m) {
    const Eigen::Vector3d ground_m = {500000 + offset_m.x(), 5000000 + offset_m.y(), 0};
    chips_.ground_m.push_back(ground_m);
    chips_.keypoints.angles_rad.push_back(chip_rad);
    chips_.keypoints.sizes_px.push_back(size_m);
    chips_.keypoints.pixels.emplace_back(0, 0);
    const PhotoView view = View();
    photo_.pixels.push_back(*view.PixelFromGround(ground_m));
    // The turn from chip to scan that gives this kappa: by trying.
    double turn = 0, best = 9;
    for (double t = -3.2; t < 3.2; t += 0.001) {
      const double off = std::abs(NormalizeAngle(KappaOf(t, position_) - pose_.opk_rad.z()));
      if (off < best) best = off, turn = t;
    }
    photo_.angles_rad.push_back(NormalizeAngle(chip_rad + turn));
    photo_.sizes_px.push_back(size_m / kGsd_m);
  }

  PhotoView View() const { return {camera_, position_.photo_from_pixel, pose_, {}}; }
  // As approximated: another kappa.
  PhotoView Approximated() const {
    PhotoView view = View();
    view.pose.opk_rad.z() = -2;
    return view;
  }

  Camera camera_;
  FilmPosition position_;
  Pose pose_;
  Keypoints photo_;
  ChipKeypoints chips_;
};

TEST_P(PossiblePairsTest, RightOnesPassAtAnyKappaAndFewOthers) {
  PossiblePairs possible(photo_, chips_, kGsd_m, 1.5);
  possible.LetPassNear(Approximated(), position_, 9, [](const auto&) { return 3.0; });
  std::size_t passed = 0;
  for (std::size_t i = 0; i < photo_.Size(); ++i) {
    const auto of = possible.Of(i);
    EXPECT_TRUE(std::count(of.begin(), of.end(), i)) << i;
    passed += of.size();
  }
  EXPECT_LT(passed, 3 * photo_.Size());  // of 60 times as many
}

TEST_P(PossiblePairsTest, AKappaThatIsKnownLeavesOnlyPairsThatSayIt) {
  PossiblePairs near(photo_, chips_, kGsd_m, 1.5), far(photo_, chips_, kGsd_m, 1.5);
  near.LetPassNear(View(), position_, 0.1, [](const auto&) { return 3.0; });
  far.LetPassNear(Approximated(), position_, 0.1, [](const auto&) { return 3.0; });
  for (std::size_t i = 0; i < photo_.Size(); ++i) {
    const auto of = near.Of(i), not_of = far.Of(i);
    EXPECT_TRUE(std::count(of.begin(), of.end(), i)) << i;
    EXPECT_FALSE(std::count(not_of.begin(), not_of.end(), i)) << i;
  }
}

TEST_P(PossiblePairsTest, WithoutAnApproximationOnlySizesCount) {
  constexpr double kReach = 1.53;  // no two sizes have just this ratio
  const PossiblePairs possible(photo_, chips_, kGsd_m, kReach);
  for (std::size_t i = 0; i < photo_.Size(); ++i) {
    std::vector<std::size_t> of = possible.Of(i), expected;
    for (std::size_t k = 0; k < photo_.Size(); ++k)
      if (std::abs(std::log(photo_.sizes_px[k] / photo_.sizes_px[i])) <= std::log(kReach))
        expected.push_back(k);
    std::sort(of.begin(), of.end());
    EXPECT_EQ(of, expected);
  }
}

TEST_P(PossiblePairsTest, AnyOfSeveralPositionsOfTheFilmSuffices) {
  FilmPosition turned = position_;
  turned.photo_from_pixel.A =
      Eigen::Rotation2Dd(1.5).toRotationMatrix() * turned.photo_from_pixel.A;
  PossiblePairs possible(photo_, chips_, kGsd_m, 1.5);
  PhotoView other = Approximated();
  other.photo_from_pixel = turned.photo_from_pixel;
  possible.LetPassNear(other, turned, 9, [](const auto&) { return 0.5; });
  possible.LetPassNear(Approximated(), position_, 9, [](const auto&) { return 3.0; });
  for (std::size_t i = 0; i < photo_.Size(); ++i) {
    const auto of = possible.Of(i);
    EXPECT_TRUE(std::count(of.begin(), of.end(), i)) << i;
  }
}

TEST_P(PossiblePairsTest, KeypointsOutOfOrderAreACallersMistake) {
  std::swap(photo_.sizes_px[3], photo_.sizes_px[9]);
  EXPECT_THROW(PossiblePairs(photo_, chips_, kGsd_m, 1.5), std::invalid_argument);
}

INSTANTIATE_TEST_SUITE_P(Film, PossiblePairsTest, ::testing::Values(false, true));

}  // namespace
}  // namespace orient::exterior
