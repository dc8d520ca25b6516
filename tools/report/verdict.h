// What a person should know about each photo and look at first.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/terrain/ground_accuracy.h"
#include "tools/report/block_record.h"

namespace orient {

struct PhotoVerdict {
  // Of the last stage that ran. A photo whose files cannot be read, or that stopped half-way while
  // others of its block went on, has failed.
  Status status = Status::kFailed;
  std::vector<std::string> reasons;  // of both stages and of the files
  int marks_used = 0, marks = 0;
  int matched = 0, not_found = 0, rejected = 0, not_visible = 0;
  std::optional<double> sigma0_um, sigma0_px;  // of the marks, of the matches
  std::optional<ProjectionSigma> projection;
  // On level ground of known height: tools/report/figures/photo_accuracy.h.
  std::optional<GroundAccuracy> ce90;
  std::optional<Pose> pose;
  std::optional<Vector6d> sigma;  // x y z [m] omega phi kappa [rad]
  bool from_table = false;        // pose and sigma come from orientation.csv, no result file has it

  int Searched() const { return matched + not_found + rejected; }
};

// A photo, and one sentence that says why it deserves a look.
struct Concern {
  size_t photo = 0;  // index into BlockRecord::photos
  std::string text;
};

struct BlockVerdict {
  std::vector<PhotoVerdict> photos;  // as BlockRecord::photos
  std::vector<Concern> concerns;     // failed, weak, then conspicuous photos
  int ok = 0, weak = 0, failed = 0;
  int matched = 0, searched = 0;
  std::optional<double> median_sigma0_px, median_sigma0_um;
  std::optional<ProjectionSigma> median_projection;  // each by itself
  std::optional<size_t> worst_projection;            // the photo with the largest one, px
  std::optional<double> median_ce90_m;               // of the photos' medians over their frames
  std::optional<size_t> worst_ce90;                  // the photo with the worst place
  std::optional<double> median_le90_m;               // of tie points
  std::optional<size_t> least_precise;  // the photo with the largest sigma of a coordinate
};

// A sigma0, a sigma or a matched patch's residual is conspicuous from this multiple of the block's
// median on (of the photo's own median for a residual).
inline constexpr double kConspicuousSigma0 = 2.0;
inline constexpr double kConspicuousSigma = 3.0;
inline constexpr double kConspicuousResidual = 5.0;
inline constexpr double kConspicuousShare = 0.03;  // of the matched patches

BlockVerdict Judge(const BlockRecord& block);

}  // namespace orient
