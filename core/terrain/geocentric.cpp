#include "core/terrain/geocentric.h"

#include <cmath>

namespace orient {
namespace {

constexpr double kSemiMajor_m = 6378137.0;
constexpr double kFlattening = 1 / 298.257223563;
constexpr double kEccentricity2 = kFlattening * (2 - kFlattening);

// Radius of curvature in the prime vertical.
double PrimeVertical(double sin_latitude) {
  return kSemiMajor_m / std::sqrt(1 - kEccentricity2 * sin_latitude * sin_latitude);
}

}  // namespace

Eigen::Vector3d GeocentricFromGeodetic(const Geodetic& at) {
  const double s = std::sin(at.latitude_rad), c = std::cos(at.latitude_rad);
  const double n = PrimeVertical(s);
  return {(n + at.height_m) * c * std::cos(at.longitude_rad),
          (n + at.height_m) * c * std::sin(at.longitude_rad),
          (n * (1 - kEccentricity2) + at.height_m) * s};
}

Geodetic GeodeticFromGeocentric(const Eigen::Vector3d& p) {
  // Bowring's iteration of the reduced latitude; three rounds are below the last digit.
  const double distance = std::hypot(p.x(), p.y());
  const double semi_minor = kSemiMajor_m * (1 - kFlattening);
  const double second2 = kEccentricity2 / (1 - kEccentricity2);
  double reduced = std::atan2(p.z(), (1 - kFlattening) * distance);
  double latitude = 0;
  for (int i = 0; i < 3; ++i) {
    const double s = std::sin(reduced), c = std::cos(reduced);
    latitude = std::atan2(p.z() + second2 * semi_minor * s * s * s,
                          distance - kEccentricity2 * kSemiMajor_m * c * c * c);
    reduced = std::atan2((1 - kFlattening) * std::sin(latitude), std::cos(latitude));
  }
  const double s = std::sin(latitude), c = std::cos(latitude);
  // Along the normal: without a division that fails at the poles or at the equator.
  const double height = distance * c + p.z() * s - kSemiMajor_m * kSemiMajor_m / PrimeVertical(s);
  return {latitude, std::atan2(p.y(), p.x()), height};
}

Topocentric::Topocentric(const Geodetic& origin) : origin_(GeocentricFromGeodetic(origin)) {
  const double sl = std::sin(origin.longitude_rad), cl = std::cos(origin.longitude_rad);
  const double sp = std::sin(origin.latitude_rad), cp = std::cos(origin.latitude_rad);
  rotation_ << -sl, -sp * cl, cp * cl,  //
      cl, -sp * sl, cp * sl,            //
      0, cp, sp;
}

Eigen::Vector3d Topocentric::LocalFromGeocentric(const Eigen::Vector3d& geocentric_m) const {
  return rotation_.transpose() * (geocentric_m - origin_);
}

Eigen::Vector3d Topocentric::GeocentricFromLocal(const Eigen::Vector3d& local_m) const {
  return origin_ + rotation_ * local_m;
}

}  // namespace orient
