// The marks of a camera as they are drawn, their template images read.
#pragma once

#include "core/files/camera_file.h"
#include "interior/marks/mark_drawing.h"

namespace orient::block {

// The drawings of a camera's marks, with the template images they refer to.
interior::MarkShapes LoadMarkShapes(const CameraFile& camera);

}  // namespace orient::block
