// COLMAP's binary model. Private to core/exchange.
//
// Little-endian: counts are uint64, ids int32 (of points uint64), numbers doubles, names end with a
// zero byte (src/colmap/scene/reconstruction_io.cc).
#pragma once

#include <string>
#include <vector>

#include "core/exchange/colmap_model.h"

namespace orient {

// Whether `directory` holds a binary model.
bool HoldsBinaryColmap(const std::string& directory);

// Both throw InputError naming file, byte and what is wrong.
ColmapModel ReadBinaryColmap(const std::string& directory);
std::vector<ColmapObservation> ReadBinaryColmapObservations(const std::string& directory);

}  // namespace orient
