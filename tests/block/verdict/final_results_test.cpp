#include "block/verdict/final_results.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>

#include "block/bundle/adjusted_view.h"
#include "block/stages/adjustment_stage.h"
#include "tools/bench/bundle_simulation.h"

namespace orient::block {
namespace {

// A simulated bundle as the block's stages see it: every photo ok by patches of its own.
class FinalResultsOf : public testing::Test {
 protected:
  FinalResultsOf() {
    BundleSimulationOptions options;
    options.strips = 1;
    options.photos_in_strip = 4;
    options.control_photos = {0, 3};
    options.ties_per_photo = 40;
    simulation_ = SimulateBundle(options);
    LeaveOutSingleSightings();
    for (std::size_t i = 0; i < simulation_.block.photos.size(); ++i) {
      const BlockPhoto& photo = simulation_.block.photos[i];
      BlockPhotoFile file;
      file.name = photo.name;
      file.position.photo_from_pixel = photo.photo_from_pixel;
      file.exterior.photo = photo.name;
      file.exterior.status = Status::kOk;
      file.exterior.pose = photo.approximate;
      file.exterior.covariance = photo.prior->covariance;
      photos_.push_back(file);
      adjusted_.photo_of.push_back(i);
    }
    adjusted_.block = simulation_.block;
    // Control of the simulation comes after its ties.
    for (const BlockPoint& point : adjusted_.block.points)
      if (!point.control) ++adjusted_.ties;
  }

  std::vector<ExteriorResult> Results(const BlockOptions& options) {
    adjusted_.result = AdjustBlock(adjusted_.block, options);
    return FinalResults({photos_, {}, simulation_.block.cameras[0], surface_, "", {}}, adjusted_);
  }

  // No tie is measured in one photo only.
  void LeaveOutSingleSightings() {
    BlockToAdjust& block = simulation_.block;
    std::vector<int> seen(block.points.size(), 0);
    for (const ImageObservation& o : block.observations) ++seen[o.point];
    std::erase_if(block.observations, [&](const ImageObservation& o) {
      return seen[o.point] < 2 && !block.points[o.point].control;
    });
  }

