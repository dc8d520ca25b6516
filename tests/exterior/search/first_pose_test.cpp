#include "exterior/search/first_pose.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "exterior/steps/align.h"
#include "tests/exterior/search/photo_of_noise.h"
#include "tests/support/textured_photo.h"

namespace orient::exterior {
namespace {

constexpr int kSide = 400;
constexpr double kWays = 3;  // as stated, finer, doubtful
constexpr int kFirstPatches = 12, kVotingPatches = 160;

// Drawn once for all tests.
const TexturedPhoto& World() {
  static const TexturedPhoto world(kSide, HillsAt, false);
  return world;
}

// Turned by half a turn: the wrong way round.
Affine2d UpsideDown(const Affine2d& photo_from_pixel) {
  const Eigen::Vector2d middle = Eigen::Vector2d::Constant(kSide / 2.0);
  return {-photo_from_pixel.A, photo_from_pixel.t + 2 * photo_from_pixel.A * middle};
}

// The patch with a chip twice as large: it can be searched for at a level coarser.
patchdb::Patch TwiceAsLarge(patchdb::Patch patch) {
  constexpr int kChip = 101, kNodes = 25, kMiddle = kNodes / 2;
  constexpr double kStep_m = 10, kGsd_m = TexturedPhoto::kGsd_m;
  const double x = patch.ground_m.x(), y = patch.ground_m.y();
  patch.chip = Image(kChip, kChip);
  for (int row = 0; row < kChip; ++row)
    for (int col = 0; col < kChip; ++col) {
      const Eigen::Vector2d from_middle(col + 0.5 - kChip / 2.0, kChip / 2.0 - row - 0.5);
      patch.chip.At(col, row) =
          static_cast<float>(World().Ground().At(patch.ground_m.head<2>() / kGsd_m + from_middle));
    }
  patch.heights = {kNodes, kStep_m, {}};
  for (int row = 0; row < kNodes; ++row)
    for (int col = 0; col < kNodes; ++col)
      patch.heights.heights_m.push_back(static_cast<float>(
          HillsAt(x + kStep_m * (col - kMiddle), y - kStep_m * (row - kMiddle))));
  return patch;
}

// Blurred away is what a patch shows at a coarse level; fine detail remains, and what other ground
// looks like from far.
patchdb::Patch OfFineDetailOnly(patchdb::Patch patch) {
  constexpr int kBlur = 2;
  constexpr double kOther = 0.6;
  static const Texture other(9, 20);
  const Image chip = patch.chip;
  for (int row = 0; row < chip.height; ++row)
    for (int col = 0; col < chip.width; ++col) {
      double sum = 0, count = 0;
      for (int r = std::max(0, row - kBlur); r <= std::min(chip.height - 1, row + kBlur); ++r)
        for (int c = std::max(0, col - kBlur); c <= std::min(chip.width - 1, col + kBlur); ++c) {
          sum += chip.At(c, r);
          ++count;
        }
      const double far = other.At({col + 71.0 * static_cast<double>(patch.id), row + 13.0});
      patch.chip.At(col, row) =
          static_cast<float>(chip.At(col, row) - sum / count + 128 + kOther * (far - 128));
    }
  return patch;
}

class FirstPoseOfTexture : public testing::Test {
 protected:
  FirstPoseOfTexture() { Approximate(1, 1); }

  // An approximation said to be good to 10 m and a degree times `sigmas`, and off by `off` of that.
  void Approximate(double sigmas, double off) {
    photo_.prior.pose = truth_;
    photo_.prior.pose.position_m += sigmas * off * Eigen::Vector3d(8, -7, 5);
    photo_.prior.pose.opk_rad += sigmas * off * Eigen::Vector3d(0.015, -0.012, 0.02);
    Vector6d sigma;
    sigma << 10, 10, 10, 0.02, 0.02, 0.02;
    photo_.prior.covariance = (sigmas * sigma).cwiseAbs2().asDiagonal();
  }

  PhotoTask Task() const { return {photo_, World().File(), patches_, options_}; }
  std::optional<PoseTrack> Find() const { return FirstPose(Task()); }
  std::string WhyNot() const {
    const Finding why = WhyNoFirstPose(Task());
    EXPECT_EQ(why.reason, Reason::kNoFirstPose);
    EXPECT_EQ(why.at_best, Status::kFailed);
    return why.where;
  }

