// A database in numbers: how many patches of which source, how dense, how they fare.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "patchdb/store/patch_database.h"

namespace orient::patchdb {

struct SourceCount {
  std::string kind, name, date;  // date "" where unknown
  std::int64_t patches = 0, retired = 0;
};

// Attempts in oriented photos (not failed ones) and how many of them matched.
struct SuccessCount {
  std::string group;
  std::int64_t attempts = 0, matched = 0;
};

struct PatchStatistics {
  std::vector<SourceCount> sources;
  std::vector<SuccessCount> by_age;     // years between source and photo, by decades
  std::vector<SuccessCount> by_season;  // of the photo: months
  std::vector<SuccessCount> retired;    // group: the reason; attempts: patches
};

PatchStatistics CountEverything(const PatchDatabase& database);

// Active patches a cell, row 0 in the north; cells begin at multiples of cell_m.
struct DensityGrid {
  double west_m = 0, north_m = 0, cell_m = 0;
  int width = 0, height = 0;
  std::vector<int> counts;
};
// Empty where there are no patches. Throws InputError where it would have more than 100 million
// cells.
DensityGrid CountDensity(const PatchDatabase& database, double cell_m);

}  // namespace orient::patchdb
