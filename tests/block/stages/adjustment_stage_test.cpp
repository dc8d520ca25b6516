#include "block/stages/adjustment_stage.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <map>
#include <set>

#include "tests/support/made_up_patches.h"
#include "tests/support/shared_data.h"

namespace orient::block {
namespace {

constexpr double kSigma_px = 0.3, kModelSigma_px = 0.1;

// What goes into the adjustment: photos over a database of 20 x 20 patches, 100 m apart.
class AdjustmentOf : public testing::Test {
 protected:
  AdjustmentOf() {
    camera_.kind = CameraKind::kDigital;
    camera_.principal_distance_mm = 100;
    camera_.frame_mm = {100, 100};
    camera_.image_px = Eigen::Vector2i(1000, 1000);
    for (const std::string name : {"a", "b", "c"}) {
      BlockPhotoFile photo;
      photo.name = photo.exterior.photo = name;
      photo.position.photo_from_pixel = DigitalPhotoFromPixel(camera_);
      photo.exterior.status = Status::kOk;
      const double x = 500000 + 300.0 * static_cast<double>(photos_.size());
      photo.exterior.pose = Pose{{x, 5000300, 2120}, {0, 0, 0}};
      photo.exterior.covariance = Matrix6d::Identity();
      photos_.push_back(photo);
    }
  }

  // As the photo sees it, in this state.
  void Match(std::size_t photo, std::int64_t id, PatchState state = PatchState::kMatched) {
    const auto i = static_cast<double>(id - 1);
    PatchResult patch;
    patch.id = id;
    patch.state = state;
    patch.ground_m =
        Eigen::Vector3d(500000 + 100 * std::fmod(i, 20), 5000000 + 100 * std::floor(i / 20), 120);
    const PhotoView view{
        camera_, photos_[photo].position.photo_from_pixel,
        photos_[photo].exterior.pose.value_or(Pose{{500000, 5000000, 2120}, {0, 0, 0}}), nullptr};
    patch.pixel = view.PixelFromGround(*patch.ground_m);
    patch.sigma_px = Eigen::Vector2d::Constant(kSigma_px);
    photos_[photo].exterior.patches.push_back(patch);
  }
  static TieRecord Tie(const std::vector<std::string>& photos) {
    TieRecord tie{{500100, 5000200, 120}, {}};
    for (const std::string& photo : photos)
      tie.seen.push_back({photo, {10, 20}, 0.25 * Eigen::Matrix2d::Identity(), 0.9});
    return tie;
  }
  AdjustedBlock Adjust() {
    return AdjustPhotos({photos_, ties_, camera_, surface_, patchdb_, choice_, known_});
  }
  // The patches that are control, and whether they are held out.
  static std::map<std::int64_t, bool> Control(const AdjustedBlock& adjusted) {
    std::map<std::int64_t, bool> control;
    for (const BlockPoint& point : adjusted.block.points)
      if (point.control) control[point.id] = point.held_out;
    return control;
  }

