// The first round where neither position nor kappa need be known: keypoints (SIFT) of the patches'
// chips are looked for among the photo's, at once for all kappas, places and flying heights. The
// quickest search of a whole photo where chips are large enough at a level of the photo to show
// keypoints; the others (wide_search.h) find what resembles too little for it.
// Private to exterior.
#pragma once

#include "exterior/search/whole_photo_search.h"

namespace orient::exterior {

// The largest number of poses that are followed up.
double KeypointTrials(const PhotoTask& task);

// Not searched where no chip is large enough. `trials`: in how many ways a first pose is searched
// for, this search and others together. The caller asks whether chance explains the pose.
WholePhotoSearch SearchByKeypoints(const PhotoTask& task, double ground_height_m, double trials);

}  // namespace orient::exterior
