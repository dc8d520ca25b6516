// COLMAP's model: cameras, images and points3D as .txt, or as the .bin that its programs write
// (https://colmap.github.io/format.html; src/colmap/scene/reconstruction_io.cc).
//
// Per image a unit quaternion QW QX QY QZ (Hamilton) and a translation T that take world points to
// the camera system: x right, y down, z forward; the centre is -R^T T. Pixels count from the outer
// corner of the upper-left pixel, its centre is (0.5, 0.5), as ours do.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/exchange/colmap_model.h"
#include "core/exchange/exchange_block.h"

namespace orient {

// Writes the three files below `directory`: camera models PINHOLE, OPENCV or FULL_OPENCV, whichever
// holds the distortion. Control points and ties become points3D if two photos see them: COLMAP's
// bundle adjustment takes no others.
void WriteColmap(const std::string& directory, const ExchangeBlock& block);

// The .bin files where there are both, as COLMAP does. Throws InputError naming file, line (or
// byte) and value. Models: SIMPLE_PINHOLE, PINHOLE, SIMPLE_RADIAL, RADIAL, OPENCV, FULL_OPENCV
// (with k4 k5 k6 = 0).
ColmapModel ReadColmap(const std::string& directory);
// As the comments of an export's images.txt say it; empty where they do not.
std::optional<Eigen::Vector3d> ReadColmapOrigin(const std::string& directory);
// Of images and points3D; empty without the latter.
std::vector<ColmapObservation> ReadColmapObservations(const std::string& directory);
ExchangeBlock ExchangeFromColmap(const ColmapModel& model);

}  // namespace orient
