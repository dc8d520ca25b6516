// A camera's mark positions from measured marks of many scans: generalised Procrustes analysis.
//
// Every scan shows the same marks through a transform of its own. What all scans agree on is the
// camera: m_i = x_si + J(x_si) p_s + e, with m_i a mark's position, x_si its place on scan s in mm,
// p_s the scan's shift, rotation, scale and affinity (difference of scales, shear), and e the noise
// of measuring and of the film. Least squares in all of them at once, the scans' parameters
// eliminated one scan at a time; variances of noise and affinity come from the data; marks that the
// others contradict are thrown out one by one.
//
// What no set of scans shows is fixed by the start positions: shift, rotation and scale (the
// nominal format), and the affinity that all scans have in common. A photogrammetric scanner has
// next to none of that, so there it counts as unknown by 1.5e-4 and enters the precision.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

namespace orient::block {

struct ScanOfMarks {
  std::string name;
  // Per mark of the camera: where it was measured, transformed to millimetres by any affine that is
  // good to a few per cent and a millimetre or so; empty for a mark that was not found.
  std::vector<std::optional<Eigen::Vector2d>> place_mm;
};

enum class CommonAffinity {
  kUnknown,  // desktop scanners, prints: the estimate keeps the start positions' affine shape
  kSmall,    // photogrammetric scanners: below 1.5e-4, so the scans tell the camera's shape
};

struct CameraEstimate {
  std::vector<Eigen::Vector2d> position_mm;  // per mark
  std::vector<Eigen::Vector2d> sigma_mm;     // infinite for a mark that no scan shows
  Eigen::MatrixXd covariance_mm2;            // of all shown marks' x, y in turn; see `shown`
  std::vector<size_t> shown;                 // marks seen in two scans or more
  double noise_um = 0;         // of a mark's coordinate on a film: measuring and deformation
  double affinity = 0;         // one sigma of a film's own affinity, scan to scan
  double mean_difference = 0;  // mean of the scans' difference of scales: what they have in common
  double mean_shear = 0;
  int scans = 0;                   // with three marks or more
  int measured = 0, rejected = 0;  // marks on all of them
};

// Scans with fewer than three marks are left out. Empty below three scans, or where fewer than
// four marks are seen in two of them. Throws std::invalid_argument where a scan does not have as
// many places as there are start positions.
std::optional<CameraEstimate> EstimateCamera(const std::vector<ScanOfMarks>& scans,
                                             const std::vector<Eigen::Vector2d>& start_mm,
                                             CommonAffinity common);

}  // namespace orient::block
