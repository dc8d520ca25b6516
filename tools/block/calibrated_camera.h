// The cameras that belong to a block's poses: poses are true with them only.
#pragma once

#include <string>

#include "core/files/camera_file.h"
#include "exterior/block_adjustment.h"

namespace orient {

std::string CalibratedCameraPath(const std::string& directory);

// Writes `camera` with the block's calibration where anything was estimated, otherwise removes an
// earlier run's file. `earth_k1`: what `camera` has for curvature and refraction, which belong to
// the flight and not to the camera. Throws InputError: cannot write.
void WriteCalibratedCamera(const std::string& directory, const CameraFile& camera, double earth_k1,
                           const BlockResult& result);

// <directory>/camera.toml: the camera with which the block's poses show the ground where the photos
// do, by nothing but the collinearity equations; calibration, curvature and refraction are in its
// lens.
std::string BlockCameraPath(const std::string& directory);
void WriteBlockCamera(const std::string& directory, const CameraFile& camera, double earth_k1);

}  // namespace orient
