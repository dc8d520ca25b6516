// A control patch: a small orthophoto chip around a point of known ground position, north up, with
// the heights under it.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/imaging/image.h"

namespace orient {

// Square grid of heights centred on the patch's point, row 0 in the north, nodes at multiples of
// step_m from the centre: node (i, j) lies at X + (j - (n-1)/2) step, Y - (i - (n-1)/2) step.
struct HeightGrid {
  int size = 0;  // n, odd
  double step_m = 0;
  std::vector<float> heights_m;  // n * n; NaN where unknown

  // Bilinear, at an offset east and north of the centre; NaN outside.
  double At(double east_m, double north_m) const;
};

struct Patch {
  std::int64_t id = 0;  // 0: not stored yet
  std::int64_t source_id = 0;
  Eigen::Vector3d ground_m = Eigen::Vector3d::Zero();  // of the chip's centre (width/2, height/2)
  Eigen::Matrix3d covariance_m2 = Eigen::Matrix3d::Zero();
  // How ground_m moves for each metre by which the heights under its source are wrong, and how
  // wrong they may be (one sigma): along the source's line of sight. All patches cut with one DEM
  // share such errors. Empty: unknown.
  std::optional<Eigen::Vector3d> height_effect;
  std::optional<double> height_sigma_m;
  double gsd_m = 0;  // chip pixel in metres
  // Chip pixel (col, row) lies at X + (col - width/2) gsd, Y - (row - height/2) gsd. NaN: no data.
  Image chip;
  int bits = 8;  // of a stored grey value
  HeightGrid heights;
  // What was measured about it; unknown is empty. 0 bad .. 1 good.
  std::optional<double> roundness;     // Foerstner's q
  std::optional<double> distinctness;  // 1 - height of the second autocorrelation peak
  std::optional<double> persistence;   // pyramid levels its texture survives
  std::optional<double> relief_px;     // spread of heights in pixels of lean at 45 degrees
};

enum class SourceKind { kPhoto, kOrthophoto };

struct PatchSource {
  std::int64_t id = 0;
  SourceKind kind = SourceKind::kPhoto;
  std::string name;                 // file name without folder
  std::optional<std::string> date;  // ISO 8601
  double gsd_m = 0;
};

}  // namespace orient
