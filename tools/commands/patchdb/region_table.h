// What a folder of patch databases holds, for people.
#pragma once

#include <iosfwd>

#include "patchdb/regions/region_index.h"

namespace orient {

void PrintRegions(const patchdb::RegionIndex& index, std::ostream& out);

}  // namespace orient
