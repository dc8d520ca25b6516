// regions.json as text (docs/patchdb_file.md). Private to patchdb/regions.
#pragma once

#include <string>

#include "patchdb/regions/region_list.h"

namespace orient::patchdb {

std::string TextOfRegionIndex(const RegionIndex& index);

// Throws InputError naming `path` and the remedy: damaged, or a newer program's. What is accepted
// is whole: numbers are of one region or source each, extents of regions with patches are there.
RegionIndex RegionIndexFromText(const std::string& text, const std::string& path);

}  // namespace orient::patchdb
