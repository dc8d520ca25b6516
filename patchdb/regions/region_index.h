// A folder of patch databases, one for each region of a country, and the list of what they hold:
// regions.json. By it a program knows which of them to open for a photo.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "core/terrain/crs.h"
#include "core/terrain/ground_surface.h"
#include "patchdb/store/patch.h"

namespace orient::patchdb {

inline constexpr const char* kRegionIndexFile = "regions.json";
// In a folder that a database is being divided into (patchdb/regions/divide.h): of what.
inline constexpr const char* kDivisionNote = "not_yet_divided";
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

// A folder, not a single database.
bool IsRegionFolder(const std::string& path);

std::string RegionIndexPath(const std::string& folder);

// Paths of the databases, in the order of the index.
std::vector<std::string> RegionFiles(const std::string& folder, const RegionIndex& index);

// Throws InputError: there is none, it is damaged, a newer program's.
RegionIndex ReadRegionIndex(const std::string& folder);

// Makes it, or brings it up to date, reading only databases that are new or changed; numbers and
// the sources' ids stay. Throws InputError: no databases in the folder, several CRSs, a database
// that cannot be read, an interrupted division, another program at it.
enum class Division { kNone, kUnderWay };
RegionIndex IndexRegions(const std::string& folder, Division division = Division::kNone);

// Throws InputError where a database came, went, grew beyond the extent that is listed, or has
// sources that are not.
void RequireCurrent(const std::string& folder, const RegionIndex& index);

}  // namespace orient::patchdb
