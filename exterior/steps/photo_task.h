// What the steps of one photo's orientation share, and what they hand on. Private to exterior.
#pragma once

#include <vector>

#include "exterior/steps/photo_image.h"
#include "exterior/steps/photo_to_orient.h"
#include "exterior/steps/predict.h"
#include "patchdb/store/patch.h"

namespace orient::exterior {

// What the steps of one photo share.
struct PhotoTask {
  const PhotoToOrient& photo;
  const PhotoImage& image;
  const std::vector<patchdb::Patch>& patches;
  const OrientPhotoOptions& options;

  PhotoView View(const FilmPosition& position, const Pose& pose) const {
    return {photo.camera, position.photo_from_pixel, pose, position.film_correction};
  }
  PredictionOptions Prediction() const {
    return {image.Width(), image.Height(), 8, photo.covered, photo.surface};
  }
};

// A pose on its way: where the film lies, what is known, how it was found.
struct PoseTrack {
  FilmPosition position;
  Pose pose;
  Matrix6d covariance;
  double log10_false_alarms = 0;
  int reduction = 1;  // of the round that led here
  std::vector<LoopRound> rounds;
  double trials = 1;  // in how many ways a first pose was searched for
};

// Search windows reach this many sigmas of the prediction.
inline constexpr double kWindowSigmas = 3;

// In scan pixels, col or row, whichever is larger.
inline double LargestRadius(const std::vector<PatchPrediction>& predictions, double sigmas) {
  double largest = 0;
  for (const PatchPrediction& p : predictions)
    largest = std::max(largest, p.Radius(sigmas).maxCoeff());
  return largest;
}

// A prior that only keeps what the patches leave wholly open.
inline PosePrior Weakened(const PosePrior& prior) { return {prior.pose, 1e4 * prior.covariance}; }

}  // namespace orient::exterior
