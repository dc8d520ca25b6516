// A block by image measurements alone: no scans, no patches, no terrain. What another program or a
// person measured is adjusted and judged as any block is.
#pragma once

#include <vector>

#include "block/stages/adjustment_stage.h"
#include "core/files/camera_file.h"
#include "core/files/orientation_table.h"
#include "core/files/results.h"
#include "core/measurements/measurements.h"

namespace orient::block {

struct MeasuredBlockInputs {
  const CameraFile& camera;
  const Measurements& measured;
  std::vector<OrientationRow> approximations = {};  // of some photos, or none
  PoseObservations known = {};                      // observed in the adjustment
  bool self_calibration = false;
  int sub_block_photos = 10'000;  // as BlockAdjustmentChoice's
  bool pose_covariance = false;
  std::optional<double> target_m = {};  // that makes a photo ok; empty: its pixel, or 30 um
};

// The number of photos to adjust. Throws as AdjustMeasurements.
std::size_t RequireAdjustable(const MeasuredBlockInputs& inputs);

// First poses by resection from surveyed points, and from those that photos oriented before
// intersect; otherwise the approximation. Then the bundle adjustment. A film photo measured in
// pixels needs its fiducial marks measured, too. Throws InputError: no image points, a photo of
// such film without four measured marks, self-calibration of too many photos. The results are of
// all photos that were measured, by name.
JudgedBlock AdjustMeasurements(const MeasuredBlockInputs& inputs);

}  // namespace orient::block
