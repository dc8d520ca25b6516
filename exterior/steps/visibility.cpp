#include "exterior/steps/visibility.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace orient::exterior {
namespace {

constexpr double kTolerancePerCell = 0.25;
constexpr double kTolerance_m = 2;
constexpr double kSigmas = 3;
constexpr int kMaxSteps = 100;  // narrower ridges than the steps may be missed

}  // namespace

Reason ReasonOf(Unseen why) {
  switch (why) {
    case Unseen::kBehindCamera:
      return Reason::kPatchBehindCamera;
    case Unseen::kOutsidePhoto:
      return Reason::kPatchOutsidePhoto;
    case Unseen::kCovered:
      return Reason::kPatchCovered;
    case Unseen::kHidden:
      return Reason::kPatchHidden;
  }
  throw std::invalid_argument("ReasonOf: not an Unseen");
}

bool HiddenByTerrain(const GroundSurface& surface, const Eigen::Vector3d& projection_centre_m,
                     const Eigen::Matrix3d& centre_covariance_m2, const Eigen::Vector3d& ground_m) {
  const auto start_m = surface.HeightAt(ground_m.x(), ground_m.y());
  if (!start_m) return false;
  const Eigen::Vector2d across = projection_centre_m.head<2>() - ground_m.head<2>();
  const double length_m = across.norm(), rise_m = projection_centre_m.z() - *start_m;
  if (!(length_m > surface.CellSize()) || !(rise_m > 0)) return false;
  // Beyond, the ray is above all ground.
  const double slope = rise_m / length_m;
  const double reach_m = std::min(length_m, (surface.MaxHeight() - *start_m) / slope);
  const double step_m = std::max(surface.CellSize(), reach_m / kMaxSteps);
  // Standard deviation of the ray's height at its upper end.
  const double end_sigma_m =
      std::sqrt(centre_covariance_m2(2, 2) +
                slope * slope * centre_covariance_m2.topLeftCorner<2, 2>().trace());
  const double tolerance_m = kTolerance_m + kTolerancePerCell * surface.CellSize();
  for (double s = step_m; s < reach_m; s += step_m) {
    const Eigen::Vector2d at = ground_m.head<2>() + across * (s / length_m);
    const auto height_m = surface.HeightAt(at.x(), at.y());
    const double ray_m = *start_m + slope * s;
    if (height_m && *height_m > ray_m + tolerance_m + kSigmas * end_sigma_m * s / length_m)
      return true;
  }
  return false;
}

}  // namespace orient::exterior
