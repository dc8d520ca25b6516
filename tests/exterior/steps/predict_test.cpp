// Which patches are sought where: windows from the pose's covariance, and what is not to be seen.
#include "exterior/steps/predict.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "tests/exterior/digital_view.h"

namespace orient::exterior {
namespace {

constexpr double kTop_m = 5000;  // of the projection centre

// Vertical, kappa 0, above (0, 0); 90 degrees of field across.
PhotoView VerticalView() {
  PhotoView view = DigitalView();
  view.camera.principal_distance_mm = 83;
  view.camera.frame_mm = {166, 166};
  view.camera.image_px = Eigen::Vector2i(1000, 1000);
  view.photo_from_pixel = DigitalPhotoFromPixel(view.camera);
  view.pose = {{0, 0, kTop_m}, {0, 0, 0}};
  return view;
}

patchdb::Patch PatchAt(double x_m, double y_m, double z_m = 0) {
  patchdb::Patch patch;
  patch.ground_m = {x_m, y_m, z_m};
  patch.covariance_m2 = Eigen::Vector3d(0.04, 0.04, 0.25).asDiagonal();
  return patch;
}

Matrix6d Covariance(double position_m, double attitude_rad) {
  Vector6d sigma;
  sigma << Eigen::Vector3d::Constant(position_m), Eigen::Vector3d::Constant(attitude_rad);
  return sigma.cwiseAbs2().asDiagonal();
}

// Flat at 0 but for a wall of `wall_m` between x = 3000 and 3100, nodes 20 m apart.
GroundSurface Wall(float wall_m, float datum_m = 0) {
  const int cells = 500;
  Eigen::MatrixXf heights = Eigen::MatrixXf::Constant(cells, cells, datum_m);
  heights.middleCols(400, 5).array() += wall_m;
  return GroundSurface::FromGrid(heights, -5000, 5000, 20);
}

std::map<Unseen, int> NotSeen(const std::vector<patchdb::Patch>& patches,
                              const PredictionOptions& options, double sigma_m = 1) {
  std::vector<UnseenPatch> unseen;
  Predict(VerticalView(), Covariance(sigma_m, 1e-4), patches, options, &unseen);
  std::map<Unseen, int> counts;
  for (const UnseenPatch& patch : unseen) ++counts[patch.why];
  return counts;
}

using Counts = std::map<Unseen, int>;
const PredictionOptions kWhole{1000, 1000, 8};

TEST(Predict, GivesEachPatchTheWindowThatThePosesCovarianceAsksFor) {
  const auto predictions =
      Predict(VerticalView(), Covariance(10, 0), {PatchAt(0, 0)}, kWhole, nullptr);
  ASSERT_EQ(predictions.size(), 1u);
  EXPECT_NEAR((predictions[0].pixel - Eigen::Vector2d(500, 500)).norm(), 0, 1e-9);
  // 10 m and the patch's 0.2 m, at 10 m a pixel.
  EXPECT_NEAR(predictions[0].Radius(1).x(), std::sqrt(100 + 0.04) / 10, 1e-6);
}

TEST(Predict, SaysWhichPatchesLieBehindTheCameraOrOutsideThePhoto) {
  EXPECT_EQ(NotSeen({PatchAt(0, 0, kTop_m + 10), PatchAt(6000, 0), PatchAt(4000, 0)}, kWhole),
            (Counts{{Unseen::kBehindCamera, 1}, {Unseen::kOutsidePhoto, 1}}));
}

TEST(Predict, DoesNotSeekPatchesUnderMarksAndWriting) {
  PredictionOptions options = kWhole;
  options.covered = {{{-2, -2}, {2, 2}}};  // mm about the middle; 8 px more are too near
  const double metres_per_mm = kTop_m / 83;
  EXPECT_EQ(NotSeen({PatchAt(0, 0), PatchAt(3 * metres_per_mm, 0), PatchAt(4 * metres_per_mm, 0)},
                    options),
            (Counts{{Unseen::kCovered, 2}}));
}

TEST(Predict, DoesNotSeekWhatAMountainHides) {
  const GroundSurface surface = Wall(1000);
  PredictionOptions options = kWhole;
  options.surface = &surface;
  // The wall's shadow ends at 3100 + 1000 * 3100 / 4000.
  EXPECT_EQ(
      NotSeen({PatchAt(3200, 0), PatchAt(3700, 0), PatchAt(4000, 0), PatchAt(2900, 0)}, options),
      (Counts{{Unseen::kHidden, 2}}));
}

TEST(Predict, SeeksWhatOnlyAnUncertainPoseWouldHide) {
  const GroundSurface surface = Wall(1000);
  PredictionOptions options = kWhole;
  options.surface = &surface;
  const std::vector<patchdb::Patch> near_the_edge = {PatchAt(3800, 0)};
  EXPECT_EQ(NotSeen(near_the_edge, options), (Counts{{Unseen::kHidden, 1}}));
  EXPECT_EQ(NotSeen(near_the_edge, options, 500), Counts{});
}

// A DEM of another datum must be reported, not take all patches away.
TEST(Predict, HidesNothingByAHeightDatum) {
  for (const float datum_m : {-50.0F, 50.0F}) {
    const GroundSurface surface = Wall(0, datum_m);
    PredictionOptions options = kWhole;
    options.surface = &surface;
    EXPECT_EQ(NotSeen({PatchAt(3200, 0), PatchAt(0, 0), PatchAt(-4000, 4000)}, options), Counts{});
  }
}

TEST(Predict, HidesNothingByHeightsThatAreMissing) {
  const GroundSurface surface = Wall(std::nanf(""));
  PredictionOptions options = kWhole;
  options.surface = &surface;
  EXPECT_EQ(NotSeen({PatchAt(3200, 0)}, options), Counts{});
}

// Not those at one side.
TEST(SelectSpread, OfMoreCellsThanWantedTakesSomeAllOverThePhoto) {
  std::vector<patchdb::Patch> patches;
  for (int i = -12; i <= 12; ++i)
    for (int j = -12; j <= 12; ++j) patches.push_back(PatchAt(380.0 * i, 380.0 * j));
  const auto all = Predict(VerticalView(), Covariance(10, 0), patches, kWhole, nullptr);
  for (const int count : {12, 30, 50, 70}) {
    const auto selected = SelectSpread(all, patches, count, kWhole);
    ASSERT_EQ(selected.size(), static_cast<std::size_t>(count));
    for (const double left : {0.0, 500.0})
      for (const double top : {0.0, 500.0}) {
        const auto in_quarter = std::count_if(selected.begin(), selected.end(), [&](const auto& p) {
          return p.pixel.x() >= left && p.pixel.x() < left + 500 && p.pixel.y() >= top &&
                 p.pixel.y() < top + 500;
        });
        EXPECT_NEAR(static_cast<double>(in_quarter), count / 4.0, 1 + count / 10.0) << count;
      }
  }
}

}  // namespace
}  // namespace orient::exterior