  const TemporaryFolder folder_;
  const std::string patchdb_ = folder_ / "patches.gpkg";
  patchdb::PatchDatabase database_ = MadeUpDatabase(patchdb_, 20, 20);
  Camera camera_;
  std::vector<BlockPhotoFile> photos_;
  std::vector<TieRecord> ties_;
  BlockAdjustmentChoice choice_;
  PoseObservations known_;
  GroundSurface surface_ =
      GroundSurface::FromGrid(Eigen::MatrixXf::Constant(100, 100, 120), 497000, 5003000, 100);
};

TEST_F(AdjustmentOf, PhotosWithoutAPoseTakeNoPart) {
  photos_[1].exterior.pose.reset();
  Match(1, 5);
  ties_ = {Tie({"a", "b", "c"}), Tie({"b", "gone"})};
  const AdjustedBlock adjusted = Adjust();
  EXPECT_EQ(adjusted.photo_of, (std::vector<std::size_t>{0, 2}));
  ASSERT_EQ(adjusted.block.photos.size(), 2u);
  EXPECT_EQ(adjusted.block.photos[1].name, "c");
  EXPECT_TRUE(Control(adjusted).empty());
  EXPECT_EQ(adjusted.ties, 2u) << "one that nobody sees keeps its place";
  ASSERT_EQ(adjusted.block.observations.size(), 2u);
  EXPECT_EQ(adjusted.block.observations[1].photo, 1u);
  EXPECT_EQ(adjusted.block.observations[1].point, 0u);
}

TEST_F(AdjustmentOf, LargerBlocksAreAdjustedInSubBlocks) {
  for (std::int64_t id = 1; id <= 6; ++id) Match(static_cast<std::size_t>(id) / 3, id);
  EXPECT_FALSE(Adjust().result.sub_blocks);
  choice_.sub_block_photos = 2;
  const BlockResult result = Adjust().result;
  ASSERT_TRUE(result.sub_blocks);
  EXPECT_EQ(result.sub_blocks->count, 2);
  EXPECT_EQ(result.sub_blocks->largest, 2);
}

TEST_F(AdjustmentOf, TiesComeBeforeControl) {
  Match(0, 5);
  ties_ = {Tie({"a", "b"}), Tie({"b", "c"})};
  const AdjustedBlock adjusted = Adjust();
  ASSERT_EQ(adjusted.block.points.size(), 3u);
  EXPECT_EQ(adjusted.ties, 2u);
  EXPECT_EQ(adjusted.block.points[0].id, 1);
  EXPECT_FALSE(adjusted.block.points[1].control);
  EXPECT_TRUE(adjusted.block.points[2].control);
  EXPECT_EQ(adjusted.patch.at(5), 2u);
}

TEST_F(AdjustmentOf, APatchSeenInTwoPhotosIsOnePoint) {
  Match(0, 5);
  Match(1, 5);
  Match(1, 6);
  const AdjustedBlock adjusted = Adjust();
  EXPECT_EQ(adjusted.block.points.size(), 2u);
  EXPECT_EQ(adjusted.block.observations.size(), 3u);
  EXPECT_EQ(adjusted.block.points[0].control->ground_m, Eigen::Vector3d(500400, 5000000, 120));
  EXPECT_EQ(adjusted.block.points[0].control->source, "1");
}

TEST_F(AdjustmentOf, OnlyMatchedPatchesOfTheDatabaseAreControl) {
  Match(0, 1);
  Match(0, 2, PatchState::kRejected);
  Match(0, 3, PatchState::kNotFound);
  Match(0, 4, PatchState::kNotVisible);
  Match(0, 999);  // deleted since
  Match(0, 5);
  photos_[0].exterior.patches.back().id = -5;  // lent by a neighbour
  Match(0, 6);
  photos_[0].exterior.patches.back().sigma_px.reset();
  Match(0, 7);
  photos_[0].exterior.patches.back().pixel.reset();
  EXPECT_EQ(Control(Adjust()), (std::map<std::int64_t, bool>{{1, false}}));
}

TEST_F(AdjustmentOf, AMatchIsNoMorePreciseThanTheModel) {
  Match(0, 5);
  const AdjustedBlock adjusted = Adjust();
  const double variance = kSigma_px * kSigma_px + kModelSigma_px * kModelSigma_px;
  EXPECT_TRUE(adjusted.block.observations[0].covariance_px2.isApprox(variance *
                                                                     Eigen::Matrix2d::Identity()));
}

TEST_F(AdjustmentOf, NoneAllOrAShareOfThePatchesIsHeldOut) {
  for (int id = 1; id <= 400; ++id) Match(0, id);
  const auto held_out = [&](double share) {
    choice_.check_share = share;
    int count = 0;
    for (const auto& [id, held] : Control(Adjust())) count += held;
    return count;
  };
  EXPECT_EQ(held_out(0), 0);
  EXPECT_EQ(held_out(1), 400);
  EXPECT_NEAR(held_out(0.3), 120, 60);
}

// Single ones between others would be too easy to predict.
TEST_F(AdjustmentOf, WhatIsHeldOutIsASquareOfGroundWhicheverPhotosAreInTheBlock) {
  for (BlockPhotoFile& photo : photos_) {
    photo.footprint = Bounds::OfNothing();
    photo.footprint.Include(0, 0);
    photo.footprint.Include(1700, 1700);  // 0.15 of it: squares of 256 m
  }
  for (int id = 1; id <= 400; ++id) Match(0, id);
  choice_.check_share = 0.5;
  const auto control = Control(Adjust());
  std::map<std::pair<long, long>, std::set<bool>> squares;
  for (const auto& [id, held] : control) {
    const Eigen::Vector3d ground = database_.ReadPatch(id)->ground_m;
    squares[{std::lround(std::floor(ground.x() / 256)), std::lround(std::floor(ground.y() / 256))}]
        .insert(held);
  }
  EXPECT_GT(squares.size(), 60u);
  for (const auto& [square, held] : squares) EXPECT_EQ(held.size(), 1u);
  photos_[1].exterior.patches = photos_[0].exterior.patches;
  photos_[0].exterior.patches.clear();
  photos_[2].exterior.pose.reset();
  photos_[1].footprint.Include(1800, 1700);  // some more
  EXPECT_EQ(Control(Adjust()), control);
}

// What a photo alone told for a gross error is no check; that there were some is counted.
TEST_F(AdjustmentOf, RejectedSightingsOfCheckPatchesAreCounted) {
  Match(0, 1, PatchState::kRejected);
  Match(1, 1, PatchState::kRejected);
  Match(0, 2, PatchState::kNotFound);
  EXPECT_EQ(Adjust().checks_rejected_alone, 0) << "nothing is held out";
  choice_.check_share = 1;
  EXPECT_EQ(Adjust().checks_rejected_alone, 2);
  photos_[1].exterior.patches[0].ground_m.reset();
  EXPECT_EQ(Adjust().checks_rejected_alone, 1);
  photos_[0].exterior.patches[0].id = -1;  // lent
  EXPECT_EQ(Adjust().checks_rejected_alone, 0);
}

// A height error that patches share is an unknown of its own: it is not counted twice.
TEST_F(AdjustmentOf, WhatPatchesErrInHeightTogetherIsNotInTheirOwnCovariance) {
  std::vector<patchdb::Patch> patches = {MadeUpPatch(500050, 5000050, 1),
                                         MadeUpPatch(500150, 5000050, 2),
                                         MadeUpPatch(500250, 5000050, 3)};
  const Eigen::Vector3d effect(0.5, 0, 1);
  const Eigen::Matrix3d own = Eigen::Vector3d(0.04, 0.05, 0.06).asDiagonal();
  for (patchdb::Patch& patch : patches) {
    patch.height_effect = effect;
    patch.height_sigma_m = 2;
  }
  patches[0].covariance_m2 = own + 4 * effect * effect.transpose();
  patches[1].covariance_m2 = own;  // said to be smaller than what is shared
  patches[2].covariance_m2 = own;
  patches[2].height_sigma_m = 0;
  patchdb::PatchSource source = MadeUpSource("1991.tif");
  database_.AddSource(source, patches);
  for (const patchdb::Patch& patch : patches) Match(0, patch.id);
  const AdjustedBlock adjusted = Adjust();
  const auto& points = adjusted.block.points;
  ASSERT_EQ(points.size(), 3u);
  EXPECT_EQ(points[0].control->height_sigma_m, 2);
  EXPECT_TRUE(points[0].control->height_effect.isApprox(effect));
  EXPECT_TRUE(points[0].control->covariance_m2.isApprox(own, 1e-6));
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(points[1].control->covariance_m2);
  EXPECT_NEAR(eigen.eigenvalues().minCoeff(), 1e-4 * own.trace(), 1e-9) << "but is one";
  EXPECT_TRUE(points[2].control->covariance_m2.isApprox(own, 1e-6));
}

TEST_F(AdjustmentOf, WhatIsKnownOfAPhotoIsItsOwn) {
  known_.approximations["b"] = {*photos_[1].exterior.pose, Matrix6d::Identity()};
  known_.gnss["c"] = {photos_[2].exterior.pose->position_m, Eigen::Matrix3d::Identity(), 0};
  known_.strip["c"] = "7";
  const AdjustedBlock adjusted = Adjust();
  const auto& photos = adjusted.block.photos;
  EXPECT_FALSE(photos[0].prior || photos[0].gnss);
  EXPECT_TRUE(photos[1].prior && !photos[1].gnss);
  EXPECT_TRUE(!photos[2].prior && photos[2].gnss);
  EXPECT_EQ(photos[0].strip + photos[1].strip + photos[2].strip, "7");
}

TEST_F(AdjustmentOf, NoPhotoWithAPoseIsAnEmptyBlock) {
  for (BlockPhotoFile& photo : photos_) photo.exterior.pose.reset();
  const AdjustedBlock adjusted = Adjust();
  EXPECT_TRUE(adjusted.photo_of.empty());
  EXPECT_TRUE(adjusted.block.observations.empty());
}

}  // namespace
}  // namespace orient::block
