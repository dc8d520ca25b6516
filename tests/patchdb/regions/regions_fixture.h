// A folder of patch databases, one a region of the ground.
#pragma once

#include <filesystem>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "patchdb/regions/control_patches.h"
#include "patchdb/regions/divide.h"
#include "tests/support/patch_database_fixture.h"

namespace orient::patchdb {

inline constexpr Bounds kAll{499000, 4999000, 511000, 5011000};

inline std::multiset<std::pair<double, double>> PlacesOf(const std::vector<Patch>& patches) {
  std::multiset<std::pair<double, double>> places;
  for (const Patch& patch : patches) places.emplace(patch.ground_m.x(), patch.ground_m.y());
  return places;
}

class RegionsTest : public PatchDatabaseTest {
 protected:
  std::string regions_ = folder_ / "regions";

  RegionIndex Divide(int patches = 100, double cell_m = 5000) {
    return DivideDatabase(Filled(patches), regions_, cell_m);
  }
  std::string InRegions(const std::string& file) {
    return (std::filesystem::path(regions_) / file).string();
  }
  // A database of one source and its patches.
  void Region(const std::string& file, PatchSource source, std::vector<Patch> patches,
              const Crs& crs = Utm()) {
    std::filesystem::create_directories(regions_);
    PatchDatabase::Create(InRegions(file), crs).AddSource(source, patches);
  }
};

}  // namespace orient::patchdb
