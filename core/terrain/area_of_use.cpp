#include "core/terrain/area_of_use.h"

#include <fmt/format.h>
#include <ogr_spatialref.h>

#include <Eigen/Geometry>

#include "core/base/quiet_gdal.h"

namespace orient {
namespace {

struct Degrees {
  double west = 0, south = 0, east = 0, north = 0;
};

std::optional<Degrees> AreaOfUse(const std::string& definition) {
  const QuietGdal quiet;
  OGRSpatialReference crs;
  if (crs.SetFromUserInput(definition.c_str(),
                           OGRSpatialReference::SET_FROM_USER_INPUT_LIMITATIONS_get()) !=
      OGRERR_NONE)
    return std::nullopt;
  Degrees area;
  if (!crs.GetAreaOfUse(&area.west, &area.south, &area.east, &area.north, nullptr))
    return std::nullopt;
  if (area.west < -180 || area.south < -90) return std::nullopt;  // stated as unknown
  if (area.east < area.west) area.east += 360;                    // across the date line
  return area;
}

// A .prj in WKT1 names the CRS, not its area.
std::optional<Degrees> AreaOfUse(const Crs& crs) {
  if (const auto area = AreaOfUse(crs.Wkt())) return area;
  const auto code = crs.Epsg();
  return code ? AreaOfUse(fmt::format("EPSG:{}", *code)) : std::nullopt;
}

// Bounds of the area's outline in the CRS's own coordinates; empty if PROJ transforms none of it.
Eigen::AlignedBox2d BoxOf(const Degrees& area, const Crs& crs) {
  constexpr int kPieces = 20;
  const auto transform = CoordinateTransform::Between(crs.Wkt(), "EPSG:4326");
  Eigen::AlignedBox2d box;
  for (int i = 0; i <= kPieces; ++i) {
    const double part = static_cast<double>(i) / kPieces;
    const double lon = area.west + part * (area.east - area.west);
    const double lat = area.south + part * (area.north - area.south);
    for (const Eigen::Vector2d& at :
         {Eigen::Vector2d(lon, area.south), Eigen::Vector2d(lon, area.north),
          Eigen::Vector2d(area.west, lat), Eigen::Vector2d(area.east, lat)})
      if (const auto xy = transform(at)) box.extend(*xy);
  }
  return box;
}

}  // namespace

bool MayHold(const Crs& crs, const Eigen::Vector2d& xy) {
  constexpr double kNearZero_m = 100e3;
  const auto area = AreaOfUse(crs);
  if (!area) return true;
  const Eigen::AlignedBox2d box = BoxOf(*area, crs);
  if (box.isEmpty() || box.contains(xy)) return true;
  if (xy.cwiseAbs().maxCoeff() < kNearZero_m) return false;
  const Eigen::Vector2d margin = 0.5 * box.sizes();
  return Eigen::AlignedBox2d(box.min() - margin, box.max() + margin).contains(xy);
}

}  // namespace orient
