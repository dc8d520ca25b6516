// Geodetic, geocentric and topocentric coordinates of the WGS 84 ellipsoid, in closed form.
#pragma once

#include <Eigen/Core>

namespace orient {

struct Geodetic {
  double latitude_rad = 0, longitude_rad = 0;
  double height_m = 0;  // above the ellipsoid
};

// Earth-centred, earth-fixed (EPSG:4978): z to the north pole, x to the meridian of Greenwich.
Eigen::Vector3d GeocentricFromGeodetic(const Geodetic& at);
// To better than 1e-9 m for heights between -10 km and 1000 km.
Geodetic GeodeticFromGeocentric(const Eigen::Vector3d& geocentric_m);

// East, north, up at an origin: a Cartesian system that touches the ellipsoid there.
class Topocentric {
 public:
  explicit Topocentric(const Geodetic& origin);
  Eigen::Vector3d LocalFromGeocentric(const Eigen::Vector3d& geocentric_m) const;
  Eigen::Vector3d GeocentricFromLocal(const Eigen::Vector3d& local_m) const;
  const Eigen::Matrix3d& GeocentricFromLocalRotation() const { return rotation_; }

 private:
  Eigen::Vector3d origin_;
  Eigen::Matrix3d rotation_;
};

}  // namespace orient
