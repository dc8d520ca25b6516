// The databases of a folder of regions, and what they hold.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "core/geometry/bounds.h"
#include "core/terrain/crs.h"
#include "patchdb/store/patch.h"

namespace orient::patchdb {

// The largest number of a region. Ids of patches stay exact in every program's numbers.
inline constexpr int kMostRegions = 9'000'000;

struct Region {
  int number = 0;    // from 1; a database keeps it as long as it lies in the folder
  std::string file;  // name in the folder
  Bounds extent = Bounds::OfNothing();  // of its patches, if there are any
  std::int64_t patches = 0;
  // To see whether the file was changed since it was listed.
  std::int64_t bytes = 0, modified_ns = 0;
  std::map<std::int64_t, std::int64_t> sources;  // ids there -> ids of RegionIndex::sources
};

struct RegionIndex {
  Crs crs;
  int next_number = 1;               // of a database that comes; none is given twice
  std::vector<PatchSource> sources;  // the same one in several databases is one
  std::vector<Region> regions;       // by number
};

}  // namespace orient::patchdb
