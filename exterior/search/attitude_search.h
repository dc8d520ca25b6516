// The first round where the camera's position is known, but not which way it looked: then it is
// known how every patch looks from there, but for its turn in the photo. The whole photo is
// searched, at every kappa, for single patches drawn with their own heights, by their gradients,
// and the patches vote for tilt. Private to exterior.
#pragma once

#include "exterior/search/whole_photo_search.h"

namespace orient::exterior {

// Whether the prior's position is good enough: patches look nearly as they do from there.
bool IsPositionKnown(const PosePrior& prior, double ground_height_m);

// Most attitudes and heights tried, first poses followed up included.
double AttitudeTrials(const PhotoTask& task, double ground_height_m);

// Not searched where no patch can be searched for at a level that can be searched whole. `trials`:
// in how many ways a first pose is searched for, this search and others together. The caller asks
// whether chance explains the pose.
WholePhotoSearch SearchAttitudes(const PhotoTask& task, double ground_height_m, double trials);

}  // namespace orient::exterior
