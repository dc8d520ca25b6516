// The camera as the block's self-calibration found it, for the next block.
#pragma once

#include <string>

#include "block/bundle/adjustment.h"
#include "core/files/camera_file.h"

namespace orient::block {

std::string CalibratedCameraPath(const std::string& directory);

// Writes `camera` with the block's calibration where anything was estimated, otherwise removes an
// earlier run's file. Without curvature and refraction, which belong to the flight. Throws
// InputError: cannot write.
void WriteCalibratedCamera(const std::string& directory, const CameraFile& camera,
                           const BlockResult& result);

}  // namespace orient::block
