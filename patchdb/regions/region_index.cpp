#include "patchdb/regions/region_index.h"

#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <filesystem>
#include <optional>
#include <regex>
#include <set>
#include <utility>

#include "core/base/atomic_write.h"
#include "core/base/error.h"
#include "core/base/folder_lock.h"
#include "core/base/partial_files.h"
#include "patchdb/regions/region_index_file.h"
#include "patchdb/store/patch_database.h"

namespace orient::patchdb {
namespace {
namespace fs = std::filesystem;

std::string Remedy(const std::string& folder) {
  return "'orient patchdb index " + folder + "' brings it up to date";
}

// Names of the databases, sorted.
std::vector<std::string> DatabasesIn(const std::string& folder) {
  std::vector<std::string> files;
  std::error_code error, no_file;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error))
    if (entry->path().extension() == ".gpkg" && entry->is_regular_file(no_file))
      files.push_back(entry->path().filename().string());
  if (error) throw InputError(folder + " cannot be read: " + error.message());
  std::sort(files.begin(), files.end());
  return files;
}

// Stores size and modification time in `region`. Throws if the file is gone.
void TakeState(const std::string& folder, Region* region) {
  struct stat state {};
  const std::string path = RegionPath(folder, *region);
  if (stat(path.c_str(), &state) != 0)
    throw InputError(fmt::format("{} is not there, but {} lists it; {}", path,
                                 RegionIndexPath(folder), Remedy(folder)));
  region->bytes = state.st_size;
  region->modified_ns = state.st_mtim.tv_sec * 1'000'000'000LL + state.st_mtim.tv_nsec;
}

// Whether SQLite's log holds changes, which belong to the database but do not show in its file.
bool HasLog(const std::string& folder, const Region& region) {
  std::error_code none;
  const std::uintmax_t bytes = fs::file_size(RegionPath(folder, region) + "-wal", none);
  return !none && bytes > 0;
}

bool IsUnchanged(const std::string& folder, const Region& region) {
  Region now = region;
  TakeState(folder, &now);
  return !HasLog(folder, region) && now.bytes == region.bytes &&
         now.modified_ns == region.modified_ns;
}

// "4711.tif (2)" is a second source of that name in its database, and may be the first in another.
std::string NameWithoutNumber(const std::string& name) {
  static const std::regex number(R"( \([0-9]+\)$)");
  return std::regex_replace(name, number, "");
}

// The sources of an index, told apart as PatchDatabase::FindSource does.
class KnownSources {
 public:
  explicit KnownSources(const std::vector<PatchSource>& sources) {
    for (const PatchSource& source : sources) Add(source);
  }
  std::optional<std::int64_t> IdOf(const PatchSource& source) const {
    const auto named = by_name_.find(NameWithoutNumber(source.name));
    if (named == by_name_.end()) return std::nullopt;
    for (const PatchSource& known : named->second)
      if (known.kind == source.kind &&
          (known.digest && source.digest ? known.digest == source.digest
                                         : known.date == source.date))
        return known.id;
    return std::nullopt;
  }
  // Its id; an unknown source gets a new one and is known from then on.
  std::int64_t IdOrNewId(PatchSource source, std::vector<PatchSource>* sources) {
    if (const auto id = IdOf(source)) return *id;
    source.id = largest_ + 1;
    Add(source);
    sources->push_back(source);
    return source.id;
  }

 private:
  void Add(const PatchSource& source) {
    by_name_[NameWithoutNumber(source.name)].push_back(source);
    largest_ = std::max(largest_, source.id);
  }
  std::map<std::string, std::vector<PatchSource>> by_name_;
  std::int64_t largest_ = 0;
};

// What the database holds now, as far as it does not depend on the index.
struct Held {
  Crs crs;
  PatchDatabaseInfo info;
  std::vector<PatchSource> sources;
};

Held Read(const std::string& path) {
  const PatchDatabase database = PatchDatabase::Open(path, PatchDatabase::Mode::kRead);
  return {database.GroundCrs(), database.Info(), database.Sources()};
}

void Describe(const std::string& folder, Region* region, RegionIndex* index,
              KnownSources* sources) {
  TakeState(folder, region);  // before it is read: changes made meanwhile are noticed next time
  const Held held = Read(RegionPath(folder, *region));
  if (!held.crs.SameAs(index->crs))
    throw InputError(fmt::format(
        "{}: its CRS is {}, that of the folder {}; keep databases of another CRS in another folder",
        RegionPath(folder, *region), held.crs.Name(), index->crs.Name()));
  region->extent = held.info.patches > 0 ? held.info.extent : Bounds::OfNothing();
  region->patches = held.info.patches;
  region->sources.clear();
  for (const PatchSource& source : held.sources)
    region->sources[source.id] = sources->IdOrNewId(source, &index->sources);
}

