// The camera that belongs to poses: only with it do they project ground to where photos show it.
#pragma once

#include <optional>
#include <string>

#include "core/files/camera_file.h"
#include "core/terrain/earth_effects.h"

namespace orient::block {

// <directory>/block_camera.toml
std::string BlockCameraPath(const std::string& directory);

// The camera with which a folder's poses satisfy the plain collinearity equations;
// calibration, earth curvature and refraction are in its lens. Throws InputError: cannot write.
void WriteBlockCamera(const std::string& directory, const CameraFile& camera);

// Throws UsageError where the camera file has curvature in its lens and more may be added.
void RefuseBlockCamera(const std::string& camera, EarthMode earth);

// The folder's block camera where it says anything else than the file `camera`; empty where it does
// not, or there is none.
std::optional<std::string> OtherBlockCamera(const std::string& directory,
                                            const std::string& camera);

// Throws UsageError where the folder of an orientation table says that its poses are true with
// another camera than this one.
void RequireCameraOfPoses(const std::string& camera, const std::string& table);

}  // namespace orient::block
