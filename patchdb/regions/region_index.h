// A folder of patch databases, one for each region of a country, and the list of what they hold:
// regions.json. By it a program knows which of them to open for a photo.
#pragma once

#include <string>
#include <vector>

#include "patchdb/regions/region_list.h"

namespace orient::patchdb {

inline constexpr const char* kRegionIndexFile = "regions.json";
// In a folder that a database is being divided into (patchdb/regions/divide.h): of what.
inline constexpr const char* kDivisionNote = "not_yet_divided";

// A folder, not a single database.
bool IsRegionFolder(const std::string& path);

std::string RegionIndexPath(const std::string& folder);

std::string RegionPath(const std::string& folder, const Region& region);
// Of all, in the order of the index.
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
