// What the photos of one roll have in common, and which of them stands out.
//
// Photos of one camera and scanner, on one film, agree in what their affine transforms say of the
// scanner and the film: pixel size along columns and rows, their difference, shear, and how well an
// affine explains the marks. A frame that departs from the others has slipped on the scanner, is
// torn or curled, or was read wrongly; nothing in the frame itself need show it. Medians and median
// absolute deviations describe the roll, so that such a frame does not hide itself.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "core/base/median.h"
#include "core/files/results.h"

namespace orient::block {

// Mean residual of the roll's photos at one mark. With an affine transform of few marks an error of
// one mark's calibrated position is shared by all of them.
struct RollMark {
  std::string id;
  int photos = 0;                                      // in which the mark was used
  Eigen::Vector2d mean_um = Eigen::Vector2d::Zero();   // residual: calibrated - computed
  Eigen::Vector2d sigma_um = Eigen::Vector2d::Zero();  // of the mean
  double probability = 1;   // of such a mean by chance (Hotelling's T^2, two components)
  bool systematic = false;  // beyond chance and beyond a micrometre
};

struct RollStatistics {
  int photos = 0;                // with an affine transform; only these count
  RobustValue column_um;         // pixel size along the scan's columns axis (from col to col + 1)
  RobustValue row_um;            // and along rows
  RobustValue scale_difference;  // (column - row) / mean
  RobustValue shear_rad;         // the scan's axes' angle less 90 degrees
  RobustValue sigma0_um;
  bool photogrammetric = false;  // the common affinity is below 5e-4: not a desktop scanner's
  std::vector<RollMark> marks;   // in the order of the results' marks
};

// Fewer photos say too little about their spread to call one of them different.
inline constexpr int kLeastPhotosOfRoll = 8;

// Empty below kLeastPhotosOfRoll photos with an affine transform (four marks used or more).
std::optional<RollStatistics> StatisticsOfRoll(const std::vector<InteriorResult>& results);

// Why this photo stands out, one finding per reason: pixel size, difference of the scales or shear
// farther from the median than 2e-4 and than k sigmas, or sigma0 larger by 5 um and by k sigmas.
// k = 5 + 80 / photos, because the median absolute deviation of few photos is itself uncertain:
// among photos that differ by chance only, fewer than 1 % of rolls have one that is named.
Findings WhyItStandsOut(const RollStatistics& roll, const InteriorResult& photo);

// Makes the photos that stand out `weak`, with the reasons among their findings, and takes back
// what an earlier comparison with fewer or other photos said. Returns the indices of those whose
// status or findings changed.
std::vector<size_t> CompareWithRoll(const std::optional<RollStatistics>& roll,
                                    std::vector<InteriorResult>* results);

// What the roll says of scanner and camera file, in sentences.
std::vector<std::string> RollSentences(const RollStatistics& roll);

}  // namespace orient::block
