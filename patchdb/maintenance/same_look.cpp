#include "patchdb/maintenance/same_look.h"

#include <algorithm>

namespace orient::patchdb {
namespace {

constexpr int kHalf = 12;  // compared: 25 x 25 pixels of the coarser chip

// Mean of the chip's pixels within a square of side_m around a ground position; NaN outside.
float GreyAt(const Patch& patch, const Eigen::Vector2d& place_m, double side_m) {
  const Eigen::Vector2d offset = (place_m - patch.ground_m.head<2>()) / patch.gsd_m;
  const double col = 0.5 * patch.chip.width + offset.x();
  const double row = 0.5 * patch.chip.height - offset.y();
  const double half = 0.5 * std::max(1.0, side_m / patch.gsd_m);
  const int c0 = static_cast<int>(std::floor(col - half + 0.5));
  const int r0 = static_cast<int>(std::floor(row - half + 0.5));
  const int count = std::max(1, static_cast<int>(std::lround(2 * half)));
  if (c0 < 0 || r0 < 0 || c0 + count > patch.chip.width || r0 + count > patch.chip.height)
    return kNoData;
  float sum = 0;
  for (int r = r0; r < r0 + count; ++r)
    for (int c = c0; c < c0 + count; ++c) sum += patch.chip.At(c, r);
  return sum / static_cast<float>(count * count);
}

double Correlation(const std::vector<std::pair<float, float>>& pairs) {
  double n = 0, a = 0, b = 0, aa = 0, bb = 0, ab = 0;
  for (const auto& [x, y] : pairs) {
    if (std::isnan(x) || std::isnan(y)) continue;
    n += 1, a += x, b += y;
    aa += double{x} * double{x}, bb += double{y} * double{y}, ab += double{x} * double{y};
  }
  if (n < 50) return 0;
  const double va = aa - a * a / n, vb = bb - b * b / n;
  return va > 1e-6 && vb > 1e-6 ? (ab - a * b / n) / std::sqrt(va * vb) : 0;
}

}  // namespace

double BestCorrelation(const Patch& a, const Patch& b, int search_px) {
  const double pixel_m = std::max(a.gsd_m, b.gsd_m);
  if (pixel_m > 8 * std::min(a.gsd_m, b.gsd_m)) return 0;
  double best = 0;
  std::vector<std::pair<float, float>> pairs;
  for (int dy = -search_px; dy <= search_px; ++dy)
    for (int dx = -search_px; dx <= search_px; ++dx) {
      pairs.clear();
      for (int row = -kHalf; row <= kHalf; ++row)
        for (int col = -kHalf; col <= kHalf; ++col) {
          const Eigen::Vector2d place = a.ground_m.head<2>() + Eigen::Vector2d(col, row) * pixel_m;
          pairs.emplace_back(GreyAt(a, place, pixel_m),
                             GreyAt(b, place + Eigen::Vector2d(dx, dy) * pixel_m, pixel_m));
        }
      best = std::max(best, Correlation(pairs));
    }
  return best;
}

}  // namespace orient::patchdb
