// Speed of queries to a large patch database: patches under random footprints.
//
//   patchdb_speed DB [SIDE_M] [QUERIES]    SIDE_M: of a footprint, 2300; QUERIES: 300
//
// Make DB with tools/bench/patchdb_generate.py. Prints medians for the query of `orient patchdb
// query` (without chips) and that of `orient exterior` (with chips decoded, on all cores), then
// including the opening, as for each photo; wall-clock time, and processor time, which other
// programs do not affect. For a folder of regions (orient patchdb divide), only the last.
#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <ctime>
#include <iostream>
#include <random>

#include "core/base/median.h"
#include "patchdb/regions/control_patches.h"
#include "patchdb/store/selection.h"

namespace orient {
namespace {

double ProcessorMilliseconds() { return 1e3 * static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

// Times of pieces of work.
struct Times {
  std::vector<double> clock, processor;

  template <typename Work>
  void Add(const Work& work) {
    const double before = ProcessorMilliseconds();
    const auto start = std::chrono::steady_clock::now();
    work();
    const std::chrono::duration<double, std::milli> passed =
        std::chrono::steady_clock::now() - start;
    clock.push_back(passed.count());
    processor.push_back(ProcessorMilliseconds() - before);
  }

  void Print(const char* what) const {
    std::cout << what << UpperMedian(clock) << " ms, processor " << UpperMedian(processor)
              << " ms\n";
  }
};

// A footprint with this side at a random position.
Bounds Footprint(const Bounds& extent, double side_m, std::mt19937* random) {
  std::uniform_real_distribution<double> unit(0, 1);
  const double x = extent.min_x + unit(*random) * (extent.max_x - extent.min_x);
  const double y = extent.min_y + unit(*random) * (extent.max_y - extent.min_y);
  return {x, y, x + side_m, y + side_m};
}

void MeasureOpening(const std::string& path, const Bounds& extent, double side_m, int queries) {
  std::mt19937 random(1);
  Times opening;
  std::vector<double> found;
  for (int i = 0; i < queries; ++i) {
    const Bounds bounds = Footprint(extent, side_m, &random);
    opening.Add([&] {
      const auto patches = patchdb::ControlPatches::Open(path).FindPatchesIn(bounds);
      found.push_back(static_cast<double>(patches.size()));
    });
  }
  std::cout << "a footprint of " << side_m << " m has " << UpperMedian(found) << "\n";
  opening.Print("with opening   ");
}

void MeasureFolder(const std::string& path, double side_m, int queries) {
  const patchdb::RegionIndex index = patchdb::ReadRegionIndex(path);
  Bounds extent = Bounds::OfNothing();
  for (const patchdb::Region& region : index.regions) {
    extent.Include(region.extent.min_x, region.extent.min_y);
    extent.Include(region.extent.max_x, region.extent.max_y);
  }
  std::cout << index.regions.size() << " regions\n";
  MeasureOpening(path, extent, side_m, queries);
}

void Measure(const std::string& path, double side_m, int queries) {
  if (patchdb::IsRegionFolder(path)) return MeasureFolder(path, side_m, queries);
  const patchdb::PatchDatabase database =
      patchdb::PatchDatabase::Open(path, patchdb::PatchDatabase::Mode::kRead);
  const patchdb::PatchDatabaseInfo info = database.Info();
  std::mt19937 random(1);
  Times listing, reading;
  std::vector<double> found;
  for (int i = 0; i < queries; ++i) {
    patchdb::PatchFilter filter;
    filter.bounds = Footprint(info.extent, side_m, &random);
    int count = 0;
    listing.Add([&] {
      patchdb::VisitPatches(database, filter, [&](const patchdb::PatchSummary&) { ++count; });
    });
    found.push_back(count);
    reading.Add([&] { database.FindPatchesIn(*filter.bounds); });
  }
  std::cout << info.patches << " patches; a footprint of " << side_m << " m has "
            << UpperMedian(found) << "\n";
  listing.Print("without chips  ");
  reading.Print("with chips     ");
  MeasureOpening(path, info.extent, side_m, queries);
}

}  // namespace
}  // namespace orient

int main(int argc, char** argv) {
  if (argc < 2) {
    std::cerr << "usage: patchdb_speed DB [SIDE_M] [QUERIES]\n";
    return 1;
  }
  try {
    orient::Measure(argv[1], argc > 2 ? std::atof(argv[2]) : 2300,
                    argc > 3 ? std::atoi(argv[3]) : 300);
  } catch (const std::exception& error) {
    std::cerr << error.what() << "\n";
    return 2;
  }
}