  BundleSimulation simulation_;
  std::vector<BlockPhotoFile> photos_;
  AdjustedBlock adjusted_;
  GroundSurface surface_ =
      GroundSurface::FromGrid(Eigen::MatrixXf::Constant(100, 100, 200), 497000, 5003000, 100);
};

// Patches that alone fit to a tenth of a pixel lie a pixel beside the pose in the block: one of the
// two is wrong, and the stated precision says so.
TEST_F(FinalResultsOf, APhotoHeldOffItsOwnPatchesIsAsUncertainAsItWasMoved) {
  const std::vector<ExteriorResult> before = Results({});
  PhotoView view = photos_[1].View(simulation_.block.cameras[0]);
  view.pose = *before[1].pose;
  ExteriorResult& exterior = photos_[1].exterior;
  for (int i = 0; i < 40; ++i) {
    PatchResult patch;
    patch.id = 1000 + i;
    patch.state = PatchState::kMatched;
    patch.ground_m = view.pose.position_m + Eigen::Vector3d(10.0 * i - 200, 7.0 * (i % 9), 0);
    patch.ground_m->z() = 200;
    patch.pixel = *view.PixelFromGround(*patch.ground_m) + Eigen::Vector2d(1, 1);
    patch.residual_px = Eigen::Vector2d(0.1, 0.1);
    exterior.patches.push_back(patch);
  }
  const ExteriorResult held = Results({})[1];
  const Vector6d moved = PoseDifference(*held.pose, *exterior.pose);
  EXPECT_TRUE(held.covariance->isApprox(*before[1].covariance + moved * moved.transpose(), 1e-3));
  EXPECT_GT(held.projection_sigma->px, before[1].projection_sigma->px);
  ASSERT_FALSE(held.findings.empty());
  EXPECT_EQ(held.findings.back().reason, Reason::kMovedByBlock);
  for (PatchResult& patch : exterior.patches) patch.residual_px = Eigen::Vector2d(0.5, 0.5);
  EXPECT_TRUE(Results({})[1].covariance->isApprox(*before[1].covariance));
}

TEST_F(FinalResultsOf, ABlockAtRestAreTheAdjustedPoses) {
  const std::vector<ExteriorResult> results = Results({});
  ASSERT_TRUE(adjusted_.result.converged);
  ASSERT_EQ(results.size(), photos_.size());
  for (std::size_t i = 0; i < results.size(); ++i) {
    const ExteriorResult& result = results[i];
    EXPECT_EQ(result.status, Status::kOk);
    ASSERT_TRUE(result.pose && result.covariance && result.alone && result.alone->pose);
    EXPECT_EQ(result.pose->AsVector(), adjusted_.result.photos[i].pose.AsVector());
    EXPECT_EQ(*result.covariance, adjusted_.result.photos[i].covariance);
    EXPECT_EQ(result.alone->pose->AsVector(), photos_[i].exterior.pose->AsVector());
    const Vector6d off = PoseDifference(*result.pose, simulation_.true_poses[i]);
    const Vector6d before = PoseDifference(*result.alone->pose, simulation_.true_poses[i]);
    EXPECT_LT(off.dot(result.covariance->ldlt().solve(off)), 27.9) << "six degrees, 99.99 %";
    EXPECT_LT(off.head<3>().norm(), 0.5 * before.head<3>().norm());
  }
}

// Ties tell what few patches do not; another objection stands.
TEST_F(FinalResultsOf, WhatWasWeakForItsPrecisionOnlyIsOkByItsTies) {
  for (BlockPhotoFile& photo : photos_) {
    photo.exterior.status = Status::kWeak;
    photo.exterior.findings = {{Reason::kFewPlaces, Status::kWeak, 9, 12}};
  }
  photos_[1].exterior.findings.push_back({Reason::kContradictsApproximation, Status::kWeak, 9});
  photos_[2].exterior.findings = {{Reason::kPoorlyDetermined, Status::kWeak, 2, 1}};
  const std::vector<ExteriorResult> results = Results({});
  for (const std::size_t i : {0, 2, 3}) {
    EXPECT_EQ(results[i].status, Status::kOk) << i;
    EXPECT_TRUE(results[i].findings.empty()) << i;
  }
  EXPECT_EQ(results[1].status, Status::kWeak);
  ASSERT_EQ(results[1].findings.size(), 1u);
  EXPECT_EQ(results[1].findings[0].reason, Reason::kContradictsApproximation);
}

// Photos that only the block makes ok hold no others: each would be the other's reason.
TEST_F(FinalResultsOf, AByNeighboursPhotoIsNotOkByPhotosThatOnlyTheBlockMakesOk) {
  const auto depend = [&](const Finding& alone) {
    for (BlockPhotoFile& photo : photos_) {
      photo.exterior.status = StatusOf({alone});
      photo.exterior.findings = {alone};
    }
    photos_[1].by_neighbours = true;
    photos_[1].exterior.status = Status::kOk;
    photos_[1].exterior.findings.clear();
    const std::vector<ExteriorResult> results = Results({});
    EXPECT_EQ(results[0].status, Status::kOk) << JoinedSentences(results[0].findings);
    return results[1];
  };
  EXPECT_EQ(depend({Reason::kByPointsAlone, Status::kOk, 8, 6}).status, Status::kOk);
  const ExteriorResult hanging = depend({Reason::kByPointsAlone, Status::kWeak, 4, 6});
  EXPECT_EQ(hanging.status, Status::kWeak);
  EXPECT_TRUE(Has(hanging.findings, Reason::kNeighboursWeak));
}

// The photo's pose was made with it, the block's without: one of the two is wrong.
TEST_F(FinalResultsOf, APhotoByPointsOfWhichTheBlockRejectsOneIsWeak) {
  for (BlockPoint& point : adjusted_.block.points) point.by_hand = point.control.has_value();
  const auto of_control = std::find_if(
      adjusted_.block.observations.begin(), adjusted_.block.observations.end(),
      [&](const ImageObservation& o) { return o.photo == 0 && o.point >= adjusted_.ties; });
  ASSERT_NE(of_control, adjusted_.block.observations.end());
  adjusted_.surveyed.push_back({"p7", of_control->point});
  photos_[0].exterior.findings = {{Reason::kByPointsAlone, Status::kOk, 12, 6}};
  EXPECT_EQ(Results({})[0].status, Status::kOk);
  of_control->pixel.x() += 60;
  const ExteriorResult rejected = Results({})[0];
  EXPECT_EQ(rejected.status, Status::kWeak);
  ASSERT_TRUE(Has(rejected.findings, Reason::kPointsOffPose));
  EXPECT_EQ(rejected.findings.back().where, "p7");
  photos_[0].exterior.findings.push_back(
      {.reason = Reason::kPointsWrong, .value = 1, .where = "p71, p9"});
  EXPECT_EQ(Results({})[0].status, Status::kWeak) << "others";
  photos_[0].exterior.findings.back().where = "p1, p7";
  EXPECT_EQ(Results({})[0].status, Status::kOk) << "no part of its pose either";
}

// Of a control in one photo only, that photo has no witness.
TEST_F(FinalResultsOf, APhotosOwnPointsAreNoControlElsewhere) {
  photos_[0].exterior.status = Status::kWeak;
  photos_[0].exterior.findings = {{Reason::kByPointsAlone, Status::kWeak, 4, 6}};
  EXPECT_EQ(Results({})[0].status, Status::kOk);
  std::erase_if(adjusted_.block.observations, [&](const ImageObservation& o) {
    return o.photo != 0 && adjusted_.block.points[o.point].control;
  });
  const ExteriorResult alone = Results({})[0];
  EXPECT_EQ(alone.status, Status::kWeak);
  ASSERT_FALSE(alone.findings.empty());
  EXPECT_EQ(alone.findings[0].reason, Reason::kLittleOtherControl);
  EXPECT_EQ(alone.findings[0].value, 0);
}

// Of the block's pose, whatever the photo alone made of them.
TEST_F(FinalResultsOf, PatchesThatAgreeBesideThePoseOfTheBlockMakeItWeak) {
  photos_[1].exterior.findings = {
      {.reason = Reason::kPatchesAgreeElsewhere, .value = 3, .limit = 40, .where = "alone"}};
  const PhotoView view = {simulation_.block.cameras[0], photos_[1].position.photo_from_pixel,
                          simulation_.true_poses[1], nullptr};
  for (int i = 0; i < 60; ++i) {
    const int col = i % 10, row = i / 10;
    PatchResult patch;
    patch.id = i + 1;
    patch.source = 1;
    patch.state = i < 40 ? PatchState::kMatched : PatchState::kRejected;
    patch.ground_m = simulation_.true_poses[1].position_m +
                     Eigen::Vector3d(-400 + 80 * col, -300 + 120 * row, -1500);
    patch.pixel = *view.PixelFromGround(*patch.ground_m) + Eigen::Vector2d(i < 40 ? 0 : 12, 0);
    photos_[1].exterior.patches.push_back(patch);
  }
  const ExteriorResult result = Results({})[1];
  EXPECT_EQ(result.status, Status::kWeak);
  ASSERT_EQ(result.findings.size(), 1u) << JoinedSentences(result.findings);
  EXPECT_EQ(result.findings[0].reason, Reason::kPatchesAgreeElsewhere);
  EXPECT_EQ(result.findings[0].limit, 20);
}

// What is written is interior orientation's film transform and not the one that the adjustment
// moved within its covariance: pose and transform together show what the adjusted photo shows.
TEST_F(FinalResultsOf, PosesGoWithTheFilmTransformOfInteriorOrientation) {
  adjusted_.result = AdjustBlock(adjusted_.block);
  AdjustedPhoto& photo = adjusted_.result.photos[1];
  photo.interior_correction << 2e-6, 4e-6, 4e-6, -2e-6, 0.03, -0.02;  // scale, turn, shift
  const ExteriorResult result =
      FinalResults({photos_, {}, simulation_.block.cameras[0], surface_, "", {}}, adjusted_)[1];
  const PhotoView truly = AdjustedView(adjusted_.block, adjusted_.result, 1);
  PhotoView written = photos_[1].View(simulation_.block.cameras[0]);
  double before = 0, after = 0;
  for (const double x : {-80.0, 0.0, 80.0}) {
    const auto ray = GroundRayFromPhoto(truly.camera, truly.pose, {x, x / 2});
    const Eigen::Vector3d ground =
        ray->origin_m + ray->direction * ((200 - ray->origin_m.z()) / ray->direction.z());
    const Eigen::Vector2d pixel = *truly.PixelFromGround(ground);
    written.pose = photo.pose;
    before = std::max(before, (*written.PixelFromGround(ground) - pixel).norm());
    written.pose = *result.pose;
    after = std::max(after, (*written.PixelFromGround(ground) - pixel).norm());
  }
  EXPECT_GT(before, 1);
  EXPECT_LT(after, 0.02);
}

// What could contradict is not there: a photo whose neighbours the adjustment could not determine
// is not told that its ties speak against it.
TEST_F(FinalResultsOf, TiesWithPhotosThatAreNotDeterminedContradictNobody) {
  adjusted_.result = AdjustBlock(adjusted_.block);
  for (std::size_t i = 1; i < photos_.size(); ++i)
    adjusted_.result.photos[i].state = PhotoState::kUndetermined;
  for (std::size_t i = 0; i < adjusted_.block.observations.size(); ++i)
    if (adjusted_.block.observations[i].point < adjusted_.ties)
      adjusted_.result.observations[i].state = ObservationState::kUnusable;
  const ExteriorResult first =
      FinalResults({photos_, {}, simulation_.block.cameras[0], surface_, "", {}}, adjusted_)[0];
  EXPECT_EQ(first.status, Status::kOk) << testing::PrintToString(Sentences(first.findings));
  adjusted_.result.photos[1].state = PhotoState::kAdjusted;
  const ExteriorResult contradicted =
      FinalResults({photos_, {}, simulation_.block.cameras[0], surface_, "", {}}, adjusted_)[0];
  EXPECT_EQ(contradicted.status, Status::kWeak);
}

TEST_F(FinalResultsOf, OfABlockThatDidNotConvergeAreThePhotosOwnAndWeak) {
  BlockOptions options;
  options.max_rounds = options.max_iterations = 1;
  const std::vector<ExteriorResult> results = Results(options);
  ASSERT_FALSE(adjusted_.result.converged);
  for (std::size_t i = 0; i < results.size(); ++i) {
    EXPECT_EQ(results[i].status, Status::kWeak);
    EXPECT_EQ(results[i].pose->position_m, photos_[i].exterior.pose->position_m);
    ASSERT_FALSE(results[i].findings.empty());
    EXPECT_EQ(results[i].findings.back().reason, Reason::kBlockNotConverged);
  }
}

// A longer principal distance and higher photos show much the same: no photo has moved "away from
// where its own patches put it", and what is judged is the camera that the block found.
TEST_F(FinalResultsOf, ACalibratedBlockContradictsNoPhoto) {
  for (std::size_t i = 0; i < photos_.size(); ++i) {
    photos_[i].exterior.pose = simulation_.true_poses[i];
    photos_[i].exterior.covariance =
        Vector6d(0.1, 0.1, 0.1, 1e-4, 1e-4, 1e-4).cwiseAbs2().asDiagonal();
  }
  adjusted_.result = AdjustBlock(adjusted_.block);
  Camera& camera = adjusted_.result.cameras[0];
  camera.principal_distance_mm += 0.2;
  for (AdjustedPhoto& photo : adjusted_.result.photos)
    photo.pose.position_m.z() += 0.2 / 153 * 1530;
  for (const ExteriorResult& result :
       FinalResults({photos_, {}, simulation_.block.cameras[0], surface_, "", {}}, adjusted_)) {
    EXPECT_EQ(result.status, Status::kOk) << JoinedSentences(result.findings);
  }
}

// Whatever a photo is by GNSS and approximations, it is no better than without them.
TEST_F(FinalResultsOf, ObservedPosesMakeNothingOk) {
  std::vector<ExteriorResult> with = Results({}), without = with;
  without[0].status = Status::kWeak;
  without[0].findings = {{.reason = Reason::kStated, .where = "the pose is poorly determined"}};
  without[1].status = Status::kFailed;
  without[1].pose.reset();
  with[2].status = Status::kWeak;
  HoldToControl(without, &with);
  EXPECT_EQ(with[0].status, Status::kWeak);
  ASSERT_EQ(with[0].findings.size(), 1u);
  EXPECT_EQ(Sentence(with[0].findings.at(0)),
            "without GNSS and approximations it is weak: the pose is poorly determined");
  EXPECT_EQ(with[1].status, Status::kFailed);
  EXPECT_FALSE(with[1].pose);
  EXPECT_EQ(with[2].status, Status::kWeak) << "what speaks against it with them stands";
  EXPECT_EQ(with[3].status, Status::kOk);
  HoldAllToControl(&with);
  EXPECT_EQ(with[1].status, Status::kFailed);
  EXPECT_EQ(with[3].status, Status::kWeak);
}

}  // namespace
}  // namespace orient::block
