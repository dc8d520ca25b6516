#include "exterior/steps/patch_observation.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/geometry/collinearity.h"
#include "core/matching/least_squares_matching.h"
#include "exterior/steps/error_model.h"
#include "exterior/steps/linearised_matches.h"

namespace orient::exterior {
namespace {

// An orthophoto does not show heights: its patches' Z hardly depends on those it was made with, and
// has the surface's error. The Z of a photo's patches follows the heights, but less so if several
// photos show them, as they are then known better than the heights (place.h).
bool IsOfOrthophoto(const patchdb::Patch& patch) {
  constexpr double kShare = 0.5;
  return patch.height_effect->z() < kShare &&
         patch.covariance_m2(2, 2) > kShare * *patch.height_sigma_m * *patch.height_sigma_m;
}

}  // namespace

PatchObservation ObservationOf(const patchdb::Patch& patch, const Eigen::Vector2d& pixel,
                               const Eigen::Matrix2d& covariance_px2, const PhotoView& view) {
  PatchObservation observation{patch.ground_m, pixel, covariance_px2};
  observation.source = patch.source_id;
  observation.covariance_px2 +=
      kMatchModelSigma_px * kMatchModelSigma_px * Eigen::Matrix2d::Identity();
  if (patch.height_effect && patch.height_sigma_m) {
    observation.height_effect = *patch.height_effect;
    observation.height_sigma_m = *patch.height_sigma_m;
    if (IsOfOrthophoto(patch)) {
      const Eigen::Vector3d by_heights = *patch.height_effect * *patch.height_sigma_m;
      const Eigen::Matrix3d rest = patch.covariance_m2 - by_heights * by_heights.transpose();
      observation.surface_sigma_m = std::sqrt(patch.covariance_m2(2, 2));
      observation.source_sigma_px =
          kSharedBySource * std::sqrt(std::max(rest.topLeftCorner<2, 2>().trace() / 2, 0.0)) /
          view.GroundPixel(patch.ground_m.z());
    }
    return observation;
  }
  if (const auto d = PhotoFromGroundWithDerivatives(view.camera, view.pose, patch.ground_m)) {
    const Eigen::Matrix<double, 2, 3> by_ground = view.photo_from_pixel.A.inverse() * d->by_ground;
    const Eigen::Matrix2d of_ground = by_ground * patch.covariance_m2 * by_ground.transpose();
    const double without_ground_px2 = OwnVariance(observation);
    observation.covariance_px2 += of_ground;
    observation.ground_px2 = OwnVariance(observation) - without_ground_px2;
  }
  return observation;
}

CommonErrors CommonErrorsOf(const FilmPosition& position, const PhotoView& view, double ground_m) {
  CommonErrors common;
  common.interior = position.covariance;
  common.film_sigma_px = position.film_sigma_mm / view.PixelSize();
  common.film_correlation_px =
      kFilmCorrelationPerFrame * view.camera.frame_mm.minCoeff() / view.PixelSize();
  common.half_frame_px = view.camera.frame_mm.maxCoeff() / view.PixelSize() / 2;
  common.height_correlation_m =
      std::max(kHeightCorrelationPerHeight * std::abs(view.pose.position_m.z() - ground_m), 1.0);
  return common;
}

}  // namespace orient::exterior
