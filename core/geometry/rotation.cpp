#include "core/geometry/rotation.h"

#include <cmath>
#include <numbers>

namespace orient {
namespace {

constexpr double kPi = std::numbers::pi;
// If cos(phi) is below this, omega and kappa rotate about the same axis, within double precision.
constexpr double kGimbalLockCosine = 1e-13;

}  // namespace

double RadFromDeg(double angle_deg) { return angle_deg * (kPi / 180.0); }

double DegFromRad(double angle_rad) { return angle_rad * (180.0 / kPi); }

double NormalizeAngle(double angle_rad) {
  const double angle = std::remainder(angle_rad, 2 * kPi);
  return angle <= -kPi ? kPi : angle;
}

Eigen::Matrix3d GroundFromPhotoRotation(const Eigen::Vector3d& opk_rad) {
  const double so = std::sin(opk_rad[0]), co = std::cos(opk_rad[0]);
  const double sp = std::sin(opk_rad[1]), cp = std::cos(opk_rad[1]);
  const double sk = std::sin(opk_rad[2]), ck = std::cos(opk_rad[2]);
  Eigen::Matrix3d r;
  r << cp * ck, -cp * sk, sp,                                    //
      co * sk + so * sp * ck, co * ck - so * sp * sk, -so * cp,  //
      so * sk - co * sp * ck, so * ck + co * sp * sk, co * cp;
  return r;
}

Eigen::Vector3d OpkFromRotation(const Eigen::Matrix3d& r) {
  const double cos_phi = std::hypot(r(1, 2), r(2, 2));
  const double phi = std::atan2(r(0, 2), cos_phi);
  const double omega = cos_phi < kGimbalLockCosine ? 0 : std::atan2(-r(1, 2), r(2, 2));
  // kappa from the rotation left without omega: the three angles then give the same rotation
  // even where omega itself is uncertain, close to the gimbal lock.
  const double so = std::sin(omega), co = std::cos(omega);
  const double kappa = std::atan2(co * r(1, 0) + so * r(2, 0), co * r(1, 1) + so * r(2, 1));
  return {NormalizeAngle(omega), phi, NormalizeAngle(kappa)};
}

}  // namespace orient
