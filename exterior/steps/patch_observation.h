// Matched patches as observations of a pose: individual errors and shared ones. Private to
// exterior.
#pragma once

#include "exterior/steps/correlated_pose.h"
#include "exterior/steps/photo_to_orient.h"
#include "patchdb/store/patch.h"

namespace orient::exterior {

// `covariance_px2`: of the match. Where it is known how a patch moves with its heights, that is an
// error it shares with others; otherwise the patch's own covariance, projected by `view`.
PatchObservation ObservationOf(const patchdb::Patch& patch, const Eigen::Vector2d& pixel,
                               const Eigen::Matrix2d& covariance_px2, const PhotoView& view);

// For a photo with this film transform, at this height above the ground.
CommonErrors CommonErrorsOf(const FilmPosition& position, const PhotoView& view, double ground_m);

}  // namespace orient::exterior
