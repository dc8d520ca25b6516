// Self-calibration's significance tests. Private to block.
#pragma once

#include <vector>

#include "block/bundle/normal_equations.h"

namespace orient::block {

// All lens parameters of all cameras are unknowns from here on.
void StartCalibration(BlockSystem* system);

// Drops the parameters that the block does not determine and then, one by one, those not
// significant: each leaves the others with the values they have without it (the linear adjustment's
// exact answer). True where any was dropped; `parameters` has all of them with their values and
// tests.
bool TestCalibration(const BlockNormals& normals, BlockSystem* system,
                     std::vector<CalibrationParameter>* parameters);

// The cameras with what was estimated.
std::vector<Camera> CalibratedCameras(const BlockSystem& system);

}  // namespace orient::block
