// How fast a large patch database answers: patches under random footprints.
//
//   patchdb_speed DB [SIDE_M] [QUERIES]    SIDE_M: of a footprint, 2300; QUERIES: 300
//
// Make DB with tools/bench/patchdb_generate.py. Prints medians of processor time: of what `orient
// patchdb query` asks (without chips) and of what `orient exterior` asks (with chips decoded).
#include <algorithm>
#include <cstdlib>
#include <ctime>
#include <iostream>
#include <random>

#include "core/median.h"
#include "patchdb/selection.h"

namespace orient {
namespace {

double Milliseconds() { return 1e3 * static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

void Measure(const std::string& path, double side_m, int queries) {
  const PatchDatabase database = PatchDatabase::Open(path, PatchDatabase::Mode::kRead);
  const PatchDatabaseInfo info = database.Info();
  std::mt19937 random(1);
  std::uniform_real_distribution<double> unit(0, 1);
  std::vector<double> listing, reading, found;
  for (int i = 0; i < queries; ++i) {
    const double x = info.extent.min_x + unit(random) * (info.extent.max_x - info.extent.min_x);
    const double y = info.extent.min_y + unit(random) * (info.extent.max_y - info.extent.min_y);
    PatchFilter filter;
    filter.bounds = Bounds{x, y, x + side_m, y + side_m};
    double start = Milliseconds();
    int count = 0;
    VisitPatches(database, filter, [&](const PatchSummary&) { ++count; });
    listing.push_back(Milliseconds() - start);
    found.push_back(count);
    start = Milliseconds();
    database.FindPatchesIn(*filter.bounds);
    reading.push_back(Milliseconds() - start);
  }
  std::cout << info.patches << " patches; a footprint of " << side_m << " m has "
            << UpperMedian(found) << "\nwithout chips  " << UpperMedian(listing)
            << " ms\nwith chips     " << UpperMedian(reading) << " ms\n";
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
