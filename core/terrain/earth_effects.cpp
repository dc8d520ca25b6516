#include "core/terrain/earth_effects.h"

#include <algorithm>
#include <cmath>

namespace orient {
namespace {

constexpr double kNegligiblePx = 0.1;

double PixelSize(const Camera& camera, double film_pixel_mm) {
  if (camera.kind != CameraKind::kDigital || !camera.image_px) return film_pixel_mm;
  return camera.frame_mm.x() / camera.image_px->x();
}

}  // namespace

const std::map<std::string, EarthMode>& EarthModes() {
  static const std::map<std::string, EarthMode> modes = {
      {"auto", EarthMode::kAuto}, {"flat", EarthMode::kFlat}, {"curved", EarthMode::kCurved}};
  return modes;
}

std::string Name(EarthMode mode) {
  return std::find_if(EarthModes().begin(), EarthModes().end(),
                      [&](const auto& named) { return named.second == mode; })
      ->first;
}

double RefractionOfStandardAtmosphere(double flying_m, double ground_m) {
  const auto term = [](double height_m) {
    const double km = std::clamp(height_m, 0.0, 15e3) / 1000;
    return km / (km * km - 6 * km + 250);
  };
  const double ground_share = std::max(ground_m, 0.0) / std::max(flying_m, 1.0);
  return std::max(0.0, 0.00241 * (term(flying_m) - term(ground_m) * ground_share));
}

double EarthDistortion(double principal_distance_mm, double flying_m, double ground_m) {
  const double height_m = std::max(flying_m - ground_m, 0.0);
  return (RefractionOfStandardAtmosphere(flying_m, ground_m) - height_m / (2 * kEarthRadius_m)) /
         (principal_distance_mm * principal_distance_mm);
}

double LargestUnabsorbed(const Camera& camera, double k1) {
  // Over a rectangle of half sides a and b, the multiple of r nearest to r^3 is <r^4> / <r^2>.
  const double a2 = std::pow(camera.frame_mm.x() / 2, 2);
  const double b2 = std::pow(camera.frame_mm.y() / 2, 2);
  const double absorbed = (a2 * a2 / 5 + 2 * a2 * b2 / 9 + b2 * b2 / 5) / ((a2 + b2) / 3);
  const double corner = std::sqrt(a2 + b2), inside = std::sqrt(absorbed / 3);
  const auto left = [&](double r) { return std::abs(k1 * r * (r * r - absorbed)); };
  return std::max(left(corner), left(inside));
}

Camera WithEarthEffects(const Camera& camera, EarthMode mode, double flying_m, double ground_m,
                        double film_pixel_mm) {
  const double k1 = EarthDistortion(camera.principal_distance_mm, flying_m, ground_m);
  const bool matters =
      LargestUnabsorbed(camera, k1) > kNegligiblePx * PixelSize(camera, film_pixel_mm);
  if (mode == EarthMode::kFlat || (mode == EarthMode::kAuto && !matters)) return camera;
  return WithEarth(camera, k1);
}

Camera WithEarth(const Camera& camera, double k1) {
  if (k1 == 0) return camera;
  Camera other = camera;
  other.lens = WithRadial(camera.lens, {k1, 0, 0}, 1.2 * camera.FrameRadius());
  other.earth_k1 += k1;
  return other;
}

double CurvatureOf(const Camera& camera, double ground_m) {
  if (camera.earth_k1 == 0) return 0;
  // The flying height at which both effects together give earth_k1; curvature grows faster.
  double low = 0, high = 1e5;
  for (int i = 0; i < 60; ++i) {
    const double middle = (low + high) / 2;
    const double k1 = EarthDistortion(camera.principal_distance_mm, ground_m + middle, ground_m);
    (k1 > camera.earth_k1 ? low : high) = middle;
  }
  return -low / (2 * kEarthRadius_m * camera.principal_distance_mm * camera.principal_distance_mm);
}

}  // namespace orient
