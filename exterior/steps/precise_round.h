// One round of matching and resection at full resolution, or where the patches' pixels are several
// times as large as the photo's, at theirs. Private to exterior.
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
  std::vector<std::size_t> observed;     // the predictions that were found
  std::optional<PoseEstimate> estimate;  // over the observed
  int reduction = 1;                     // at which patches were drawn and searched for
  bool by_gradients = false;             // used for patches that grey values did not find
  bool contradicts_prior = false;        // the estimate then does without it
  double window_px = 0;
  std::vector<double> windows_px2;  // one per prediction: where it was searched for
};

// The reduction at which patches are matched precisely: so many of the photo's pixels lie side by
// side in one of the patches' (lower quartile, rounded down), four at most. A photo finer than they
// are shows only its grain more largely.
int PreciseReduction(const PhotoTask& task, const PoseTrack& track);

// Matches the patches that a view shows around where it shows them. `margin_px`: of the reduction.
PreciseRound MatchAll(const PhotoTask& task, const PhotoView& view, const Matrix6d& covariance,
                      double margin_px, int reduction);

// The pose from the round's matches; none where too few agree.
void Resect(const PhotoTask& task, const PoseTrack& track, PreciseRound* round);

// Searches once more for patches that the round's pose rejects or that were not found, close to
// where it projects them: in so small a window no other place competes. None of this is evidence
// for the pose. Returns the round unchanged if the pose does not hold.
PreciseRound Complete(const PhotoTask& task, const PoseTrack& track, const PreciseRound& settled);

// Patches in one square of a patch's size at the reduction overlap and are one piece of evidence.
using Square = std::pair<long, long>;
Square SquareOf(const PatchPrediction& prediction, int reduction);

// Patches that cannot be where they are searched for, and how many are found all the same.
struct DecoyMatches {
  int sought = 0, found = 0;
};

// How often this photo's texture resembles a patch of this kind by chance. Decoys, in the round's
// windows, one per square: the patch mirrored, and in its place the image of another patch
// from outside the window; with gradients if grey values find few. Returns the more frequent kind,
// counting decoys that could be drawn.
DecoyMatches MatchDecoys(const PhotoTask& task, const PreciseRound& round);

}  // namespace orient::exterior
