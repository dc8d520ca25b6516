// block.json: what a block adjustment says about the block as a whole.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/files/finding.h"

namespace orient {

// What one photo shows of a tie or a control patch.
struct SightingResult {
  std::string photo;
  Eigen::Vector2d pixel;
  std::string state;                           // used, rejected, held out, ...
  std::optional<Eigen::Vector2d> residual_px;  // measured - computed
  std::optional<double> w;                     // over its standard deviation
  std::optional<double> redundancy;            // 0..2: of both coordinates together
};

struct ControlResult {
  std::string state;  // used, rejected, check
  std::optional<Eigen::Vector3d> given_m, residual_m;
  std::optional<double> w;
};

struct PointResult {
  std::int64_t id = 0;
  std::optional<ControlResult> control;  // absent for ties
  std::optional<Eigen::Vector3d> ground_m, sigma_m;
  int rays = 0;  // used
  std::vector<SightingResult> seen;
};

struct ComponentResult {
  std::string group;
  std::optional<double> factor;  // of the stated variances
  std::optional<double> redundancy, sigma0_px;
  bool estimated = false;
};

struct PartResult {
  std::vector<std::string> photos;
  int control_points = 0;
  bool by_control = false;
  std::optional<Finding> finding;  // absent if there is nothing to report
};

struct CalibrationResult {
  std::string parameter;
  std::optional<double> correction, sigma, t;
  std::string state;
};

struct CheckResult {
  std::int64_t id = 0;
  int rays = 0;
  std::optional<Eigen::Vector3d> ground_residual_m;  // seen in two photos or more
  std::vector<Eigen::Vector2d> image_residuals_px;
};

// What was known of a pose beforehand, beside what the photo shows.
struct PoseObservationResult {
  std::string photo, state;                   // used, rejected
  std::optional<Eigen::Vector3d> residual_m;  // of GNSS: measured - computed
  std::optional<double> w;                    // over its standard deviation
};

struct GnssStripResult {
  std::string strip;
  std::optional<Eigen::Vector3d> shift_m, shift_sigma_m, drift_m, drift_sigma_m;
};

struct AdjustmentResult {
  bool converged = false;
  std::optional<double> sigma0, redundancy;
  std::vector<ComponentResult> components;
  std::vector<PartResult> parts;
  std::vector<CalibrationResult> calibration;
  std::vector<CheckResult> checks;
  int checks_rejected_alone =
      0;              // sightings that are not among them: gross errors of a photo alone
  Findings findings;  // what a person should know about the block as a whole
  std::vector<PointResult> ties, control;
  std::vector<PoseObservationResult> approximations, gnss;
  std::vector<GnssStripResult> gnss_strips;

  // RMS of the check patches' image residuals; empty without check patches.
  std::optional<double> CheckRmsPx() const;
};

std::string AdjustmentResultPath(const std::string& directory);
// <directory>/block.json, written beside and renamed. Reading throws InputError naming the file and
// the field.
void WriteAdjustmentResult(const std::string& directory, const AdjustmentResult& result);
AdjustmentResult ReadAdjustmentResult(const std::string& path);

}  // namespace orient
