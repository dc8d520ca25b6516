#include "patchdb/regions/divide.h"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <limits>
#include <set>
#include <utility>

#include "core/base/atomic_write.h"
#include "core/base/error.h"
#include "core/base/folder_lock.h"
#include "core/base/output_directory.h"
#include "patchdb/maintenance/merge.h"
#include "patchdb/store/content_digest.h"
#include "patchdb/store/selection.h"

namespace orient::patchdb {
namespace {
namespace fs = std::filesystem;

constexpr const char* kNote = "not_yet_divided";  // of what, as long as it is being divided
constexpr std::size_t kMostCells = 100'000;

using Cell = std::pair<std::int64_t, std::int64_t>;  // east, north; of cells

Cell CellOf(const Eigen::Vector3d& ground_m, double cell_m) {
  return {static_cast<std::int64_t>(std::floor(ground_m.x() / cell_m)),
          static_cast<std::int64_t>(std::floor(ground_m.y() / cell_m))};
}

std::set<Cell> CellsOf(const PatchDatabase& database, double cell_m) {
  std::set<Cell> cells;
  VisitPatches(database, {}, [&](const PatchSummary& patch) {
    if (!patch.ground_m.allFinite())
      throw InputError(
          fmt::format("{}: the place of patch {} is damaged; 'orient patchdb check "
                      "--repair' may help",
                      database.Path(), patch.id));
    cells.insert(CellOf(patch.ground_m, cell_m));
    if (cells.size() > kMostCells)
      throw UsageError(fmt::format("cells of {} m would be more than {} regions; give a larger one",
                                   cell_m, kMostCells));
  });
  if (cells.empty()) throw InputError(database.Path() + " holds no patches");
  return cells;
}

// Its northern and eastern edges are those of its neighbours.
Bounds BoundsOf(const Cell& cell, double cell_m) {
  const auto edge = [&](std::int64_t n) { return static_cast<double>(n) * cell_m; };
  const auto before = [](double value) {
    return std::nextafter(value, -std::numeric_limits<double>::infinity());
  };
  return {edge(cell.first), edge(cell.second), before(edge(cell.first + 1)),
          before(edge(cell.second + 1))};
}

std::string FileOf(const Cell& cell, double cell_m) {
  return fmt::format("x{}_y{}.gpkg", static_cast<double>(cell.first) * cell_m,
                     static_cast<double>(cell.second) * cell_m);
}

// The folder is new, or empty, or one where this very division was interrupted.
void Begin(const std::string& folder, const std::string& what) {
  const std::string note = (fs::path(folder) / kNote).string();
  std::error_code ignored;
  if (fs::exists(note, ignored)) {
    if (ReadFile(note) == what) return;
    throw InputError(folder +
                     " holds an interrupted division of another database, or of other "
                     "cells; delete it or name another folder");
  }
  if (fs::exists(folder, ignored) && !fs::is_directory(folder, ignored))
    throw InputError(folder + " is a file; name a folder");
  if (fs::exists(folder, ignored) && !fs::is_empty(folder, ignored))
    throw InputError(folder + " is not empty; name a new folder");
  MakeOutputDirectory(folder);
  WriteFileAtomically(note, what);
}

}  // namespace

RegionIndex DivideDatabase(const PatchDatabase& database, const std::string& folder, double cell_m,
                           const DivideProgress& progress) {
  const std::set<Cell> cells = CellsOf(database, cell_m);
  const std::string content = ContentOf(database);
  Begin(folder, fmt::format("{}\n{} m\n", content, cell_m));
  {
    const FolderLock lock(folder, ".orient-regions.lock");
    int done = 0;
    for (const Cell& cell : cells) {
      const std::string path = (fs::path(folder) / FileOf(cell, cell_m)).string();
      MergeOptions options;
      options.policy = MergePolicy::kCopy;
      options.filter.bounds = BoundsOf(cell, cell_m);
      std::error_code ignored;
      if (!fs::exists(path, ignored))  // else it is whole
        PatchDatabase::Create(path, database.GroundCrs(), [&](PatchDatabase& region) {
          MergeDatabase(region, database, options);
        });
      if (progress) progress(++done, static_cast<int>(cells.size()));
    }
  }
  if (ContentOf(database) != content)
    throw InputError(
        fmt::format("{} was changed while it was divided; delete {} and divide it again",
                    database.Path(), folder));
  RegionIndex index = IndexRegions(folder);
  fs::remove(fs::path(folder) / kNote);
  return index;
}

}  // namespace orient::patchdb
