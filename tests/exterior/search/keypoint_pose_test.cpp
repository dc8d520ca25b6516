#include "exterior/search/keypoint_pose.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <functional>
#include <random>

#include "core/geometry/rotation.h"
#include "exterior/steps/resect.h"
#include "tests/exterior/digital_view.h"
#include "tests/support/shared_data.h"

namespace orient::exterior {
namespace {

// A photo over hilly ground and what it shares with two others: `right` keypoints with an error of
// one pixel and of the surface, `wrong` ones anywhere.
class KeypointPoses : public testing::Test {
 protected:
  Eigen::Vector3d GroundAt(const Eigen::Vector2d& pixel) {
    const double height = 100 + 30 * std::sin(pixel.x() / 150) * std::cos(pixel.y() / 200);
    const auto ray = GroundRayFromPhoto(view_.camera, view_.pose, view_.PhotoFromPixel(pixel));
    const double t = (height - ray->origin_m.z()) / ray->direction.z();
    return ray->origin_m + t * ray->direction;
  }
  Eigen::Vector2d AnyPixel() {
    std::uniform_real_distribution<double> col(20, scan_.x() - 20), row(20, scan_.y() - 20);
    return {col(random_), row(random_)};
  }
  void AddRight(int count, const std::function<Eigen::Vector2d()>& place) {
    std::normal_distribution<double> normal;
    for (int i = 0; i < count; ++i) {
      const Eigen::Vector2d pixel = place();
      Eigen::Vector3d ground = GroundAt(pixel);
      ground += Eigen::Vector3d(normal(random_), normal(random_), 0.5 * normal(random_)) * gsd_m_;
      shared_.push_back({pixel + Eigen::Vector2d(normal(random_), normal(random_)), ground, {}});
    }
  }
  void AddWrong(int count) {
    for (int i = 0; i < count; ++i) shared_.push_back({AnyPixel(), GroundAt(AnyPixel()), {}});
  }
  // A patch of right ones, as if the same texture were seen `shift_m` beside.
  void AddShifted(int count, const Eigen::Vector3d& shift_m) {
    for (int i = 0; i < count; ++i) {
      const Eigen::Vector2d pixel = AnyPixel();
      shared_.push_back({pixel, GroundAt(pixel) + shift_m, {}});
    }
  }
  // What both frames show at the same place, the other photo lying elsewhere; with the film turned
  // by half a turn where `turned`.
  void AddOfTheFrame(int count, bool turned) {
    std::normal_distribution<double> normal;
    for (int i = 0; i < count; ++i) {
      const Eigen::Vector2d pixel = AnyPixel();
      const Eigen::Vector2d mm = view_.PhotoFromPixel(pixel);
      shared_.push_back({pixel + Eigen::Vector2d(normal(random_), normal(random_)),
                         GroundAt(pixel) + Eigen::Vector3d(700, 300, 0), turned ? -mm : mm});
    }
  }
  // Right ones, some of which the other photo shows elsewhere in its frame.
  void AddRightSeenElsewhere(int count) {
    const std::size_t before = shared_.size();
    AddRight(count, [&] { return AnyPixel(); });
    for (std::size_t i = before; i < shared_.size(); ++i)
      shared_[i].lender_mm = view_.PhotoFromPixel(shared_[i].pixel) + Eigen::Vector2d(30, 8);
  }
  FilmPosition Position(bool turned = false) const {
    FilmPosition position;
    position.photo_from_pixel = view_.photo_from_pixel;
    if (turned) position.photo_from_pixel = {-view_.photo_from_pixel.A, -view_.photo_from_pixel.t};
    return position;
  }
  std::optional<KeypointPose> Find(const KeypointPoseOptions& options = {}) {
    return PoseFromKeypoints(view_.camera, {Position()}, scan_, shared_, options);
  }

  std::mt19937 random_{TestSeed()};
  const PhotoView view_ = MakeView();
  const Eigen::Vector2i scan_ = *view_.camera.image_px;
  const double gsd_m_ =
      view_.PixelSize() / view_.camera.principal_distance_mm * (view_.pose.position_m.z() - 100);
  std::vector<SharedKeypoint> shared_;

