#include "block/stages/harvest_stage.h"

#include <gdal.h>

#include <algorithm>
#include <filesystem>

#include "block/inputs/digest.h"
#include "block/inputs/harvest_sources.h"
#include "core/base/error.h"
#include "patchdb/harvest/patch_quality.h"

namespace orient::block {
namespace {

// Witnesses of one source that are kept open: those whose nadirs are the nearest.
constexpr std::size_t kMaxWitnesses = 16;
// GDAL would take a twentieth of the machine's memory.
constexpr GIntBig kBlockCacheBytes = 128LL << 20;

// One task a stage of the harvest.
class HarvestTasks {
 public:
  explicit HarvestTasks(ProgressListener* listener) : listener_(listener) {}

  patchdb::HarvestProgress For(const std::string& name) {
    task_.reset();
    stage_.clear();
    return [this, name](std::string_view stage, int done, int total) {
      if (stage != stage_) {
        task_.reset();
        task_.emplace(listener_, name + ", " + std::string(stage), total);
        stage_ = stage;
        shown_ = 0;
      }
      task_->Advance(done - shown_);
      shown_ = done;
    };
  }

 private:
  ProgressListener* listener_;
  std::optional<ProgressTask> task_;
  std::string stage_;
  int shown_ = 0;
};

HarvestedSource RowOf(const std::string& name, const patchdb::HarvestResult& harvest) {
  HarvestedSource row;
  row.name = name;
  row.gsd_m = harvest.gsd_m;
  row.patches = std::ssize(harvest.patches);
  for (const patchdb::Refusal refusal : patchdb::kAllRefusals)
    row.refused[static_cast<std::size_t>(refusal)] = harvest.Refused(refusal);
  for (const patchdb::Patch& patch : harvest.patches) {
    row.seen_twice += patch.views > 1 ? 1 : 0;
    row.good += patch.quality.value_or(0) >= patchdb::kGoodQuality ? 1 : 0;
  }
  return row;
}

Eigen::Vector2d Middle(const Bounds& bounds) {
  return {(bounds.min_x + bounds.max_x) / 2, (bounds.min_y + bounds.max_y) / 2};
}

class Harvester {
 public:
  Harvester(patchdb::PatchDatabase& database, const HarvestRun& run, const HarvestSources& kind,
            const std::vector<std::string>& paths, ProgressListener* listener)
      : database_(database), run_(run), kind_(kind), paths_(paths), tasks_(listener) {
    for (const std::string& path : paths)
      sources_.push_back(SourceOfFile(kind.Kind(), path, run.about));
  }

  std::vector<HarvestedSource> HarvestAll() {
    std::vector<HarvestedSource> harvested;
    LearnWhatIsTaken();
    for (std::size_t i = 0; i < paths_.size(); ++i) {
      if (database_.FindSource(sources_[i]).harvested)
        harvested.push_back({.name = sources_[i].name, .known = true});
      else
        harvested.push_back(RowOf(sources_[i].name, HarvestOne(i)));
    }
    return harvested;
  }

 private:
  // Places of patches that an interrupted run stored.
  void LearnWhatIsTaken() {
    if (run_.options.max_further_views == 0) return;
    std::vector<std::int64_t> ids;
    for (const patchdb::PatchSource& source : sources_)
      if (const patchdb::KnownSource known = database_.FindSource(source); known.harvested)
        ids.push_back(*known.id);
    if (ids.empty()) return;
    constexpr int kPage = 500;
    for (auto page = database_.ListPatches(0, kPage); !page.empty();
         page = database_.ListPatches(page.back().id, kPage))
      for (const patchdb::Patch& patch : page)
        if (std::find(ids.begin(), ids.end(), patch.source_id) != ids.end())
          taken_m_.emplace_back(patch.ground_m.head<2>());
  }

  // Sources that may show some of the same ground, the nearest first.
  std::vector<std::size_t> WitnessesOf(std::size_t source, const GroundSurface& surface) const {
    const double low = surface.MinHeight(), high = surface.MaxHeight();
    const Bounds own = kind_.Footprint(source, low, high);
    std::vector<std::pair<double, std::size_t>> near;
    for (std::size_t i = 0; i < paths_.size(); ++i) {
      if (i == source) continue;
      const Bounds other = kind_.Footprint(i, low, high);
      if (own.Overlaps(other)) near.emplace_back((Middle(own) - Middle(other)).norm(), i);
    }
    std::sort(near.begin(), near.end());
    std::vector<std::size_t> witnesses;
    for (const auto& [distance, i] : near)
      if (witnesses.size() < kMaxWitnesses) witnesses.push_back(i);
    return witnesses;
  }

