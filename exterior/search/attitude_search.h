// The first round where it is not known which way the camera looked, nor perhaps where it was. From
// near its position every patch looks as drawn with its own heights, except for its rotation in the
// photo. Single patches are drawn at every kappa, and at several flying heights unless the position
// is known, and searched for by their gradients wherever in the photo the prior allows them; they
// vote for tilt. Private to exterior.
#pragma once

#include "exterior/search/whole_photo_search.h"

namespace orient::exterior {

// In all functions, `ground_height_m` is the patches' MedianGroundHeight.

// Whether the prior's position is good enough for patches to look nearly as seen from there, so
// that no other flying height need be tried.
bool IsPositionKnown(const PosePrior& prior, double ground_height_m);

// The largest number of attitudes and heights tried, including first poses followed up.
double AttitudeTrials(const PhotoTask& task, double ground_height_m);

// Not searched where fewer than four patches can be sought at a level that can be searched whole.
// `trials`: in how many ways a first pose is searched for, this search and others together. The
// caller asks whether chance explains the pose.
WholePhotoSearch SearchAttitudes(const PhotoTask& task, double ground_height_m, double trials);

}  // namespace orient::exterior
