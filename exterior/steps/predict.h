// Step 1, predict: where in the photo each patch should be, and how uncertain that is.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/geometry/resection.h"
#include "core/terrain/ground_surface.h"
#include "core/terrain/photo_view.h"
#include "exterior/steps/visibility.h"
#include "patchdb/store/patch.h"

namespace orient::exterior {

struct PatchPrediction {
  std::size_t patch = 0;           // index into the patches
  Eigen::Vector2d pixel;           // scan
  Eigen::Matrix2d covariance_px2;  // of the pose and of the ground point together

  // Half sizes of the search window: `k` sigma along col and row.
  Eigen::Vector2d Radius(double k) const { return k * covariance_px2.diagonal().cwiseSqrt(); }
};

struct PredictionOptions {
  int width_px = 0, height_px = 0;  // of the scan
  double border_px = 8;  // least distance of patch centres from scan and frame edge, covered areas
  std::vector<CoveredArea> covered = {};   // of the frame
  const GroundSurface* surface = nullptr;  // what may hide patches; null: nothing does
};

struct UnseenPatch {
  std::size_t patch = 0;  // index into the patches
  Unseen why = Unseen::kOutsidePhoto;
};

// Predictions of the patches that the photo should see; the others go to `not_visible`.
// `view.pose` is the mean, `pose_covariance` in the order of Vector6d.
std::vector<PatchPrediction> Predict(const PhotoView& view, const Matrix6d& pose_covariance,
                                     const std::vector<patchdb::Patch>& patches,
                                     const PredictionOptions& options,
                                     std::vector<UnseenPatch>* not_visible = nullptr);

// At most `count` of the predictions, spread evenly over the photo; in each cell, first those that
// did better than expected in earlier attempts (patchdb/store/learning.h), then the most distinct.
// Deterministic.
std::vector<PatchPrediction> SelectSpread(const std::vector<PatchPrediction>& predictions,
                                          const std::vector<patchdb::Patch>& patches, int count,
                                          const PredictionOptions& options);

// Where the frame may lie on the ground when the pose is only known to k sigma: the bounds to ask
// the patch database for. Empty bounds where no ray meets the height range.
Bounds UncertainFootprint(const Camera& camera, const PosePrior& prior, double min_height_m,
                          double max_height_m, double k = 3);

}  // namespace orient::exterior
