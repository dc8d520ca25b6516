// A block by image measurements alone, from what its block file says of it.
#pragma once

#include <string>
#include <vector>

#include "block/inputs/pose_observations.h"
#include "block/stages/measured_block.h"
#include "core/files/block_file.h"

namespace orient::block {

// What is known of the poses beside the measurements.
struct PosesKnown {
  // Of the table, and GNSS positions of photos that it lacks.
  std::vector<OrientationRow> approximations;
  PoseObservations observed;
  Findings remarks;
  // Photos that a table names and of which nothing is measured.
  std::vector<std::string> not_there;
};

// Throws InputError for tables that cannot be read or used, as BlockApproximations does.
PosesKnown ReadPosesKnown(const BlockFile& block, const Measurements& measured);

// As AdjustMeasurements; with observed poses no photo gets a better status than without them.
JudgedBlock OrientByMeasurements(const MeasuredBlockInputs& inputs);

}  // namespace orient::block
