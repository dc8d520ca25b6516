// The film's transform and its reseau's correction in a photo's result.
#pragma once

#include "core/files/camera_file.h"
#include "core/files/results.h"

namespace orient::interior {

// The film's transform from the result's used marks, as if it lay mirrored or not; residuals of
// these, and of the marks that had one before. False where they give no transform.
bool FitUsedMarks(const CameraFile& camera, bool mirrored, InteriorResult* result);

// A reseau's correction. Crosses that contradict their neighbours become rejected: the affine is
// estimated without them, and their residuals are kept.
void CorrectFilm(const CameraFile& camera, bool mirrored, InteriorResult* result);

}  // namespace orient::interior
