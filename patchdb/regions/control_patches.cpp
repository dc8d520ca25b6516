#include "patchdb/regions/control_patches.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <exception>
#include <utility>

#include "core/base/environment_error.h"
#include "core/base/error.h"
#include "patchdb/store/content_digest.h"

namespace orient::patchdb {
namespace {

constexpr std::int64_t kIdsOfRegion = 1'000'000'000;
constexpr std::size_t kMostOpened = 8;  // per thread: each takes two of a process's 1024 files

bool Touch(const Bounds& a, const Bounds& b) {
  return a.min_x <= b.max_x && a.max_x >= b.min_x && a.min_y <= b.max_y && a.max_y >= b.min_y;
}

}  // namespace

ControlPatches ControlPatches::Open(const std::string& path, Mode mode) {
  ControlPatches patches(path, mode);
  if (!IsRegionFolder(path)) {
    patches.opened_.emplace(0, PatchDatabase::Open(path, mode));
    return patches;
  }
  patches.index_ = std::make_shared<const RegionIndex>(ReadRegionIndex(path));
  if (mode == Mode::kRead) return patches;
  std::vector<std::string> written = RegionFiles(path, *patches.index_);
  written.push_back(path);  // SQLite writes its logs there
  for (const std::string& name : written)
    if (access(name.c_str(), W_OK) != 0) throw InputError(name + " may not be written");
  return patches;
}

ControlPatches ControlPatches::Another() const {
  if (!IsFolder()) return Open(path_, mode_);
  ControlPatches another(path_, mode_);
  another.index_ = index_;
  return another;
}

void ControlPatches::RequireCurrentIndex() const {
  if (IsFolder()) RequireCurrent(path_, *index_);
}

Crs ControlPatches::GroundCrs() const {
  return IsFolder() ? index_->crs : opened_.at(0).GroundCrs();
}

PatchDatabase& ControlPatches::OpenedRegion(const Region& region) const {
  const auto found = opened_.find(region.number);
  if (found != opened_.end()) return found->second;
  if (opened_.size() >= kMostOpened) opened_.clear();
  return opened_.emplace(region.number, PatchDatabase::Open(RegionPath(path_, region), mode_))
      .first->second;
}

const Region* ControlPatches::RegionOf(std::int64_t id) const {
  for (const Region& region : index_->regions)
    if (region.number == id / kIdsOfRegion) return &region;
  return nullptr;
}

std::vector<const Region*> ControlPatches::RegionsTouching(const std::vector<Bounds>& areas) const {
  std::vector<const Region*> touching;
  for (const Region& region : index_->regions)
    if (region.patches > 0 && std::any_of(areas.begin(), areas.end(), [&](const Bounds& area) {
          return Touch(region.extent, area);
        }))
      touching.push_back(&region);
  return touching;
}

Patch ControlPatches::AsOfSet(Patch patch, const Region& region) const {
  const auto source = [&](std::int64_t id) {
    const auto known = region.sources.find(id);
    if (known != region.sources.end()) return known->second;
    // The file was in order when the run began: no verdict on a photo.
    throw EnvironmentError(fmt::format(
        "{} was changed since the run began: {} does not list all of its sources; 'orient patchdb "
        "index {}' updates it; then repeat the command",
        RegionPath(path_, region), RegionIndexPath(path_), path_));
  };
  const auto of_set = [&](std::int64_t id) {
    if (id <= 0 || id >= kIdsOfRegion)
      throw InputError(fmt::format("{}: patch {}: a region's numbers must be from 1 to {}",
                                   RegionPath(path_, region), id, kIdsOfRegion - 1));
    return region.number * kIdsOfRegion + id;
  };
  patch.id = of_set(patch.id);
  patch.source_id = source(patch.source_id);
  if (patch.superseded_by != 0) patch.superseded_by = of_set(patch.superseded_by);
  for (PatchEvidence& evidence : patch.evidence) evidence.source_id = source(evidence.source_id);
  return patch;
}

std::vector<Patch> ControlPatches::FindPatchesIn(const Bounds& bounds, int max_count) const {
  if (!IsFolder()) return opened_.at(0).FindPatchesIn(bounds, max_count);
  const std::vector<const Region*> regions = RegionsTouching({bounds});
  std::vector<std::int64_t> counts;
  std::int64_t total = 0;
  for (const Region* region : regions) {
    counts.push_back(OpenedRegion(*region).CountPatchesIn(bounds));
    total += counts.back();
  }
  std::vector<Patch> patches;
  std::map<std::array<double, 4>, int> region_of_place;  // by source and place
  for (std::size_t i = 0; i < regions.size(); ++i) {
    // The region's share of the patches wanted.
    const double part = std::min(1.0, max_count / std::max(1.0, static_cast<double>(total)));
    const int share = static_cast<int>(std::ceil(part * static_cast<double>(counts[i])));
    if (share == 0) continue;
    for (Patch& found : OpenedRegion(*regions[i]).FindPatchesIn(bounds, share)) {
      Patch patch = AsOfSet(std::move(found), *regions[i]);
      const Eigen::Vector3d& at = patch.ground_m;
      const int number = regions[i]->number;
      const auto [known, is_new] = region_of_place.emplace(
          std::array{static_cast<double>(patch.source_id), at.x(), at.y(), at.z()}, number);
      if (is_new || known->second == number) patches.push_back(std::move(patch));
    }
  }
  return patches;
}

std::optional<Patch> ControlPatches::ReadPatch(std::int64_t id) const {
  if (!IsFolder()) return opened_.at(0).ReadPatch(id);
  const Region* region = RegionOf(id);
  if (region == nullptr) return std::nullopt;
  auto patch = OpenedRegion(*region).ReadPatch(id % kIdsOfRegion);
  if (!patch) return std::nullopt;
  return AsOfSet(*std::move(patch), *region);
}

std::vector<PatchSource> ControlPatches::Sources() const {
  return IsFolder() ? index_->sources : opened_.at(0).Sources();
}

std::string ControlPatches::ContentWithin(const std::vector<Bounds>& areas) const {
  if (!IsFolder()) return ContentOf(opened_.at(0));
  std::string content = index_->crs.Wkt();
  for (const Region* region : RegionsTouching(areas))
    content += fmt::format("\n{} {}", region->number, ContentOf(OpenedRegion(*region)));
  return content;
}

// Each region's own attempts, with its own patch ids.
ControlPatches::AttemptsByRegion ControlPatches::Divided(
    const std::vector<MatchAttempt>& attempts) const {
  AttemptsByRegion by_region;
  for (const MatchAttempt& attempt : attempts)
    if (const Region* region = RegionOf(attempt.patch_id)) {
      by_region[region->number].push_back(attempt);
      by_region[region->number].back().patch_id = attempt.patch_id % kIdsOfRegion;
    }
  return by_region;
}

// The patches searched for in a region's attempts, with their ground positions.
std::vector<SoughtElsewhere> ControlPatches::Sought(const Region& region,
                                                    const std::vector<MatchAttempt>& own) const {
  std::vector<SoughtElsewhere> sought;
  const PatchDatabase& database = OpenedRegion(region);
  for (const MatchAttempt& attempt : own)
    if (attempt.state != "not_visible")
      if (const auto place_m = database.PlaceSought(attempt))
        sought.push_back({attempt.photo, *place_m, attempt.state == "matched"});
  return sought;
}

int ControlPatches::RecordAttempts(const std::vector<MatchAttempt>& attempts) {
  if (!IsFolder()) return opened_.at(0).RecordAttempts(attempts);
  const AttemptsByRegion by_region = Divided(attempts);
  std::map<int, std::vector<SoughtElsewhere>> sought;
  std::exception_ptr first;
  int of_others = 0;
  const auto of_each = [&](const auto& work) {
    for (const Region& region : index_->regions)
      if (const auto own = by_region.find(region.number); own != by_region.end()) try {
          work(region, own->second);
        } catch (const InputError&) {
          if (!first) first = std::current_exception();
        }
  };
  of_each(
      [&](const Region& region, const auto& own) { sought[region.number] = Sought(region, own); });
  of_each([&](const Region& region, const auto& own) {
    std::vector<SoughtElsewhere> elsewhere;
    for (const auto& [number, patches] : sought)
      if (number != region.number)
        elsewhere.insert(elsewhere.end(), patches.begin(), patches.end());
    of_others += OpenedRegion(region).RecordAttempts(own, elsewhere);
  });
  if (first) std::rethrow_exception(first);
  return of_others;
}

}  // namespace orient::patchdb
