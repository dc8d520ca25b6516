// Where the fiducial marks of a camera without calibration certificate are, from the places at
// which they were seen on one scan or more, and from distances between them, which old reports
// state.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "block/roll/camera_estimation.h"

namespace orient::block {

struct MarkDistance {
  size_t from = 0, to = 0;  // indices of marks
  double distance_mm = 0;
  double sigma_mm = 0.01;
};

// The observation that fits the others least, where it is off by more than five of its residual's
// sigmas (data snooping): a mark's place on a scan, or a distance.
struct LayoutContradiction {
  std::optional<size_t> scan, mark, distance;
  double off_mm = 0;  // its residual
};

struct MarkLayout {
  // The axes are those of the first scan, turned so that opposite marks lie on them or on their
  // diagonals; the origin is where the lines between opposite marks meet (the indicated principal
  // point), of three corners of a rectangle its middle, or the marks' mean where neither is there.
  std::vector<Eigen::Vector2d> position_mm;
  // Of the marks relative to one another: origin, axes and, without distances, scale are taken
  // as error-free.
  std::vector<Eigen::Vector2d> sigma_mm;
  std::vector<double> distance_residual_mm;  // stated - adjusted
  bool origin_known = true;                  // false: it is the marks' mean
  double scale_difference = 0;               // largest of a scan's own scale from the median, share
  std::optional<LayoutContradiction> contradiction;
};

// Least squares in all places and distances at once, every scan with a shift, rotation and scale of
// its own. `scan_sigma_mm`: of one coordinate of a place, with what the scanner and the film do to
// it. The scale is that of the distances, or without them the median of the scans' own. Empty where
// a mark was seen on no scan, fewer than three marks were seen, or a scan shows fewer than two.
std::optional<MarkLayout> EstimateLayout(const std::vector<ScanOfMarks>& scans,
                                         const std::vector<MarkDistance>& distances,
                                         double scan_sigma_mm);

}  // namespace orient::block
