#include "patchdb/store/patch.h"

#include <algorithm>

namespace orient::patchdb {

double HeightGrid::At(double east_m, double north_m) const {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  if (size < 1 || !(step_m > 0)) return nan;
  const double half = 0.5 * (size - 1);
  const double col = half + east_m / step_m;
  const double row = half - north_m / step_m;
  if (!(col >= 0 && row >= 0 && col <= size - 1 && row <= size - 1)) return nan;
  const int c0 = std::min(static_cast<int>(col), std::max(size - 2, 0));
  const int r0 = std::min(static_cast<int>(row), std::max(size - 2, 0));
  const int c1 = std::min(c0 + 1, size - 1), r1 = std::min(r0 + 1, size - 1);
  const double u = col - c0, v = row - r0;
  const auto node = [&](int r, int c) {
    return static_cast<double>(heights_m[static_cast<std::size_t>(r * size + c)]);
  };
  return (1 - v) * ((1 - u) * node(r0, c0) + u * node(r0, c1)) +
         v * ((1 - u) * node(r1, c0) + u * node(r1, c1));
}

const char* Name(SourceKind kind) {
  switch (kind) {
    case SourceKind::kPhoto:
      return "photo";
    case SourceKind::kOrthophoto:
      return "orthophoto";
    case SourceKind::kGcp:
      break;
  }
  return "gcp";
}

const char* Name(PatchLife life) { return life == PatchLife::kActive ? "active" : "retired"; }

}  // namespace orient::patchdb
