#include "patchdb/regions/divide.h"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <map>
#include <utility>
#include <vector>

#include "core/base/atomic_write.h"
#include "core/base/error.h"
#include "core/base/folder_lock.h"
#include "core/base/output_directory.h"
#include "core/base/partial_files.h"
#include "patchdb/maintenance/merge.h"
#include "patchdb/store/content_digest.h"
#include "patchdb/store/selection.h"

namespace orient::patchdb {
namespace {
namespace fs = std::filesystem;

constexpr std::size_t kMostCells = 100'000;

using Cell = std::pair<std::int64_t, std::int64_t>;  // east, north; of cells

Cell CellOf(const Eigen::Vector3d& ground_m, double cell_m) {
  return {static_cast<std::int64_t>(std::floor(ground_m.x() / cell_m)),
          static_cast<std::int64_t>(std::floor(ground_m.y() / cell_m))};
}

// Ids of each cell's patches.
using Cells = std::map<Cell, std::vector<std::int64_t>>;

Cells CellsOf(const PatchDatabase& database, double cell_m) {
  constexpr double kFarthest_m = 1e9;
  Cells cells;
  VisitPatches(database, {}, [&](const PatchSummary& patch) {
    if (!(patch.ground_m.cwiseAbs().maxCoeff() < kFarthest_m))
      throw InputError(
          fmt::format("{}: the place of patch {} is damaged; 'orient patchdb check "
                      "--repair' may help",
                      database.Path(), patch.id));
    cells[CellOf(patch.ground_m, cell_m)].push_back(patch.id);
    if (cells.size() > kMostCells)
      throw UsageError(fmt::format("cells of {} m would be more than {} regions; give a larger one",
                                   cell_m, kMostCells));
  });
  if (cells.empty()) throw InputError(database.Path() + " holds no patches");
  return cells;
}

std::string FileOf(const Cell& cell, double cell_m) {
  return fmt::format("x{}_y{}.gpkg", static_cast<double>(cell.first) * cell_m,
                     static_cast<double>(cell.second) * cell_m);
}

// Accepts a folder that is new, or empty, or in which this very division was interrupted.
void Begin(const std::string& folder, const std::string& what) {
  RemovePartialFiles(folder);
  const std::string note = (fs::path(folder) / kDivisionNote).string();
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

// A file that is there already is complete.
void Copy(const PatchDatabase& database, const std::vector<std::int64_t>& ids,
          const std::string& path) {
  std::error_code ignored;
  if (fs::exists(path, ignored)) return;
  MergeOptions options;
  options.policy = MergePolicy::kCopy;
  options.filter.ids = ids;
  PatchDatabase::Create(path, database.GroundCrs(),
                        [&](PatchDatabase& region) { MergeDatabase(region, database, options); });
}

}  // namespace

RegionIndex DivideDatabase(const PatchDatabase& database, const std::string& folder, double cell_m,
                           const DivideProgress& progress) {
  const std::string content = ContentOf(database);
  const Cells cells = CellsOf(database, cell_m);
  Begin(folder, fmt::format("{}\n{} m\n", content, cell_m));
  std::int64_t patches = 0, copied = 0;
  {
    const FolderLock lock(folder, ".orient-regions.lock");
    int done = 0;
    for (const auto& [cell, ids] : cells) {
      Copy(database, ids, (fs::path(folder) / FileOf(cell, cell_m)).string());
      patches += static_cast<std::int64_t>(ids.size());
      if (progress) progress(++done, static_cast<int>(cells.size()));
    }
  }
  RegionIndex index = IndexRegions(folder, Division::kUnderWay);
  for (const Region& region : index.regions) copied += region.patches;
  if (ContentOf(database) != content || copied != patches)
    throw InputError(fmt::format(
        "{} was changed while it was divided, or is damaged ({} of {} patches were copied); delete "
        "{} and divide it again",
        database.Path(), copied, patches, folder));
  fs::remove(fs::path(folder) / kDivisionNote);
  return index;
}

}  // namespace orient::patchdb
