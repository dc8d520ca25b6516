// How fast a large patch database answers: patches under random footprints.
//
//   patchdb_speed DB [SIDE_M] [QUERIES]    SIDE_M: of a footprint, 2300; QUERIES: 300
//
// Make DB with tools/bench/patchdb_generate.py. Prints medians: of what `orient patchdb query` asks
// (without chips) and of what `orient exterior` asks (with chips decoded, on all cores); by the
// clock, and of processor time, which other programs do not change.
#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <ctime>
#include <iostream>
#include <random>

#include "core/base/median.h"
#include "patchdb/store/selection.h"

namespace orient {
namespace {

double ProcessorMilliseconds() { return 1e3 * static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

// How long pieces of work take.
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

void Measure(const std::string& path, double side_m, int queries) {
  const patchdb::PatchDatabase database =
      patchdb::PatchDatabase::Open(path, patchdb::PatchDatabase::Mode::kRead);
  const patchdb::PatchDatabaseInfo info = database.Info();
  std::mt19937 random(1);
  std::uniform_real_distribution<double> unit(0, 1);
  Times listing, reading;
  std::vector<double> found;
  for (int i = 0; i < queries; ++i) {
    const double x = info.extent.min_x + unit(random) * (info.extent.max_x - info.extent.min_x);
    const double y = info.extent.min_y + unit(random) * (info.extent.max_y - info.extent.min_y);
    patchdb::PatchFilter filter;
    filter.bounds = Bounds{x, y, x + side_m, y + side_m};
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
