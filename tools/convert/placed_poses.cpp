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

void RequireMayHold(const Crs& crs, const Vector3d& mean, const std::string& input,
                    const std::string& remedy) {
  if (MayHold(crs, mean.head<2>())) return;
  throw InputError(
      fmt::format("{}: the poses are around {:.0f} {:.0f}, far outside the area of {}: {}", input,
                  mean.x(), mean.y(), Called(crs), remedy));
}

}  // namespace

void RequireInArea(const OrientationTable& table, const Crs& crs, const std::string& path) {
  Vector3d mean = Vector3d::Zero();
  for (const OrientationRow& row : table.rows) mean += row.pose.position_m;
  mean /= static_cast<double>(table.rows.size());
  if (!table.rows.empty() && mean.allFinite())
    RequireMayHold(crs, mean, path, "name the CRS that the table is in with --crs");
}

void RequirePlaced(const ForeignBlock& foreign, const GroundFrame& frame, const Crs& crs,
                   const std::string& input) {
  if (foreign.block.photos.empty()) return;
  const Vector3d mean = MeanCentre(foreign.block);
  if (!mean.allFinite()) return;  // which is complained about by photo
  if (foreign.geocentric) RequireOnTheEarth(mean, foreign, input);
  const auto at = frame.BlockFromFile(mean);
  if (at) RequireMayHold(crs, *at, input, foreign.if_misplaced);
}

}  // namespace orient
