#include "interior/marks/stroke_profile.h"

#include <algorithm>
#include <numbers>

namespace orient::interior {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

constexpr double kScannerBlurPx = 0.7;  // typical, a pixel's own area included
constexpr double kSharpOpticsPx = 0.5;  // before a pixel's area averages; sharper ones alias
// Where a stroke's sides are sampled, from its edge; share of their effect that is corrected, as
// edges of the picture also lie a little off the stroke.
constexpr double kSideFromPx = 0.8, kSideWidthPx = 1.5, kSideShare = 0.85;
constexpr double kClearOfCrossing = 2.0;  // sigmas of the smoothing

double NormalBelow(double x) { return 0.5 * std::erfc(-x / std::numbers::sqrt2); }

// The smoothed slope at the middle of an opaque stroke whose two sides differ by 1: what lies
// beside the stroke is not seen through it.
double SideResponse(const Stroke& stroke) {
  constexpr double kStep = 0.1;
  double product = 0, squares = 0;
  for (double u = -3.5; u <= 3.5; u += kStep) {
    const double y = u * stroke.smoothing_px, weight = std::exp(-0.5 * u * u) * u;
    const double side = 0.5 * (NormalBelow((y - stroke.half_width_px) / kScannerBlurPx) -
                               NormalBelow((-y - stroke.half_width_px) / kScannerBlurPx));
    product += weight * side;
    squares += weight * u;
  }
  return product / squares / stroke.smoothing_px;
}

// Difference of the two sides of a stroke in column x, the lower one minus the upper one. NaN
// where a side is not seen.
double SideDifference(const Plane& plane, int x, double y, const Stroke& stroke) {
  const double near = stroke.half_width_px + kSideFromPx, far = near + kSideWidthPx;
  double below = 0, above = 0, belows = 0, aboves = 0;
  const int last = static_cast<int>(std::floor(y + far));
  for (int row = static_cast<int>(std::floor(y - far)); row <= last; ++row) {
    const double u = row + 0.5 - y;
    const double part = std::clamp(std::abs(u) + 0.5 - near, 0.0, 1.0) *
                        std::clamp(far + 0.5 - std::abs(u), 0.0, 1.0);
    if (part <= 0) continue;
    (u < 0 ? above : below) += part * plane.At(x, row);
    (u < 0 ? aboves : belows) += part;
  }
  return below / belows - above / aboves;
}

}  // namespace

Stroke StrokeOf(const CrossElement& cross, double angle_rad, const Matrix2d& pixel_from_mm,
                double blur_px) {
  const Vector2d along = pixel_from_mm * Vector2d(std::cos(angle_rad), std::sin(angle_rad));
  const Vector2d normal = Vector2d(-along.y(), along.x()).normalized();
  const Vector2d across = pixel_from_mm * Vector2d(-std::sin(angle_rad), std::cos(angle_rad));
  const double width_px = cross.width_mm * std::abs(across.dot(normal));
  Stroke stroke;
  stroke.steep = std::abs(along.y()) > std::abs(along.x());
  const Vector2d d = stroke.steep ? Vector2d(along.y(), along.x()) : along;
  stroke.slope = d.y() / d.x();
  const double per_mm = std::abs(d.x()), cosine = per_mm / d.norm();
  const double sigma = std::sqrt(width_px * width_px / 12 + blur_px * blur_px);
  stroke.smoothing_px = sigma / cosine;
  stroke.half_width_px = 0.5 * width_px / cosine;
  stroke.side_response = SideResponse(stroke);
  // The other stroke, as wide as this one, hides the crossing.
  const double clear_px = (0.5 * width_px + kClearOfCrossing * sigma) * cosine;
  stroke.from_px = std::max(0.5 * cross.gap_mm * per_mm + sigma, clear_px);
  stroke.to_px = 0.5 * cross.length_mm * per_mm - sigma;
  return stroke;
}

Profile ProfileAt(const Plane& plane, int x, double y, const Stroke& stroke) {
  Profile profile;
  const double sigma = stroke.smoothing_px;
  profile.side_effect = stroke.side_response * SideDifference(plane, x, y, stroke);
  if (!std::isfinite(profile.side_effect)) return profile;
  const int first = static_cast<int>(std::floor(y - 3.5 * sigma));
  const int last = static_cast<int>(std::floor(y + 3.5 * sigma));
  double sum = 0, sum_u2 = 0, sum_u4 = 0, v0 = 0, v1 = 0, v2 = 0;
  for (int row = first; row <= last; ++row) {
    const double value = plane.At(x, row);
    if (!std::isfinite(value)) return profile;
    const double u = (row + 0.5 - y) / sigma, weight = std::exp(-0.5 * u * u);
    sum += weight;
    sum_u2 += weight * u * u;
    sum_u4 += weight * u * u * u * u;
    v0 += weight * value;
    v1 += weight * u * value;
    v2 += weight * u * u * value;
  }
  // The parabola fitted with Gaussian weights, which are even to 1e-4: value = g0 + g1 u + g2 u^2.
  profile.g1 = v1 / sum_u2 / sigma - kSideShare * profile.side_effect;
  profile.g2 = (v2 * sum - v0 * sum_u2) / (sum_u4 * sum - sum_u2 * sum_u2) / (sigma * sigma);
  profile.seen = true;
  return profile;
}

double AliasingOf(const Stroke& stroke) {
  constexpr int kMiddle = 20, kRows = 2 * kMiddle + 1, kSubpixels = 8;
  const double y = kMiddle + 0.25;
  Image profile(1, kRows, 0);
  for (int row = 0; row < kRows; ++row) {
    double seen = 0;
    for (int i = 0; i < kSubpixels; ++i)
      for (int j = 0; j < kSubpixels; ++j) {
        const double middle = y + stroke.slope * ((i + 0.5) / kSubpixels - 0.5);
        const double off = row + (j + 0.5) / kSubpixels - middle;
        seen += NormalBelow((off + stroke.half_width_px) / kSharpOpticsPx) -
                NormalBelow((off - stroke.half_width_px) / kSharpOpticsPx);
      }
    profile.At(0, row) = static_cast<float>(seen / (kSubpixels * kSubpixels));
  }
  const Profile top = ProfileAt(Plane(profile, false), 0, y, stroke);
  return top.seen && top.g2 < 0 ? -top.g1 / (2 * top.g2) : 0;
}

}  // namespace orient::interior
