// One round of matching and resection at full resolution. Private to exterior.
#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "exterior/steps/match.h"
#include "exterior/steps/photo_task.h"
#include "exterior/steps/predict.h"
#include "exterior/steps/resect.h"

namespace orient::exterior {

struct PreciseRound {
  PhotoView view;        // under which the patches were drawn and searched for
  double margin_px = 0;  // of the windows, beyond what the view's covariance says
  std::vector<PatchPrediction> predictions;
  std::vector<UnseenPatch> not_visible;
  std::vector<PreciseMatch> matches;     // one per prediction
  bool by_gradients = false;             // what grey values did not find was searched for so
  std::vector<std::size_t> observed;     // the predictions that were found
  std::optional<PoseEstimate> estimate;  // over the observed
  bool contradicts_prior = false;        // the estimate then does without it
  double window_px = 0;
  std::vector<double> windows_px2;  // one per prediction: where it was searched for
};

// Matches the patches that a view shows around where it shows them.
PreciseRound MatchAll(const PhotoTask& task, const PhotoView& view, const Matrix6d& covariance,
                      double margin_px);

// The pose from the round's matches; none where too few agree.
void Resect(const PhotoTask& task, const PoseTrack& track, PreciseRound* round);

// What the round's pose rejects or did not find, searched for once more close to where that pose
// sees it: in a window that small another place no longer competes. Nothing of it is evidence for
// the pose. The round as it was where the pose does not stand.
PreciseRound Complete(const PhotoTask& task, const PoseTrack& track, const PreciseRound& settled);

// Patches in one square of a patch's size overlap and are one piece of evidence.
using Square = std::pair<long, long>;
Square SquareOf(const PatchPrediction& prediction);

// Patches that cannot be where they are searched for, and how many are found all the same.
struct DecoyMatches {
  int sought = 0, found = 0;
};

// How often this photo's texture shows by chance what a patch of this kind looks like: in the
// windows of the round, one per square, a patch mirrored, and one with the image of another patch
// from outside the window; with gradients where grey values find few. The more frequent of the two,
// of those that could be drawn.
DecoyMatches MatchDecoys(const PhotoTask& task, const PreciseRound& round);

}  // namespace orient::exterior
