// <photo>.keypoints.json: where keypoints shared with oriented photos put a photo.
#pragma once

#include <optional>
#include <string>

#include "core/files/inputs.h"
#include "core/files/orientation_table.h"

namespace orient::block {

struct KeypointApproximation {
  OrientationRow row;
  int keypoints = 0;  // that agree on it
};

// `found`: empty where the search was in vain, which is a result, too.
void WriteKeypointResult(const std::string& path, const Inputs& made_from,
                         const std::optional<KeypointApproximation>& found);
// Throws InputError naming the file.
std::optional<KeypointApproximation> ReadKeypointResult(const std::string& path,
                                                        const std::string& photo);

}  // namespace orient::block
