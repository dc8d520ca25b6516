#include "tools/convert/placed_poses.h"

#include <fmt/format.h>

#include "core/base/error.h"
#include "core/terrain/area_of_use.h"

namespace orient {
namespace {

using Eigen::Vector3d;

Vector3d MeanCentre(const ExchangeBlock& block) {
  Vector3d mean = Vector3d::Zero();
  for (const ExchangePhoto& photo : block.photos) mean += photo.centre;
  return mean / static_cast<double>(block.photos.size());
}

std::string Called(const Crs& crs) {
  const auto code = crs.Epsg();
  return code ? fmt::format("EPSG:{}", *code) : crs.Name();
}

void RequireOnTheEarth(const Vector3d& geocentric, const ForeignBlock& foreign,
                       const std::string& input) {
  constexpr double kLeast_m = 6.3e6, kMost_m = 6.5e6;
  const double radius = geocentric.norm();
  if (radius > kLeast_m && radius < kMost_m) return;
  throw InputError(fmt::format(
      "{}: the poses are around {:.0f} {:.0f} {:.0f}, which as geocentric coordinates is {:.0f} km "
      "from the earth's centre: {}",
      input, geocentric.x(), geocentric.y(), geocentric.z(), radius / 1000, foreign.if_misplaced));
}

}  // namespace

void RequirePlaced(const ForeignBlock& foreign, const GroundFrame& frame, const Crs& crs,
                   const std::string& input) {
  if (foreign.block.photos.empty()) return;
  const Vector3d mean = MeanCentre(foreign.block);
  if (!mean.allFinite()) return;  // which is complained about by photo
  if (foreign.geocentric) RequireOnTheEarth(mean, foreign, input);
  const auto at = frame.BlockFromFile(mean);
  if (!at || MayHold(crs, at->head<2>())) return;
  throw InputError(
      fmt::format("{}: the poses are around {:.0f} {:.0f}, far outside the area of {}: {}", input,
                  at->x(), at->y(), Called(crs), foreign.if_misplaced));
}

}  // namespace orient
