#include "core/geometry/earth_effects.h"

#include <algorithm>
#include <cmath>

namespace orient {
namespace {

constexpr double kFilmPixel_mm = 0.025;
constexpr double kNegligiblePx = 0.1;
constexpr double kTableStep_mm = 2;

double PixelSize(const Camera& camera) {
  if (camera.kind != CameraKind::kDigital || !camera.image_px) return kFilmPixel_mm;
  return camera.frame_mm.x() / camera.image_px->x();
}

// The table's own radii and enough others for a cubic to be straight between them, as far as the
// frame may reach.
RadialTable TableWithCubic(const RadialTable& table, double k1, double reach_mm) {
  std::vector<double> radii = table.radius_mm;
  for (double r = 0; r < reach_mm + kTableStep_mm; r += kTableStep_mm) radii.push_back(r);
  std::sort(radii.begin(), radii.end());
  radii.erase(std::unique(radii.begin(), radii.end()), radii.end());
  RadialTable sum;
  for (const double r : radii) {
    sum.radius_mm.push_back(r);
    sum.dr_um.push_back(1e3 * (DistortionAt(table, {r, 0}).x() + k1 * r * r * r));
  }
  return sum;
}

LensDistortion LensWithCubic(const Camera& camera, double k1) {
  if (const auto* table = std::get_if<RadialTable>(&camera.lens))
    return TableWithCubic(*table, k1, 1.2 * camera.FrameRadius());
  BrownDistortion brown;
  if (const auto* own = std::get_if<BrownDistortion>(&camera.lens)) brown = *own;
  brown.k[0] += k1;
  return brown;
}

}  // namespace

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

EarthCamera OverEarth(const Camera& camera, EarthMode mode, double flying_m, double ground_m) {
  const double k1 = EarthDistortion(camera.principal_distance_mm, flying_m, ground_m);
  const bool matters = LargestUnabsorbed(camera, k1) > kNegligiblePx * PixelSize(camera);
  if (mode == EarthMode::kFlat || (mode == EarthMode::kAuto && !matters)) return {camera, false, 0};
  return {WithCubic(camera, k1), true, k1};
}

Camera WithCubic(const Camera& camera, double k1) {
  Camera other = camera;
  other.lens = LensWithCubic(camera, k1);
  return other;
}

}  // namespace orient
