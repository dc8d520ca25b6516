// Accuracy of a photo's pose on the ground.
#pragma once

#include <optional>

#include "core/files/results.h"
#include "core/geometry/camera.h"
#include "core/terrain/ground_accuracy.h"

namespace orient {

// CE90 of places on level ground at the mean height of the photo's footprint, whose height is
// known: from the pose's full covariance, by the function that orthophotos state theirs by. Empty
// without pose, covariance or footprint, and where the numbers are absurd.
std::optional<GroundAccuracy> AccuracyOnLevelGround(const ExteriorResult& photo,
                                                    const Camera& camera);

}  // namespace orient