bool LiesWithin(const PatchDatabaseInfo& info, const Bounds& extent) {
  return info.patches == 0 || (extent.Contains(info.extent.min_x, info.extent.min_y) &&
                               extent.Contains(info.extent.max_x, info.extent.max_y));
}

bool IsStillDescribed(const std::string& folder, const Region& region, const RegionIndex& index,
                      const KnownSources& sources) {
  const Held held = Read(RegionPath(folder, region));
  return held.crs.SameAs(index.crs) && LiesWithin(held.info, region.extent) &&
         std::all_of(held.sources.begin(), held.sources.end(), [&](const PatchSource& source) {
           const auto listed = region.sources.find(source.id);
           return listed != region.sources.end() && listed->second == sources.IdOf(source);
         });
}

void RefuseUndivided(const std::string& folder) {
  std::error_code ignored;
  if (fs::exists(fs::path(folder) / kDivisionNote, ignored))
    throw InputError(folder +
                     " holds a part of a database whose division was interrupted; repeat "
                     "'orient patchdb divide', or delete the folder");
}

// The existing index, or one without regions, in the CRS of this database.
RegionIndex IndexBefore(const std::string& folder, const std::string& file) {
  std::error_code ignored;
  if (fs::exists(RegionIndexPath(folder), ignored)) return ReadRegionIndex(folder);
  const std::string path = (fs::path(folder) / file).string();
  return {PatchDatabase::Open(path, PatchDatabase::Mode::kRead).GroundCrs(), 1, {}, {}};
}

}  // namespace

bool IsRegionFolder(const std::string& path) {
  std::error_code ignored;
  return fs::is_directory(path, ignored);
}

std::string RegionIndexPath(const std::string& folder) {
  return (fs::path(folder) / kRegionIndexFile).string();
}

std::string RegionPath(const std::string& folder, const Region& region) {
  return (fs::path(folder) / region.file).string();
}

std::vector<std::string> RegionFiles(const std::string& folder, const RegionIndex& index) {
  std::vector<std::string> files;
  for (const Region& region : index.regions) files.push_back(RegionPath(folder, region));
  return files;
}

RegionIndex ReadRegionIndex(const std::string& folder) {
  const std::string path = RegionIndexPath(folder);
  std::error_code ignored;
  if (!fs::exists(path, ignored)) {
    RefuseUndivided(folder);
    throw InputError(
        fmt::format("{} has no {}; if it is a folder of patch databases, 'orient "
                    "patchdb index {}' makes it",
                    folder, kRegionIndexFile, folder));
  }
  return RegionIndexFromText(ReadFile(path), path);
}

RegionIndex IndexRegions(const std::string& folder, Division division) {
  if (!IsRegionFolder(folder)) throw InputError(folder + " is not a folder");
  if (division == Division::kNone) RefuseUndivided(folder);
  const std::vector<std::string> files = DatabasesIn(folder);
  if (files.empty()) throw InputError(folder + " holds no patch databases (*.gpkg)");
  const FolderLock lock(folder, ".orient-regions.lock");
  RemovePartialFiles(folder);
  const RegionIndex before = IndexBefore(folder, files.front());
  RegionIndex index{before.crs, before.next_number, before.sources, {}};
  KnownSources sources(index.sources);
  std::set<std::string> listed;
  for (const Region& region : before.regions) {
    listed.insert(region.file);
    if (!std::binary_search(files.begin(), files.end(), region.file)) continue;
    index.regions.push_back(region);
    if (!IsUnchanged(folder, region)) Describe(folder, &index.regions.back(), &index, &sources);
  }
  for (const std::string& file : files) {
    if (listed.contains(file)) continue;
    if (index.next_number > kMostRegions)
      throw InputError(folder + " has used up the numbers of its regions; begin a new folder");
    index.regions.emplace_back();
    index.regions.back().number = index.next_number++;
    index.regions.back().file = file;
    Describe(folder, &index.regions.back(), &index, &sources);
  }
  WriteFileAtomically(RegionIndexPath(folder), TextOfRegionIndex(index));
  return index;
}

void RequireCurrent(const std::string& folder, const RegionIndex& index) {
  std::vector<std::string> files = DatabasesIn(folder);
  const KnownSources sources(index.sources);
  for (const Region& region : index.regions) {
    const bool unchanged = IsUnchanged(folder, region);  // throws where it is gone
    std::erase(files, region.file);
    if (unchanged || IsStillDescribed(folder, region, index, sources)) continue;
    throw InputError(fmt::format("{} was changed since {} was made; {}", RegionPath(folder, region),
                                 RegionIndexPath(folder), Remedy(folder)));
  }
  if (files.empty()) return;
  throw InputError(fmt::format("{} is not listed in {}; {}",
                               (fs::path(folder) / files.front()).string(), RegionIndexPath(folder),
                               Remedy(folder)));
}

}  // namespace orient::patchdb