  patchdb::HarvestResult HarvestOne(std::size_t source) {
    const Crs& crs = database_.GroundCrs();
    const Bounds footprint = kind_.Footprint(source, kLowestGround_m, kHighestGround_m);
    const GroundSurface surface = GroundSurface::FromFile(run_.dem, crs, footprint);
    std::optional<GroundSurface> dsm;
    if (!run_.dsm.empty()) dsm = GroundSurface::FromFile(run_.dsm, crs, footprint);
    const OpenSource itself = kind_.Open(source, surface, false);
    std::vector<OpenSource> witnesses;
    patchdb::HarvestContext context;
    context.number = static_cast<int>(source);
    context.dsm = dsm ? &*dsm : nullptr;
    const bool alone = run_.options.max_further_views == 0;
    if (!alone) context.taken_m = taken_m_;
    for (const std::size_t i : alone ? std::vector<std::size_t>{} : WitnessesOf(source, surface)) {
      witnesses.push_back(kind_.Open(i, surface, true));
      const OpenSource& open = witnesses.back();
      context.further.push_back(
          {open.raster.get(), open.view.get(), open.coverage.get(), static_cast<int>(i)});
    }
    patchdb::HarvestResult harvest = kind_.Harvest(source, *itself.raster, surface, run_.options,
                                                   tasks_.For(sources_[source].name), context);
    for (const patchdb::Patch& patch : harvest.patches)
      taken_m_.emplace_back(patch.ground_m.head<2>());
    Store(source, harvest);
    return harvest;
  }

  // Stores it in one transaction, also the evidence of sources that are not harvested yet: a run
  // that is killed loses nothing of it.
  void Store(std::size_t source, patchdb::HarvestResult& harvest) {
    patchdb::PatchSource stored = sources_[source];
    stored.gsd_m = harvest.gsd_m;
    database_.AddSource(stored, harvest.patches, sources_);
  }

  patchdb::PatchDatabase& database_;
  const HarvestRun& run_;
  const HarvestSources& kind_;
  const std::vector<std::string>& paths_;
  std::vector<Eigen::Vector2d> taken_m_;
  std::vector<patchdb::PatchSource> sources_;  // as they are distinguished in the database
  HarvestTasks tasks_;
};

// Restores GDAL's cache at the end.
class SmallBlockCache {
 public:
  SmallBlockCache() : before_(GDALGetCacheMax64()) {
    GDALSetCacheMax64(std::min(before_, kBlockCacheBytes));
  }
  ~SmallBlockCache() { GDALSetCacheMax64(before_); }
  SmallBlockCache(const SmallBlockCache&) = delete;
  SmallBlockCache& operator=(const SmallBlockCache&) = delete;

 private:
  GIntBig before_;
};

}  // namespace

patchdb::PatchSource SourceOfFile(patchdb::SourceKind kind, const std::string& path,
                                  const patchdb::PatchSource& about) {
  patchdb::PatchSource source = about;
  source.kind = kind;
  source.name = std::filesystem::path(path).filename().string();
  const std::string digest = DigestOfFile(path);
  if (!digest.empty()) source.digest = digest;
  return source;
}

std::vector<bool> AreHarvested(const patchdb::PatchDatabase& database, patchdb::SourceKind kind,
                               const std::vector<std::string>& paths,
                               const patchdb::PatchSource& about) {
  std::vector<bool> harvested;
  for (const std::string& path : paths)
    harvested.push_back(database.FindSource(SourceOfFile(kind, path, about)).harvested);
  return harvested;
}

std::vector<HarvestedSource> HarvestPhotos(patchdb::PatchDatabase& database, const HarvestRun& run,
                                           const PhotosToHarvest& photos,
                                           ProgressListener* listener) {
  const SmallBlockCache cache;
  const auto kind = PhotoSources(photos, run.options.orientation_sigma_px);
  return Harvester(database, run, *kind, photos.paths, listener).HarvestAll();
}

std::vector<HarvestedSource> HarvestOrthophotos(patchdb::PatchDatabase& database,
                                                const HarvestRun& run,
                                                const std::vector<std::string>& paths,
                                                ProgressListener* listener) {
  const SmallBlockCache cache;
  const auto kind =
      OrthophotoSources(paths, database.GroundCrs(), run.options.orientation_sigma_px);
  return Harvester(database, run, *kind, paths, listener).HarvestAll();
}

}  // namespace orient::block
