#include "core/terrain/map_scale.h"

#include <fmt/format.h>
#include <ogr_spatialref.h>

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <memory>

#include "core/base/error.h"
#include "core/base/quiet_gdal.h"

namespace orient {
namespace {

// UPS has 0.994 at the pole and UTM 1.001 at its zones' borders: no CRS made for surveying comes
// near. What remains: a height difference dh displaces an image point as if it were 1 % larger.
constexpr double kMostScale = 0.01;
// A pose absorbs the mean of the directions only: half of this is an error of the image, 40 um in
// the corners of 23 cm film. Cassini's grids reach it 200 km from their meridian.
constexpr double kMostBetweenDirections = 0.0005;

std::string Wkt2(const OGRSpatialReference& crs) {
  const char* const options[] = {"FORMAT=WKT2_2019", nullptr};
  char* text = nullptr;
  const bool ok = crs.exportToWkt(&text, options) == OGRERR_NONE && text != nullptr;
  std::string wkt = ok ? text : "";
  CPLFree(text);
  return wkt;
}

// The CRS's own ellipsoid, without a change of datum.
class Ellipsoid {
 public:
  static std::optional<Ellipsoid> Under(const Crs& crs) {
    const QuietGdal quiet;
    OGRSpatialReference map;
    if (map.SetFromUserInput(crs.Wkt().c_str(),
                             OGRSpatialReference::SET_FROM_USER_INPUT_LIMITATIONS_get()) !=
        OGRERR_NONE)
      return std::nullopt;
    const std::unique_ptr<OGRSpatialReference> base(map.CloneGeogCS());
    const std::string wkt = base ? Wkt2(*base) : "";
    if (wkt.empty()) return std::nullopt;
    const double a = base->GetSemiMajor(), inverse_f = base->GetInvFlattening();
    const double f = inverse_f > 0 ? 1 / inverse_f : 0;  // 0 stands for a sphere
    try {
      return Ellipsoid(CoordinateTransform::Between(wkt, crs.Wkt()), a, f * (2 - f),
                       base->GetAngularUnits());
    } catch (const InputError&) {
      return std::nullopt;
    }
  }

  // Geocentric, since longitudes jump at the date line and mean nothing at a pole.
  std::optional<Eigen::Vector3d> Point(const Eigen::Vector2d& xy) const {
    const auto lon_lat = geographic_(xy);
    if (!lon_lat) return std::nullopt;
    const double lon = lon_lat->x() * radian_, lat = lon_lat->y() * radian_;
    const double s = std::sin(lat), c = std::cos(lat);
    const double n = a_ / std::sqrt(1 - e2_ * s * s);  // radius in the prime vertical
    return Eigen::Vector3d(n * c * std::cos(lon), n * c * std::sin(lon), n * (1 - e2_) * s);
  }

  std::optional<MapScale> ScaleAt(const Eigen::Vector2d& xy) const {
    constexpr double kStep_m = 100;  // rounding and curvature are both below 1e-9
    Eigen::Matrix<double, 3, 2> ground_from_map;
    for (int axis = 0; axis < 2; ++axis) {
      const Eigen::Vector2d step = kStep_m * Eigen::Vector2d::Unit(axis);
      const auto before = Point(xy - step), after = Point(xy + step);
      if (!before || !after) return std::nullopt;
      ground_from_map.col(axis) = (*after - *before) / (2 * kStep_m);
    }
    const Eigen::Vector2d lengths =
        Eigen::JacobiSVD<Eigen::Matrix<double, 3, 2>>(ground_from_map).singularValues();
    if (!(lengths.minCoeff() > 0)) return std::nullopt;
    return MapScale{1 / lengths.maxCoeff(), 1 / lengths.minCoeff()};
  }

 private:
  Ellipsoid(CoordinateTransform geographic, double a, double e2, double radian)
      : geographic_(std::move(geographic)), a_(a), e2_(e2), radian_(radian) {}
  CoordinateTransform geographic_;
  double a_, e2_, radian_;  // radian: of a degree, or of a grad
};

std::string Refusal(const Crs& crs, const MapScale& scale, const Eigen::Vector2d& xy) {
  std::string place = fmt::format("x {:.0f}, y {:.0f}", xy.x(), xy.y()), example;
  if (const auto at = CoordinateTransform::Between("EPSG:4326", crs.Wkt())(xy)) {
    const std::string epsg = fmt::format("EPSG:{}", FittingEpsg(at->x(), at->y()));
    place += fmt::format(" ({:.2f} {}, {:.2f} {})", std::abs(at->y()), at->y() < 0 ? "S" : "N",
                         std::abs(at->x()), at->x() < 0 ? "W" : "E");
    example = fmt::format(", for example {} ({})", epsg, Crs::Parse(epsg, epsg).Name());
  }
  return fmt::format(
      "the block's CRS {} has a scale of {:.4f} to {:.4f} at {}; heights do not share it, so that "
      "poses would be wrong; use a CRS true to scale there{}",
      crs.Name(), scale.least, scale.largest, place, example);
}

}  // namespace

std::optional<MapScale> MapScaleAt(const Crs& crs, const Eigen::Vector2d& xy) {
  const auto ellipsoid = Ellipsoid::Under(crs);
  return ellipsoid ? ellipsoid->ScaleAt(xy) : std::nullopt;
}

bool IsTrueToScale(const MapScale& scale) {
  return scale.largest < 1 + kMostScale && scale.least > 1 - kMostScale &&
         scale.largest < scale.least * (1 + kMostBetweenDirections);
}

int FittingEpsg(double longitude_deg, double latitude_deg) {
  if (latitude_deg >= 84) return 5041;
  if (latitude_deg < -80) return 5042;
  const double east_of_date_line =
      longitude_deg + 180 - 360 * std::floor(longitude_deg / 360 + 0.5);
  const int zone = std::clamp(1 + static_cast<int>(east_of_date_line / 6), 1, 60);
  return (latitude_deg < 0 ? 32700 : 32600) + zone;
}

void RefuseFalseScale(const Crs& crs, const Bounds& area) {
  const auto ellipsoid = Ellipsoid::Under(crs);
  if (!ellipsoid) return;
  const Eigen::Vector2d low(area.min_x, area.min_y), high(area.max_x, area.max_y);
  std::optional<MapScale> found;
  Eigen::Vector2d where;
  for (const Eigen::Vector2d& xy :
       {Eigen::Vector2d((low + high) / 2), low, high, Eigen::Vector2d(low.x(), high.y()),
        Eigen::Vector2d(high.x(), low.y())}) {
    const auto scale = ellipsoid->ScaleAt(xy);
    if (!scale) continue;
    if (IsTrueToScale(*scale)) return;
    if (!found) where = xy;
    if (!found) found = scale;
  }
  if (!found) return;
  throw InputError(Refusal(crs, *found, where));
}

}  // namespace orient
