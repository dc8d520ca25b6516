// Matched patches as observations of a pose: what each errs by itself, and what they share. Private
// to exterior.
#pragma once

#include "exterior/steps/correlated_pose.h"
#include "exterior/steps/photo_to_orient.h"
#include "patchdb/store/patch.h"

namespace orient::exterior {

// `covariance_px2`: of the match. Where it is known how a patch moves with its heights, that is an
// error it shares with others; otherwise the patch's own covariance must do, as `view` shows it.
PatchObservation ObservationOf(const patchdb::Patch& patch, const Eigen::Vector2d& pixel,
                               const Eigen::Matrix2d& covariance_px2, const PhotoView& view);

// Of a photo that lies in its scan so and sees the ground from so high above it.
CommonErrors CommonErrorsOf(const FilmPosition& position, const PhotoView& view, double ground_m);

}  // namespace orient::exterior
