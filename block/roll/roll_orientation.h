// Photos of one roll usually lie alike on the scanner. What single photos leave open, all of them
// together may tell.
#pragma once

#include <vector>

#include "core/files/camera_file.h"
#include "core/files/results.h"
#include "interior/marks/mark_drawing.h"

namespace orient::block {

// The scan orientation in which the photos of a roll lie together: every `ok` photo votes for each
// one with its nats, at most interior::kSureNats against it. Empty unless three photos vote, the
// best is kSureNats ahead of all others, and nine of ten photos leave it possible.
std::optional<ScanOrientation> OrientationOfRoll(const std::vector<InteriorResult>& results);

// Takes back what an earlier comparison with fewer or other photos said. Then, if the photos lie
// `alike`, photos to which the roll's orientation is possible get it, with a remark; where the roll
// leaves it open as well, all photos name their marks as if they lay in the likeliest way of all,
// and not each in another. Returns the indices of the photos that changed. `results` are of one
// camera.
std::vector<size_t> OrientAsRoll(const CameraFile& camera, const interior::MarkShapes& shapes,
                                 bool alike, std::vector<InteriorResult>* results);

}  // namespace orient::block
