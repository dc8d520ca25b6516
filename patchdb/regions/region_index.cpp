#include "patchdb/regions/region_index.h"

#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <utility>

#include "core/base/atomic_write.h"
#include "core/base/error.h"
#include "core/base/folder_lock.h"
#include "core/base/partial_files.h"
#include "patchdb/store/patch_database.h"

namespace orient::patchdb {
namespace {
namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr int kVersion = 1;

std::string Remedy(const std::string& folder) {
  return "'orient patchdb index " + folder + "' brings it up to date";
}

std::string PathOf(const std::string& folder, const Region& region) {
  return (fs::path(folder) / region.file).string();
}

// Names of the databases, sorted.
std::vector<std::string> DatabasesIn(const std::string& folder) {
  std::vector<std::string> files;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error))
    if (entry->path().extension() == ".gpkg" && entry->is_regular_file())
      files.push_back(entry->path().filename().string());
  if (error) throw InputError(folder + " cannot be read: " + error.message());
  std::sort(files.begin(), files.end());
  return files;
}

// Length and time of change, into `region`. Throws where the file is gone.
void TakeState(const std::string& folder, Region* region) {
  struct stat state {};
  const std::string path = PathOf(folder, *region);
  if (stat(path.c_str(), &state) != 0)
    throw InputError(fmt::format("{} is not there, but {} lists it; {}", path,
                                 RegionIndexPath(folder), Remedy(folder)));
  region->bytes = state.st_size;
  region->modified_ns = state.st_mtim.tv_sec * 1'000'000'000LL + state.st_mtim.tv_nsec;
}

bool IsUnchanged(const std::string& folder, const Region& region) {
  Region now = region;
  TakeState(folder, &now);
  return now.bytes == region.bytes && now.modified_ns == region.modified_ns;
}

// As PatchDatabase::FindSource tells sources apart.
bool IsSame(const PatchSource& a, const PatchSource& b) {
  if (a.kind != b.kind || a.name != b.name) return false;
  return a.digest && b.digest ? a.digest == b.digest : a.date == b.date;
}

std::optional<std::int64_t> IdOf(const PatchSource& source, const RegionIndex& index) {
  for (const PatchSource& known : index.sources)
    if (IsSame(known, source)) return known.id;
  return std::nullopt;
}

std::int64_t IdOrNewId(const PatchSource& source, RegionIndex* index) {
  if (const auto id = IdOf(source, *index)) return *id;
  PatchSource added = source;
  added.id = static_cast<std::int64_t>(index->sources.size()) + 1;
  index->sources.push_back(added);
  return added.id;
}

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

void Describe(const std::string& folder, Region* region, RegionIndex* index) {
  TakeState(folder, region);  // before it is read: what changes meanwhile is seen the next time
  const Held held = Read(PathOf(folder, *region));
  if (!held.crs.SameAs(index->crs))
    throw InputError(
        fmt::format("{}: its CRS is {}, that of the others {}; the databases of a folder have one",
                    PathOf(folder, *region), held.crs.Name(), index->crs.Name()));
  region->extent = held.info.patches > 0 ? held.info.extent : Bounds::OfNothing();
  region->patches = held.info.patches;
  region->sources.clear();
  for (const PatchSource& source : held.sources)
    region->sources[source.id] = IdOrNewId(source, index);
}

bool LiesWithin(const PatchDatabaseInfo& info, const Bounds& extent) {
  return info.patches == 0 || (extent.Contains(info.extent.min_x, info.extent.min_y) &&
                               extent.Contains(info.extent.max_x, info.extent.max_y));
}

bool IsStillDescribed(const std::string& folder, const Region& region, const RegionIndex& index) {
  const Held held = Read(PathOf(folder, region));
  return held.crs.SameAs(index.crs) && LiesWithin(held.info, region.extent) &&
         std::all_of(held.sources.begin(), held.sources.end(), [&](const PatchSource& source) {
           const auto listed = region.sources.find(source.id);
           return listed != region.sources.end() && listed->second == IdOf(source, index);
         });
}

template <typename T>
Json OrNull(const std::optional<T>& value) {
  return value ? Json(*value) : Json(nullptr);
}

std::optional<std::string> TextOf(const Json& field) {
  if (field.is_null()) return std::nullopt;
  return field.get<std::string>();
}

Json ToJson(const PatchSource& source) {
  return {{"id", source.id},       {"kind", Name(source.kind)},
          {"name", source.name},   {"date", OrNull(source.date)},
          {"gsd_m", source.gsd_m}, {"digest", OrNull(source.digest)}};
}

PatchSource SourceFrom(const Json& field) {
  PatchSource source;
  source.id = field.at("id");
  const std::string kind = field.at("kind");
  for (const SourceKind one : {SourceKind::kPhoto, SourceKind::kOrthophoto, SourceKind::kGcp})
    if (kind == Name(one)) source.kind = one;
  source.name = field.at("name");
  source.date = TextOf(field.at("date"));
  source.gsd_m = field.at("gsd_m");
  source.digest = TextOf(field.at("digest"));
  return source;
}

Json ToJson(const Region& region) {
  Json extent = nullptr;
  if (region.patches > 0)
    extent = {region.extent.min_x, region.extent.min_y, region.extent.max_x, region.extent.max_y};
  return {{"number", region.number},   {"file", region.file},   {"extent", extent},
          {"patches", region.patches}, {"bytes", region.bytes}, {"modified_ns", region.modified_ns},
          {"sources", region.sources}};
}