 private:
  static PhotoView MakeView() {
    PhotoView view = DigitalView();
    view.pose.opk_rad = {RadFromDeg(2), RadFromDeg(-3), RadFromDeg(141)};
    return view;
  }
};

TEST_F(KeypointPoses, AreFoundAmongManyWrongOnesAndAsGoodAsTheySay) {
  double chi2 = 0;
  constexpr int kTrials = 12;
  for (int trial = 0; trial < kTrials; ++trial) {
    shared_.clear();
    AddRight(40, [&] { return AnyPixel(); });
    AddWrong(80);
    const auto found = Find();
    ASSERT_TRUE(found);
    EXPECT_GE(found->supporters, 33);
    const Vector6d off = PoseDifference(found->pose, view_.pose);
    chi2 += off.dot(found->covariance.ldlt().solve(off)) / (6.0 * kTrials);
  }
  // Careful: keypoints of one cell are counted once.
  EXPECT_LT(std::sqrt(chi2), 1.25);
  EXPECT_GT(std::sqrt(chi2), 0.4);
}

// Ten of 410: a thousand samples hardly ever hold three of them.
TEST_F(KeypointPoses, OfFewRightOnesAreFoundWhereThoseAreDrawnMoreOften) {
  KeypointPoseOptions options;
  options.min_supporters = 5;
  options.max_log10_false_alarms = 1;
  options.rival_share = 1;
  options.samples = 1000;
  int uniformly = 0, weighted = 0;
  for (int trial = 0; trial < 5; ++trial) {
    shared_.clear();
    AddRight(10, [&] { return AnyPixel(); });
    AddWrong(400);
    options.seed = static_cast<std::uint32_t>(trial);
    const auto is_right = [&](const std::optional<KeypointPose>& found) {
      return found && (found->pose.position_m - view_.pose.position_m).norm() < 50 * gsd_m_;
    };
    uniformly += is_right(Find(options)) ? 1 : 0;
    for (std::size_t i = 0; i < 10; ++i) shared_[i].weight = 30;
    weighted += is_right(Find(options)) ? 1 : 0;
  }
  EXPECT_LE(uniformly, 1);
  EXPECT_GE(weighted, 4);
}

TEST_F(KeypointPoses, AreNotMadeOfTooFewOrOfNone) {
  EXPECT_FALSE(Find());
  AddRight(2, [&] { return AnyPixel(); });
  EXPECT_FALSE(Find());
  AddRight(8, [&] { return AnyPixel(); });
  EXPECT_FALSE(Find());
}

TEST_F(KeypointPoses, AreNotMadeOfWhatChanceMakes) {
  AddWrong(400);
  EXPECT_FALSE(Find());
}

// Where so much is within reach, only the bound on chance keeps them apart.
TEST_F(KeypointPoses, AreNotMadeOfWhatChanceMakesWhereFewNeedAgree) {
  AddWrong(3000);
  KeypointPoseOptions options;
  options.sigma_px = 8;
  options.min_supporters = 4;
  options.rival_share = 2;
  options.max_tilt_rad = 1.2;
  options.samples = 1000;
  EXPECT_FALSE(Find(options));
}

TEST_F(KeypointPoses, AreNotMadeOfThreeClumps) {
  std::normal_distribution<double> beside(0, 4);
  for (const Eigen::Vector2d& clump :
       {Eigen::Vector2d(100, 150), Eigen::Vector2d(540, 300), Eigen::Vector2d(250, 1000)})
    AddRight(4, [&] {
      return Eigen::Vector2d(clump.x() + beside(random_), clump.y() + beside(random_));
    });
  EXPECT_FALSE(Find());
  KeypointPoseOptions options;
  options.min_supporters = 3;
  EXPECT_FALSE(Find(options));
}

TEST_F(KeypointPoses, AreNotMadeOfWhatAllFramesShow) {
  for (const bool turned : {false, true}) {
    shared_.clear();
    AddOfTheFrame(60, turned);
    const auto find = [&] {
      return PoseFromKeypoints(view_.camera, {Position(), Position(true)}, scan_, shared_);
    };
    EXPECT_FALSE(find());
    AddRightSeenElsewhere(40);
    const auto found = find();
    ASSERT_TRUE(found);
    EXPECT_LE(found->supporters, 40);
  }
}

TEST_F(KeypointPoses, AreNotMadeOfKeypointsOnALine) {
  std::uniform_real_distribution<double> along(50, scan_.x() - 50);
  AddRight(40, [&] { return Eigen::Vector2d(along(random_), scan_.y() * 0.4); });
  EXPECT_FALSE(Find());
}

TEST_F(KeypointPoses, AreNotMadeOfOneCorner) {
  std::uniform_real_distribution<double> beside(20, 60);
  AddRight(40, [&] { return Eigen::Vector2d(beside(random_), beside(random_)); });
  EXPECT_FALSE(Find());
}

TEST_F(KeypointPoses, AreNotBelievedWhereAnotherOneContends) {
  AddRight(40, [&] { return AnyPixel(); });
  AddShifted(35, {150, 40, 0});
  EXPECT_FALSE(Find());
}

TEST_F(KeypointPoses, OneKeypointInManyPhotosCountsOnce) {
  AddRight(8, [&] { return AnyPixel(); });
  const std::vector<SharedKeypoint> once = shared_;
  for (int i = 0; i < 5; ++i) shared_.insert(shared_.end(), once.begin(), once.end());
  EXPECT_FALSE(Find());
}

}  // namespace
}  // namespace orient::exterior