  std::vector<PatchPrediction> Seen(const PosePrior& prior) const {
    return Predict(Task().View(photo_.positions.front(), prior.pose), prior.covariance, patches_,
                   Task().Prediction());
  }
  std::vector<PatchPrediction> Voting(const PosePrior& prior) const {
    return SelectSpread(Seen(prior), patches_, kVotingPatches, Task().Prediction());
  }
  double WindowOf(const PosePrior& prior) const {
    return LargestRadius(Voting(prior), kWindowSigmas);
  }
  // Only so many of those that the approximation sees.
  void KeepVisible(std::size_t count) {
    std::vector<patchdb::Patch> kept;
    for (const PatchPrediction& seen : Seen(photo_.prior))
      if (kept.size() < count) kept.push_back(patches_[seen.patch]);
    ASSERT_EQ(kept.size(), count);
    patches_ = kept;
  }

  bool Convinces(const PoseTrack& track) const {
    return track.log10_false_alarms < options_.max_log10_false_alarms;
  }
  double WorstError(const Pose& pose) const { return World().WorstError(pose, patches_); }

  const Pose truth_ = World().View().pose;
  PhotoToOrient photo_ = World().ToOrient();
  OrientPhotoOptions options_;
  std::vector<patchdb::Patch> patches_ = World().Patches(World().Ground(), 4, 85);
};

// A poor one, so that a few patches in large windows convince.
TEST_F(FirstPoseOfTexture, OfAnHonestApproximationIsThatOfTheFirstFewPatches) {
  Approximate(3, 1);
  const auto track = Find();
  ASSERT_TRUE(track);
  EXPECT_TRUE(Convinces(*track));
  EXPECT_LT(WorstError(track->pose), 2);
  ASSERT_EQ(track->rounds.size(), 2u);
  EXPECT_EQ(track->rounds[0].searched, kFirstPatches);
  EXPECT_DOUBLE_EQ(track->rounds[0].window_px, WindowOf(photo_.prior));
  // The others around where that pose sees them.
  EXPECT_GT(track->rounds[1].searched, 4 * kFirstPatches);
  EXPECT_LT(track->rounds[1].window_px, 0.2 * track->rounds[0].window_px);
}

TEST_F(FirstPoseOfTexture, IsThatOfAllPatchesWhereAFewLeaveItToChance) {
  patches_ = World().Patches(World().Ground(), 2, 130);
  const auto track = Find();
  ASSERT_TRUE(track);
  EXPECT_TRUE(Convinces(*track));
  ASSERT_EQ(track->rounds.size(), 1u) << "nothing is left to be sought around it";
  EXPECT_EQ(track->rounds[0].searched, std::ssize(Seen(photo_.prior)));
  EXPECT_GT(track->rounds[0].searched, kFirstPatches);
}

TEST_F(FirstPoseOfTexture, IsSoughtAtOnceWithSeventeenPatchesAndInTwoBatchesWithEighteen) {
  KeepVisible(18);
  auto track = Find();
  ASSERT_TRUE(track);
  EXPECT_EQ(track->trials, kWays * 2);
  KeepVisible(17);
  track = Find();
  ASSERT_TRUE(track);
  EXPECT_EQ(track->trials, kWays * 1);
  EXPECT_EQ(track->rounds[0].searched, 17);
}

TEST_F(FirstPoseOfTexture, OfAnApproximationWorseThanItIsSaidToBeIsFoundInTwiceTheWindow) {
  Approximate(1, 5);
  const auto track = Find();
  ASSERT_TRUE(track);
  EXPECT_TRUE(Convinces(*track));
  EXPECT_LT(WorstError(track->pose), 2);
  PosePrior doubtful = photo_.prior;
  doubtful.covariance *= 4;
  const double height = doubtful.pose.position_m.z() - patches_.front().ground_m.z();
  for (int i = 0; i < 3; ++i) doubtful.covariance(i, i) += std::pow(0.03 * height, 2);
  EXPECT_DOUBLE_EQ(track->rounds[0].window_px, WindowOf(doubtful));
  EXPECT_GT(track->rounds[0].window_px, 2 * WindowOf(photo_.prior));
}

// Patches that look like other ground from far are no reason to search wider.
TEST_F(FirstPoseOfTexture, OfFineDetailIsFoundAtAFinerLevelInTheStatedWindow) {
  for (patchdb::Patch& patch : patches_) patch = TwiceAsLarge(patch);
  const auto coarse = Find();
  ASSERT_TRUE(coarse);
  ASSERT_EQ(coarse->reduction, 4);
  for (patchdb::Patch& patch : patches_) patch = OfFineDetailOnly(patch);
  const auto fine = Find();
  ASSERT_TRUE(fine);
  EXPECT_TRUE(Convinces(*fine));
  EXPECT_LT(WorstError(fine->pose), 3);
  EXPECT_EQ(fine->reduction, 2);
  EXPECT_DOUBLE_EQ(fine->rounds[0].window_px, WindowOf(photo_.prior));
}

TEST_F(FirstPoseOfTexture, CountsEveryWayInWhichItIsSought) {
  const auto trials = [&](const std::vector<double>& turns) {
    photo_.positions.clear();
    const Affine2d right = World().View().photo_from_pixel;
    for (const double turn : turns)
      photo_.positions.push_back({turn == 0 ? right : UpsideDown(right), std::nullopt});
    const auto track = Find();
    return track ? track->trials : -1;
  };
  const double batches = 3;  // 12, 24 and the rest
  EXPECT_EQ(trials({0}), kWays * batches);
  EXPECT_EQ(trials({0, 180}), kWays * batches * 2);
  EXPECT_EQ(trials({180, 0, 180}), kWays * batches * 3);
}

TEST_F(FirstPoseOfTexture, IsThatOfTheFilmPositionThatFitsWhicheverComesFirst) {
  const Affine2d right = World().View().photo_from_pixel;
  const FilmPosition fits{right, ScanOrientation::kR90};
  const FilmPosition upside_down{UpsideDown(right), ScanOrientation::kR0};
  for (const bool last : {false, true}) {
    photo_.positions = {fits, upside_down};
    if (last) std::swap(photo_.positions[0], photo_.positions[1]);
    const auto track = Find();
    ASSERT_TRUE(track);
    EXPECT_TRUE(Convinces(*track));
    EXPECT_EQ(track->position.orientation, ScanOrientation::kR90);
    EXPECT_LT(WorstError(track->pose), 2);
  }
}

// A film that lies so or is stretched: by either the patches agree, by one of them more do.
TEST_F(FirstPoseOfTexture, OfTwoFilmPositionsThatConvinceIsTheBetter) {
  const Affine2d right = World().View().photo_from_pixel;
  Affine2d stretched = right;
  stretched.A.col(0) *= 1.04;
  stretched.t.x() *= 1.04;
  const FilmPosition fits{right, ScanOrientation::kR90};
  const FilmPosition fits_less{stretched, ScanOrientation::kR0};
  photo_.positions = {fits_less};
  ASSERT_TRUE(Find() && Convinces(*Find())) << "else there is nothing to choose from";
  for (const bool last : {false, true}) {
    photo_.positions = {fits, fits_less};
    if (last) std::swap(photo_.positions[0], photo_.positions[1]);
    const auto track = Find();
    ASSERT_TRUE(track);
    EXPECT_EQ(track->position.orientation, ScanOrientation::kR90);
  }
}

// What chance explains is handed on as what all patches said, so that it can be told.
TEST_F(FirstPoseOfTexture, OfPatchesOfAnotherPlaceIsOneThatChanceExplains) {
  patches_ = World().Patches(Texture(6, 6), 4, 85);
  const auto track = Find();
  ASSERT_TRUE(track);
  EXPECT_FALSE(Convinces(*track));
  ASSERT_EQ(track->rounds.size(), 1u);
  EXPECT_GT(track->rounds[0].searched, 4 * kFirstPatches);
}

TEST_F(FirstPoseOfTexture, IsThatOfAHundredAndSixtyPatchesAtMost) {
  patches_ = World().Patches(World().Ground(), 8, 42);
  for (const double sigmas : {1.0, 3.0}) {
    Approximate(sigmas, 1);
    ASSERT_GT(Seen(photo_.prior).size(), 180u);
    const auto track = Find();
    ASSERT_TRUE(track);
    EXPECT_TRUE(Convinces(*track));
    for (const LoopRound& round : track->rounds) EXPECT_LE(round.searched, kVotingPatches);
    EXPECT_GT(track->rounds.back().searched, 140);
  }
}

// Another kappa than stated is what the whole photo is searched for, and not here.
TEST_F(FirstPoseOfTexture, IsNotSoughtAtAnotherKappaThanStated) {
  photo_.prior.pose = truth_;
  photo_.prior.pose.opk_rad.z() += 1.5;
  const auto track = Find();
  if (track) {
    EXPECT_FALSE(Convinces(*track));
  }
  photo_.prior.pose = truth_;
  ASSERT_TRUE(Find());
  EXPECT_TRUE(Convinces(*Find()));
}

TEST_F(FirstPoseOfTexture, IsFoundInItsSectorWhereKappaIsOpen) {
  constexpr double kTrials = 1000;
  for (const double off_rad : {0.3, 1.5, 3.1, -2.2}) {
    Approximate(1, 1);
    photo_.prior.pose.opk_rad.z() = truth_.opk_rad.z() + off_rad;
    photo_.prior.covariance(5, 5) = std::numbers::pi * std::numbers::pi;
    const WholePhotoSearch search = FirstPoseByKappa(Task(), kTrials);
    EXPECT_TRUE(search.searched);
    ASSERT_TRUE(search.track) << off_rad;
    EXPECT_TRUE(Convinces(*search.track)) << off_rad;
    EXPECT_EQ(search.track->trials, kTrials) << "all searches count";
    EXPECT_LT(WorstError(search.track->pose), 4) << off_rad;
  }
}

TEST_F(FirstPoseOfTexture, IsSoughtBeyondTheKappasAllowedOnlyIfThereItWasNotFound) {
  Approximate(1, 1);
  photo_.prior.pose.opk_rad.z() = truth_.opk_rad.z() + 1.5;
  photo_.prior.covariance(5, 5) = 0.25 * 0.25;
  const WholePhotoSearch allowed = FirstPoseByKappa(Task(), KappaTrials(Task()));
  EXPECT_TRUE(allowed.searched && allowed.complete);
  EXPECT_FALSE(allowed.track && Convinces(*allowed.track));
  options_.prior_failed = true;
  const WholePhotoSearch all = FirstPoseByKappa(Task(), KappaTrials(Task()));
  ASSERT_TRUE(all.track);
  EXPECT_TRUE(Convinces(*all.track));
  EXPECT_LT(WorstError(all.track->pose), 4);
}

TEST_F(FirstPoseOfTexture, AtAnyKappaIsNotSoughtWithThreePatches) {
  photo_.prior.pose = truth_;
  photo_.prior.covariance(5, 5) = std::numbers::pi * std::numbers::pi;
  KeepVisible(3);
  EXPECT_FALSE(FirstPoseByKappa(Task(), KappaTrials(Task())).searched);
}

// Film turned by half a turn with kappa turned back is the same image: nothing is sought twice.
TEST_F(FirstPoseOfTexture, AtAnyKappaIsSoughtOnceWhereFilmPositionsLookTheSame) {
  Approximate(1, 1);
  photo_.prior.pose.opk_rad.z() = truth_.opk_rad.z() + 3.1;
  photo_.prior.covariance(5, 5) = std::numbers::pi * std::numbers::pi;
  FilmPosition turned = photo_.positions.front();
  turned.photo_from_pixel = UpsideDown(turned.photo_from_pixel);
  photo_.positions.push_back(turned);
  const WholePhotoSearch search = FirstPoseByKappa(Task(), KappaTrials(Task()));
  ASSERT_TRUE(search.track);
  EXPECT_TRUE(Convinces(*search.track));
  const PhotoView found = Task().View(search.track->position, search.track->pose);
  for (const patchdb::Patch& patch : patches_)
    if (const auto expected = World().View().PixelFromGround(patch.ground_m)) {
      EXPECT_LT((found.PixelFromGround(patch.ground_m).value() - *expected).norm(), 4);
    }
}

TEST_F(FirstPoseOfTexture, AtAnyKappaOfPatchesOfAnotherPlaceIsOneThatChanceExplains) {
  patches_ = World().Patches(Texture(77, 20), 4, 85);
  photo_.prior.covariance(5, 5) = std::numbers::pi * std::numbers::pi;
  const WholePhotoSearch search = FirstPoseByKappa(Task(), KappaTrials(Task()));
  EXPECT_TRUE(search.searched);
  EXPECT_FALSE(search.track && Convinces(*search.track));
}

TEST_F(FirstPoseOfTexture, OfPatchesOutOfSightIsNoneAndTheirNumberIsSaid) {
  photo_.prior.pose.position_m.x() += 10000;
  EXPECT_FALSE(Find());
  EXPECT_NE(WhyNot().find("none of the 81 patches"), std::string::npos) << WhyNot();
}

TEST_F(FirstPoseOfTexture, OfPatchesSmallerThanElevenPixelsIsNoneAndThatIsSaid) {
  bool enough = false, too_small = false;
  for (double height = truth_.position_m.z(); height < 4500; height += 200) {
    photo_.prior.pose.position_m.z() = height;
    const PhotoView view = Task().View(photo_.positions.front(), photo_.prior.pose);
    double largest = 0;
    for (const PatchPrediction& seen : Seen(photo_.prior))
      largest = std::max(largest, PatchSide(view, patches_[seen.patch]).value_or(0));
    const bool is_too_small = WhyNot().find("are smaller than 11 px") != std::string::npos;
    EXPECT_EQ(is_too_small, largest < 11) << largest;
    if (is_too_small) {
      EXPECT_FALSE(Find()) << largest;
    }
    (is_too_small ? too_small : enough) = true;
  }
  EXPECT_TRUE(enough && too_small);
}

TEST(FirstPose, OfABlankPhotoIsNone) {
  PhotoOfNoise photo(600, true);
  photo.SetSigma(20);
  EXPECT_FALSE(FirstPose(photo.Task()));
  EXPECT_NE(WhyNoFirstPose(photo.Task()).where.find("fewer than three"), std::string::npos);
}

// Three million pixels a patch: 1732 squared is less, 1733 squared is more.
TEST(FirstPose, IsNotSoughtInWindowsThatWouldTakeMinutes) {
  PhotoOfNoise large(1733);
  large.SetSigma(5);
  const auto track = FirstPose(large.Task());
  ASSERT_TRUE(track) << "small windows of a large photo are no matter";
  EXPECT_LT(track->log10_false_alarms, -6);
  large.SetSigma(1000);  // three of them are more than half of the photo
  EXPECT_FALSE(FirstPose(large.Task()));
  EXPECT_NE(WhyNoFirstPose(large.Task()).where.find("too uncertain"), std::string::npos);
  PhotoOfNoise smaller(1732);
  smaller.SetSigma(1000);
  EXPECT_EQ(WhyNoFirstPose(smaller.Task()).where.find("too uncertain"), std::string::npos);
}

class Descending : public FirstPoseOfTexture {
 protected:
  // From a pose off by some pixels, at a level.
  PoseTrack From(int reduction) const {
    PoseTrack track;
    track.position = photo_.positions.front();
    track.pose = truth_;
    track.pose.position_m += Eigen::Vector3d(6, -4, 3);
    Vector6d sigma;
    sigma << 6, 6, 6, 0.002, 0.002, 0.002;
    track.covariance = sigma.cwiseAbs2().asDiagonal();
    track.reduction = reduction;
    track.rounds = {{10, 10, 99, 1}};
    track.trials = 7;
    return track;
  }
};

TEST_F(Descending, VotesAtEveryLevelAboveFullResolution) {
  for (patchdb::Patch& patch : patches_) patch = TwiceAsLarge(patch);
  for (const auto& [from, rounds] : {std::pair(8, 3u), {4, 2u}, {2, 1u}, {1, 1u}}) {
    PoseTrack track = From(from);
    const double before = WorstError(track.pose);
    Descend(Task(), 1, &track);
    EXPECT_EQ(track.rounds.size(), rounds) << from;
    EXPECT_EQ(track.rounds.front().window_px, 99) << "what led here stays told";
    EXPECT_EQ(track.trials, 7);
    if (from > 2) {
      EXPECT_EQ(track.reduction, 2) << from;
      EXPECT_LT(WorstError(track.pose), 0.3 * before) << from;
      EXPECT_TRUE(Convinces(track)) << from;
    } else {
      EXPECT_EQ(track.reduction, from);
      EXPECT_EQ(WorstError(track.pose), before) << from;
    }
  }
}

TEST_F(Descending, EndsAtTheFinestLevelThatIsWanted) {
  for (patchdb::Patch& patch : patches_) patch = TwiceAsLarge(patch);
  for (const auto& [finest, rounds] : {std::pair(2, 3u), {3, 2u}, {4, 2u}, {5, 1u}}) {
    PoseTrack track = From(8);
    Descend(Task(), finest, &track);
    EXPECT_EQ(track.rounds.size(), rounds) << finest;
  }
}

TEST_F(Descending, TakesNoEvidenceAway) {
  PoseTrack track = From(4);
  track.log10_false_alarms = -1000;
  Descend(Task(), 1, &track);
  ASSERT_EQ(track.rounds.size(), 2u);
  EXPECT_EQ(track.log10_false_alarms, -1000);
}

TEST_F(Descending, FourPatchesMoveThePoseAndThreeLeaveItAsItIs) {
  KeepVisible(4);
  PoseTrack track = From(4);
  Descend(Task(), 1, &track);
  EXPECT_EQ(track.rounds.size(), 2u);
  EXPECT_NE(track.pose.position_m, From(4).pose.position_m);
  KeepVisible(3);
  track = From(4);
  Descend(Task(), 1, &track);
  EXPECT_EQ(track.rounds.size(), 1u);
  EXPECT_EQ(track.pose.position_m, From(4).pose.position_m);
  EXPECT_EQ(track.reduction, 4);
}

}  // namespace
}  // namespace orient::exterior