Region RegionFrom(const Json& field, const std::string& path) {
  Region region;
  region.number = field.at("number");
  region.file = field.at("file");
  if (const Json& extent = field.at("extent"); !extent.is_null())
    region.extent = {extent.at(0), extent.at(1), extent.at(2), extent.at(3)};
  region.patches = field.at("patches");
  region.bytes = field.at("bytes");
  region.modified_ns = field.at("modified_ns");
  region.sources = field.at("sources").get<std::map<std::int64_t, std::int64_t>>();
  // Its name is joined to the folder's: none leads out of it.
  if (fs::path(region.file).filename() != region.file || region.number < 1)
    throw InputError(fmt::format("{} is damaged: \"{}\", number {}, is no database of its folder",
                                 path, region.file, region.number));
  return region;
}

RegionIndex IndexFrom(const Json& document, const std::string& path) {
  RegionIndex index{
      Crs::Parse(document.at("crs").get<std::string>(), path), document.at("next_number"), {}, {}};
  for (const Json& source : document.at("sources")) index.sources.push_back(SourceFrom(source));
  std::set<int> numbers;
  std::set<std::int64_t> sources;
  for (const PatchSource& source : index.sources) sources.insert(source.id);
  for (const Json& field : document.at("regions")) {
    index.regions.push_back(RegionFrom(field, path));
    const Region& region = index.regions.back();
    const bool known = std::all_of(region.sources.begin(), region.sources.end(),
                                   [&](const auto& one) { return sources.contains(one.second); });
    if (!known || !numbers.insert(region.number).second || region.number >= index.next_number)
      throw InputError(
          fmt::format("{} is damaged: numbers of regions or sources are not those of "
                      "one list",
                      path));
  }
  return index;
}

void Write(const std::string& folder, const RegionIndex& index) {
  Json document = {{"version", kVersion},
                   {"crs", index.crs.Wkt()},
                   {"next_number", index.next_number},
                   {"sources", Json::array()},
                   {"regions", Json::array()}};
  for (const PatchSource& source : index.sources) document["sources"].push_back(ToJson(source));
  for (const Region& region : index.regions) document["regions"].push_back(ToJson(region));
  WriteFileAtomically(RegionIndexPath(folder), document.dump(1) + "\n");
}

// The index that is there, or one of no regions, in the CRS of this database.
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

std::vector<std::string> RegionFiles(const std::string& folder, const RegionIndex& index) {
  std::vector<std::string> files;
  for (const Region& region : index.regions) files.push_back(PathOf(folder, region));
  return files;
}

RegionIndex ReadRegionIndex(const std::string& folder) {
  const std::string path = RegionIndexPath(folder);
  std::error_code ignored;
  if (!fs::exists(path, ignored))
    throw InputError(
        fmt::format("{} has no {}; if it is a folder of patch databases, 'orient "
                    "patchdb index {}' makes it",
                    folder, kRegionIndexFile, folder));
  try {
    const Json document = Json::parse(ReadFile(path));
    const int version = document.at("version");
    if (version != kVersion)
      throw InputError(fmt::format("{} is of version {}, this program reads version {}", path,
                                   version, kVersion));
    return IndexFrom(document, path);
  } catch (const Json::exception& error) {
    throw InputError(
        fmt::format("{} is damaged ({}); delete it and make it again with 'orient "
                    "patchdb index {}'",
                    path, error.what(), folder));
  }
}

RegionIndex IndexRegions(const std::string& folder) {
  if (!IsRegionFolder(folder)) throw InputError(folder + " is not a folder");
  const std::vector<std::string> files = DatabasesIn(folder);
  if (files.empty()) throw InputError(folder + " holds no patch databases (*.gpkg)");
  const FolderLock lock(folder, ".orient-regions.lock");
  RemovePartialFiles(folder);
  const RegionIndex before = IndexBefore(folder, files.front());
  RegionIndex index{before.crs, before.next_number, before.sources, {}};
  for (const Region& region : before.regions) {
    if (!std::binary_search(files.begin(), files.end(), region.file)) continue;
    index.regions.push_back(region);
    if (!IsUnchanged(folder, region)) Describe(folder, &index.regions.back(), &index);
  }
  for (const std::string& file : files) {
    const auto is_this = [&](const Region& region) { return region.file == file; };
    if (std::any_of(before.regions.begin(), before.regions.end(), is_this)) continue;
    Region region;
    region.number = index.next_number++;
    region.file = file;
    Describe(folder, &region, &index);
    index.regions.push_back(std::move(region));
  }
  Write(folder, index);
  return index;
}

void RequireCurrent(const std::string& folder, const RegionIndex& index) {
  std::vector<std::string> files = DatabasesIn(folder);
  for (const Region& region : index.regions) {
    const bool unchanged = IsUnchanged(folder, region);  // throws where it is gone
    std::erase(files, region.file);
    if (unchanged || IsStillDescribed(folder, region, index)) continue;
    throw InputError(fmt::format("{} was changed since {} was made; {}", PathOf(folder, region),
                                 RegionIndexPath(folder), Remedy(folder)));
  }
  if (files.empty()) return;
  throw InputError(fmt::format("{} is not listed in {}; {}",
                               (fs::path(folder) / files.front()).string(), RegionIndexPath(folder),
                               Remedy(folder)));
}

}  // namespace orient::patchdb
