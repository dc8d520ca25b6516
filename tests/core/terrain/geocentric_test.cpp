#include "core/terrain/geocentric.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>

#include "core/geometry/rotation.h"

namespace orient {
namespace {

// Degrees, minutes, seconds.
double Rad(double degrees, double minutes, double seconds) {
  return RadFromDeg(degrees + minutes / 60 + seconds / 3600);
}

// The example of IOGP's Guidance Note 7-2 (Geographic/Geocentric conversions, EPSG method 9602).
TEST(Geocentric, PublishedExample) {
  const Geodetic at{Rad(53, 48, 33.820), Rad(2, 7, 46.380), 73.0};
  const Eigen::Vector3d geocentric = GeocentricFromGeodetic(at);
  EXPECT_NEAR(geocentric.x(), 3771793.968, 1e-3);
  EXPECT_NEAR(geocentric.y(), 140253.342, 1e-3);
  EXPECT_NEAR(geocentric.z(), 5124304.349, 1e-3);
}

// The same note's topocentric example (EPSG method 9837), origin 55 N 5 E 200 m.
TEST(Geocentric, PublishedTopocentricExample) {
  const Topocentric local({Rad(55, 0, 0), Rad(5, 0, 0), 200});
  const Geodetic at{Rad(53, 48, 33.820), Rad(2, 7, 46.380), 73.0};
  const Eigen::Vector3d enu = local.LocalFromGeocentric(GeocentricFromGeodetic(at));
  EXPECT_NEAR(enu.x(), -189013.869, 1e-3);
  EXPECT_NEAR(enu.y(), -128642.040, 1e-3);
  EXPECT_NEAR(enu.z(), -4220.171, 1e-3);
}

RC_GTEST_PROP(Geocentric, ThereAndBack, ()) {
  const auto between = [](double low, double high) {
    return low + (high - low) * *rc::gen::inRange(0, 1000001) / 1e6;
  };
  const Geodetic at{RadFromDeg(between(-90, 90)), RadFromDeg(between(-179.99, 179.99)),
                    between(-1e4, 1e5)};
  const Geodetic back = GeodeticFromGeocentric(GeocentricFromGeodetic(at));
  RC_ASSERT((GeocentricFromGeodetic(back) - GeocentricFromGeodetic(at)).norm() < 1e-8);
  RC_ASSERT(std::abs(back.height_m - at.height_m) < 1e-8);
}

}  // namespace
}  // namespace orient
