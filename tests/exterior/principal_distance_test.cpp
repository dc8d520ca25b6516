// What the patches say of the camera's principal distance, once a pose has been found with it.
#include "exterior/principal_distance.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/raster/raster.h"
#include "exterior/steps/photo_image.h"
#include "exterior/steps/resect.h"
#include "tests/exterior/digital_view.h"
#include "tests/support/shared_data.h"

namespace orient::exterior {
namespace {

constexpr double kNoisePx = 0.1;

// A photo tilted by 45 degrees over 300 m of relief, with patches in the nearer two thirds only.
struct Tilted {
  PhotoToOrient photo;
  std::vector<patchdb::Patch> patches;
  ExteriorResult result;
};

void AddMatch(const PhotoView& truth, const Eigen::Vector3d& ground,
              const Eigen::Vector2d& error_px, Tilted* tilted) {
  const auto pixel = truth.PixelFromGround(ground);
  if (!pixel || pixel->minCoeff() < 0 || pixel->x() > 640 || pixel->y() > 1152) return;
  if (pixel->y() < 400) return;
  patchdb::Patch patch;
  patch.id = std::ssize(tilted->patches) + 1;
  patch.ground_m = ground;
  patch.covariance_m2 = 1e-4 * Eigen::Matrix3d::Identity();
  PatchResult match;
  match.id = patch.id;
  match.ground_m = ground;
  match.state = PatchState::kMatched;
  match.pixel = *pixel + error_px;
  match.sigma_px = Eigen::Vector2d::Constant(kNoisePx);
  tilted->patches.push_back(std::move(patch));
  tilted->result.patches.push_back(std::move(match));
}

// The pose that the camera file's principal distance leads to, as the photo's orientation finds it.
void Orient(const PhotoView& truth, Tilted* tilted) {
  PhotoView view = truth;
  view.camera = tilted->photo.camera;
  std::vector<PatchObservation> observations;
  for (std::size_t i = 0; i < tilted->patches.size(); ++i)
    observations.push_back({tilted->patches[i].ground_m, *tilted->result.patches[i].pixel,
                            kNoisePx * kNoisePx * Eigen::Matrix2d::Identity()});
  const auto estimate = EstimatePose(view, tilted->photo.prior, observations);
  ASSERT_TRUE(estimate);
  tilted->result.pose = estimate->pose;
  tilted->result.covariance = estimate->honest_covariance;
  const double sigma_px = WorstProjectionSigma(view, estimate->honest_covariance, 500);
  tilted->result.projection_sigma = ProjectionSigma{sigma_px, sigma_px};
  for (const ResidualTrend& trend : estimate->trends)
    tilted->result.findings.push_back({.reason = Reason::kResidualTrend, .value = trend.rms_px});
}

// Of level ground below, the principal distance is what the flying height leaves of it.
Tilted Level() {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> unit;
  PhotoView truth = DigitalView();
  Tilted level;
  level.photo.camera = truth.camera;
  level.photo.positions = {{truth.photo_from_pixel, std::nullopt}};
  level.photo.prior = PriorOf(truth.pose, {30, 0.02}, random);
  for (int i = 0; i < 300; ++i)
    AddMatch(truth,
             {truth.pose.position_m.x() + 8000 * (unit(random) - 0.5),
              truth.pose.position_m.y() + 8000 * (unit(random) - 0.5), 500},
             kNoisePx * Eigen::Vector2d(normal(random), normal(random)), &level);
  Orient(truth, &level);
  level.result.status = Status::kOk;
  return level;
}

Tilted Make(double wrong_mm) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> unit;
  PhotoView truth = DigitalView();
  truth.pose = {{1000, 2000, 5000}, {std::numbers::pi / 4, 0, 0}};
  Tilted tilted;
  tilted.photo.camera = truth.camera;
  tilted.photo.camera.principal_distance_mm += wrong_mm;
  tilted.photo.positions = {{truth.photo_from_pixel, std::nullopt}};
  tilted.photo.prior = PriorOf(truth.pose, {30, 0.02}, random);
  for (int i = 0; i < 2000; ++i)
    AddMatch(
        truth,
        {1000 + 8000 * (unit(random) - 0.5), 2000 + 20000 * unit(random), 500 + 300 * unit(random)},
        kNoisePx * Eigen::Vector2d(normal(random), normal(random)), &tilted);
  Orient(truth, &tilted);
  return tilted;
}

const Finding* Contradiction(const ExteriorResult& result) {
  for (const Finding& finding : result.findings)
    if (finding.reason == Reason::kPrincipalDistanceContradicted) return &finding;
  return nullptr;
}

TEST(JudgePrincipalDistance, AWrongOneThatThePoseHasFollowedIsWeakAndTheRightOneNamed) {
  Tilted tilted = Make(2);
  ASSERT_GT(tilted.patches.size(), 50u);
  tilted.result.status = Status::kOk;
  JudgePrincipalDistance(tilted.photo, tilted.patches, &tilted.result);
  const Finding* finding = Contradiction(tilted.result);
  ASSERT_NE(finding, nullptr) << JoinedSentences(tilted.result.findings);
  EXPECT_EQ(tilted.result.status, Status::kWeak);
  EXPECT_NEAR(*finding->value, 120, 0.2);
  EXPECT_EQ(finding->limit, 122);
}

TEST(JudgePrincipalDistance, OfTheRightOneNothingIsSaid) {
  Tilted tilted = Make(0);
  tilted.result.status = Status::kOk;
  JudgePrincipalDistance(tilted.photo, tilted.patches, &tilted.result);
  EXPECT_EQ(Contradiction(tilted.result), nullptr);
  // Even where a trend of something else asks for it.
  tilted.result.findings.push_back({.reason = Reason::kResidualTrend, .value = 0.1});
  JudgePrincipalDistance(tilted.photo, tilted.patches, &tilted.result);
  EXPECT_EQ(Contradiction(tilted.result), nullptr);
  EXPECT_EQ(tilted.result.status, Status::kOk);
}

TEST(JudgePrincipalDistance, EdgesSayNothingOfIt) {
  Tilted tilted = Make(2);
  for (std::size_t i = 0; i < 10; ++i) {
    PatchResult& match = tilted.result.patches[5 * i];
    *match.pixel += Eigen::Vector2d(15, 15);
    match.sigma_px = Eigen::Vector2d::Constant(35);  // along 45 degrees nothing is known
  }
  tilted.result.status = Status::kOk;
  JudgePrincipalDistance(tilted.photo, tilted.patches, &tilted.result);
  const Finding* finding = Contradiction(tilted.result);
  ASSERT_NE(finding, nullptr) << JoinedSentences(tilted.result.findings);
  EXPECT_NEAR(*finding->value, 120, 0.2);
}

TEST(JudgePrincipalDistance, AnApproximationThatThePoseContradictsDoesNotSpeakAgainstIt) {
  Tilted level = Level();
  ASSERT_GT(level.patches.size(), 50u);
  level.result.findings.push_back({.reason = Reason::kResidualTrend, .value = 0.1});
  level.photo.prior.pose.position_m.z() += 400;
  JudgePrincipalDistance(level.photo, level.patches, &level.result);
  EXPECT_EQ(Contradiction(level.result), nullptr) << JoinedSentences(level.result.findings);
}

class EstimatedPrincipalDistanceOfLevelGround : public testing::Test {
 protected:
  ExteriorResult Estimate(double approximation_off_m) {
    level_.photo.prior.pose.position_m.z() = DigitalView().pose.position_m.z();
    level_.photo.prior.pose.position_m.z() += approximation_off_m;
    WritePng(folder_ / "a.png", 8, 8, 1, std::vector<unsigned char>(64, 100));
    const Raster raster = Raster::Open(folder_ / "a.png");
    // The image is only needed where the principal distance changes.
    return OrientWithPrincipalDistance(level_.photo, PhotoImage(raster, false), level_.patches, {},
                                       level_.result, 0.5);
  }
  TemporaryFolder folder_;
  Tilted level_ = Level();
};

TEST_F(EstimatedPrincipalDistanceOfLevelGround, DoesNotTakeUpTheErrorOfTheApproximation) {
  const ExteriorResult result = Estimate(400);
  ASSERT_TRUE(result.principal_distance) << JoinedSentences(result.findings);
  EXPECT_NEAR(result.principal_distance->value_mm, 120, 0.1);
  EXPECT_NEAR(result.pose->position_m.z(), 5000, 10);
  EXPECT_GT(std::sqrt((*result.covariance)(2, 2)), 15) << "0.5 mm are 19 m of flying height";
}

TEST_F(EstimatedPrincipalDistanceOfLevelGround, LeavesTheProjectionPreciseWhichStaysOk) {
  const ExteriorResult result = Estimate(0);
  EXPECT_EQ(result.status, Status::kOk) << JoinedSentences(result.findings);
  ASSERT_TRUE(result.projection_sigma);
  EXPECT_LT(result.projection_sigma->px, 0.5) << "the flying height's error is made up for";
}

TEST_F(EstimatedPrincipalDistanceOfLevelGround, IsJudgedByTheTargetAllOverTheFrame) {
  level_.result.target_m = 0.1;
  const ExteriorResult result = Estimate(0);
  EXPECT_EQ(result.status, Status::kWeak);
  EXPECT_TRUE(Has(result.findings, Reason::kPoorlyDetermined));
}

TEST(JudgePrincipalDistance, OfAPhotoWithoutPoseNothingIsSaid) {
  Tilted tilted = Make(2);
  tilted.result.pose.reset();
  tilted.result.status = Status::kFailed;
  const std::size_t before = tilted.result.findings.size();
  JudgePrincipalDistance(tilted.photo, tilted.patches, &tilted.result);
  EXPECT_EQ(tilted.result.findings.size(), before);
}

}  // namespace
}  // namespace orient::exterior
