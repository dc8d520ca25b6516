// A control patch: a small orthophoto chip around a point of known ground position, north up, with
// the heights under it.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/raster/image.h"

namespace orient::patchdb {

// Square grid of heights centred on the patch's point, row 0 in the north, nodes at multiples of
// step_m from the centre: node (i, j) lies at X + (j - (n-1)/2) step, Y - (i - (n-1)/2) step.
struct HeightGrid {
  int size = 0;  // n, odd
  double step_m = 0;
  std::vector<float> heights_m;  // n * n; NaN where unknown

  // Bilinear, at an offset east and north of the centre; NaN outside.
  double At(double east_m, double north_m) const;
};

// A further source that shows a patch.
struct PatchEvidence {
  std::int64_t source_id = 0;
  std::optional<Eigen::Vector2d> pixel;        // measured, of that source
  std::optional<Eigen::Vector2d> residual_px;  // measured - computed from the patch's ground_m
};

enum class PatchLife { kActive, kRetired };

struct Patch {
  std::int64_t id = 0;  // 0: not stored yet
  std::int64_t source_id = 0;
  PatchLife life = PatchLife::kActive;
  std::string retired_reason;                          // empty while active
  std::optional<std::string> retired_on;               // UTC, ISO 8601; set by the database
  std::int64_t superseded_by = 0;                      // the patch that took its place; 0: none
  int epoch = 1;                                       // counts up with each restore
  std::optional<std::string> created;                  // UTC, ISO 8601; set by the database
  Eigen::Vector3d ground_m = Eigen::Vector3d::Zero();  // of the chip's centre (width/2, height/2)
  Eigen::Matrix3d covariance_m2 = Eigen::Matrix3d::Zero();
  // How ground_m moves for each metre by which the heights under its source are too high, and how
  // wrong they may be (one sigma): along the source's line of sight. All patches cut with one DEM
  // share such errors. Empty: unknown.
  std::optional<Eigen::Vector3d> height_effect;
  std::optional<double> height_sigma_m;
  double gsd_m = 0;  // chip pixel in metres
  // Chip pixel (col, row) lies at X + (col - width/2) gsd, Y - (row - height/2) gsd. NaN: no data.
  Image chip;
  int bits = 8;  // of a stored grey value
  // Red, green, blue of a colour chip, of the size of `chip`; empty: a grey one. Storing takes
  // these instead of `chip`. Of the questions to the database only ReadPatch answers with them.
  std::vector<Image> colour;
  HeightGrid heights;
  // What was measured about it; unknown is empty.
  std::optional<double> roundness;       // Foerstner's q: 0 bad .. 1 good
  std::optional<double> distinctness;    // 1 - height of the second autocorrelation peak
  std::optional<double> second_peak_px;  // distance of that peak, chip pixels
  std::optional<double> persistence;     // pyramid levels its texture survives
  std::optional<double> relief_px;       // spread of the heights under the chip, chip pixels
  // How far the surface (roofs, crowns) departs from `heights`: lean in chip pixels at 45 degrees.
  std::optional<double> lean_px;
  std::optional<Eigen::Vector3d> energy;  // mean squared gradient: xx, xy, yy; x east, y north
  std::optional<double> quality;          // 0 .. 1, of all of these
  int views = 1;                          // sources that show it, its own among them
  // Attempts that succeeded and that failed, each weighted by what it says about the patch of
  // today: patchdb/store/learning.h.
  double success_weight = 0, failure_weight = 0;
  // Storing adds these; only ReadPatch answers with them.
  std::vector<PatchEvidence> evidence;
};

enum class SourceKind { kPhoto, kOrthophoto, kGcp };

const char* Name(PatchLife life);   // "active", "retired"
const char* Name(SourceKind kind);  // "photo", "orthophoto", "gcp"

struct PatchSource {
  std::int64_t id = 0;
  SourceKind kind = SourceKind::kPhoto;
  std::string name;                 // file name without folder; of a table for ground control
  std::optional<std::string> date;  // ISO 8601
  double gsd_m = 0;
  std::optional<std::string> crs;         // its own, where it has one
  std::optional<std::string> provenance;  // who made it, from what
  std::optional<std::string> licence;
  std::optional<std::string> digest = {};  // of its content
};

}  // namespace orient::patchdb
