// How large and how turned a scan is on which a person clicked the marks of a new camera.
#pragma once

#include <Eigen/Core>
#include <string>

#include "block/roll/new_camera_inputs.h"

namespace orient::block {

struct ClickedScale {
  Eigen::Matrix2d mm_from_pixel = Eigen::Matrix2d::Identity();  // linear part of photo from pixel
  std::string from;  // "stated positions", "stated distances", "--pixel-size-um", "resolution tag"
};

// By the stated positions, with the scan's rotation; else by the distances, the pixel size or the
// resolution tag, in the orientation of the options. Throws InputError where the clicks contradict
// what is stated, or nothing tells the scale.
ClickedScale ScaleOf(const ClickedScan& scan, const NewCameraOptions& options);

}  // namespace orient::block
