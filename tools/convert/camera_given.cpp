#include "tools/convert/camera_given.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/base/error.h"

namespace orient {
namespace {

using Eigen::Vector2d;

// Two calibrations of one camera are closer; other lenses are farther apart.
constexpr double kSameLens = 0.05;
constexpr double kWorthSaying_px = 0.5;

bool HasSize(const ExchangeCamera& camera) { return camera.width > 0 && camera.height > 0; }

double FocalLength_mm(const ExchangeCamera& camera) {
  return camera.focal_px.mean() * camera.pixel_mm;
}

// Frame adjustments state a principal distance in mm and no pixels.
bool HasPixels(const ExchangeCamera& camera) {
  return camera.focal_px.minCoeff() > 0 && camera.principal_px.norm() > 0;
}

// Largest distance (px) in the image between both cameras' projections of a ray; no more than the
// diagonal, as lens models have no meaning far beyond the image.
double LargestDifference_px(const ExchangeCamera& a, const ExchangeCamera& b, int width,
                            int height) {
  constexpr int kSteps = 8;
  double largest = 0;
  for (int i = 0; i <= kSteps; ++i)
    for (int j = 0; j <= kSteps; ++j) {
      const Vector2d pixel(static_cast<double>(width) * i / kSteps,
                           static_cast<double>(height) * j / kSteps);
      const Vector2d plane = (pixel - b.principal_px).cwiseQuotient(b.focal_px);
      const Eigen::Vector3d ray(plane.x(), plane.y(), 1);
      const auto in_a = a.PixelFromCameraPoint(ray), in_b = b.PixelFromCameraPoint(ray);
      if (in_a && in_b) largest = std::max(largest, (*in_a - *in_b).norm());
    }
  return std::min(largest, std::hypot(width, height));
}

bool IsSame(const ExchangeCamera& a, const ExchangeCamera& b, const ExchangeCamera& given) {
  if (HasSize(a) && HasSize(b) && (a.width != b.width || a.height != b.height)) return false;
  if (!HasPixels(a) || !HasPixels(b))  // BINGO states no pixels
    return FocalLength_mm(a) == FocalLength_mm(b) && a.name == b.name;
  return LargestDifference_px(a, b, given.width, given.height) < kWorthSaying_px;
}

void RequireOne(const std::vector<ExchangeCamera>& of_files, const ExchangeCamera& given,
                const std::string& input) {
  for (const ExchangeCamera& camera : of_files)
    if (!IsSame(of_files.front(), camera, given))
      throw InputError(fmt::format(
          "{}: its photos have different cameras ({} and {} for two), but --camera gives one for "
          "all of them; {}convert each camera's photos by themselves",
          input, of_files.front().name, camera.name,
          HasSize(camera) ? "leave --camera out, or " : ""));
}

void RequireSimilar(const ExchangeCamera& file, const ExchangeCamera& given,
                    const std::string& input) {
  if (HasSize(file) && (file.width != given.width || file.height != given.height))
    throw InputError(fmt::format(
        "{}: its images have {} x {} pixels, those of --camera {} x {}; give the camera of these "
        "images, or leave --camera out",
        input, file.width, file.height, given.width, given.height));
  const double in_file = HasPixels(file) ? file.focal_px.mean() : FocalLength_mm(file);
  const double in_camera = HasPixels(file) ? given.focal_px.mean() : FocalLength_mm(given);
  if (in_file <= 0 || std::abs(in_camera / in_file - 1) <= kSameLens) return;
  throw InputError(
      fmt::format("{}: its principal distance is {:.6g} {unit}, that of --camera {:.6g} {unit}; "
                  "give the camera of these images",
                  input, in_file, in_camera, fmt::arg("unit", HasPixels(file) ? "px" : "mm")));
}

}  // namespace

std::string CompareWithGiven(const std::vector<ExchangeCamera>& of_files,
                             const ExchangeCamera& given, const std::string& input) {
  if (of_files.empty()) return "";
  RequireOne(of_files, given, input);
  const ExchangeCamera& file = of_files.front();
  RequireSimilar(file, given, input);
  if (!HasPixels(file)) return "";
  const double differs = LargestDifference_px(file, given, given.width, given.height);
  if (differs < kWorthSaying_px) return "";
  return fmt::format(
      "the camera of --camera is used instead of the one that {} holds: they differ "
      "by up to {:.1f} px in the image",
      input, differs);
}

}  // namespace orient
