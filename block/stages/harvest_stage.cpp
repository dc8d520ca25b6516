#include "tools/harvest_run.h"

#include <gdal.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <ostream>

#include "core/error.h"
#include "patchdb/patch_quality.h"
#include "tools/harvest_sources.h"
#include "tools/made_from.h"
#include "tools/progress.h"
#include "tools/summary_table.h"

namespace orient {
namespace {

// Witnesses of one source that are kept open: those whose nadirs are the nearest.
constexpr std::size_t kMaxWitnesses = 16;
// GDAL would take a twentieth of the machine's memory.
constexpr GIntBig kBlockCacheBytes = 128LL << 20;

// What a harvest prints: a row a source, and how many candidates were refused for which reason.
class HarvestTable {
 public:
  void Add(const std::string& name, const HarvestResult& harvest) {
    int refused = 0, confirmed = 0, good = 0;
    for (const Refusal refusal : kAllRefusals) {
      refused += harvest.Refused(refusal);
      refused_[static_cast<std::size_t>(refusal)] += harvest.Refused(refusal);
    }
    for (const Patch& patch : harvest.patches) {
      confirmed += patch.views > 1 ? 1 : 0;
      good += patch.quality.value_or(0) >= kGoodQuality ? 1 : 0;
    }
    table_.AddRow({name, std::to_string(harvest.patches.size()), std::to_string(good),
                   std::to_string(confirmed), std::to_string(refused), Fixed(harvest.gsd_m, 3)});
    patches_ += harvest.patches.size();
    confirmed_ += static_cast<std::size_t>(confirmed);
  }
  void AddKnown(const std::string& name) {
    table_.AddRow({name + " (in the database already)", "-", "-", "-", "-", "-"});
  }
  void Print(bool has_surface_model, std::ostream& out) const {
    table_.Print(out);
    SummaryTable reasons({"refused because", "candidates"});
    bool any = false;
    for (const Refusal refusal : kAllRefusals) {
      const int count = refused_[static_cast<std::size_t>(refusal)];
      if (count > 0) reasons.AddRow({std::string(Name(refusal)), std::to_string(count)});
      any = any || count > 0;
    }
    if (any) {
      out << "\n";
      reasons.Print(out);
      out << "\n";
    }
    out << patches_ << " patches added\n";
    const std::size_t seen_once = patches_ - confirmed_;
    if (!has_surface_model && seen_once > 0)
      out << "note    without --dsm nothing tells roofs and trees from the ground in the "
          << seen_once << " of them that one source shows\n";
  }

 private:
  SummaryTable table_{{"source", "patches", "good", "seen twice", "refused", "gsd [m]"}};
  std::array<int, kAllRefusals.size()> refused_ = {};
  std::size_t patches_ = 0, confirmed_ = 0;
};

class ShownProgress {
 public:
  HarvestProgress For(const std::string& name) {
    return [this, name](std::string_view stage, int done, int total) {
      if (stage != stage_) {
        progress_ = std::make_unique<Progress>(name + ", " + std::string(stage), total);
        stage_ = stage;
        shown_ = 0;
      }
      progress_->Advance(done - shown_);
      shown_ = done;
    };
  }

 private:
  std::unique_ptr<Progress> progress_;
  std::string stage_;
  int shown_ = 0;
};

Eigen::Vector2d Middle(const Bounds& bounds) {
  return {(bounds.min_x + bounds.max_x) / 2, (bounds.min_y + bounds.max_y) / 2};
}

class Harvester {
 public:
  Harvester(PatchDatabase& database, const HarvestRun& run, const HarvestSources& kind,
            const std::vector<std::string>& paths)
      : database_(database), run_(run), kind_(kind), paths_(paths) {
    for (const std::string& path : paths)
      sources_.push_back(SourceOfFile(kind.Kind(), path, run.about));
  }

  void HarvestAll(std::ostream& out) {
    HarvestTable table;
    LearnWhatIsTaken();
    for (std::size_t i = 0; i < paths_.size(); ++i) {
      if (database_.FindSource(sources_[i]).harvested)
        table.AddKnown(sources_[i].name);
      else
        table.Add(sources_[i].name, HarvestOne(i));
    }
    table.Print(!run_.dsm.empty(), out);
  }

 private:
  // Places of patches that an interrupted run stored.
  void LearnWhatIsTaken() {
    std::vector<std::int64_t> ids;
    for (const PatchSource& source : sources_)
      if (const KnownSource known = database_.FindSource(source); known.harvested)
        ids.push_back(*known.id);
    if (ids.empty()) return;
    constexpr int kPage = 500;
    for (auto page = database_.ListPatches(0, kPage); !page.empty();
         page = database_.ListPatches(page.back().id, kPage))
      for (const Patch& patch : page)
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

  HarvestResult HarvestOne(std::size_t source) {
    const Crs& crs = database_.GroundCrs();
    const Bounds footprint = kind_.Footprint(source, kLowestGround_m, kHighestGround_m);
    const GroundSurface surface = GroundSurface::FromFile(run_.dem, crs, footprint);
    std::optional<GroundSurface> dsm;
    if (!run_.dsm.empty()) dsm = GroundSurface::FromFile(run_.dsm, crs, footprint);
    const OpenSource itself = kind_.Open(source, surface, false);
    std::vector<OpenSource> witnesses;
    HarvestContext context;
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
    ShownProgress progress;
    HarvestResult harvest = kind_.Harvest(source, *itself.raster, surface, run_.options,
                                          progress.For(sources_[source].name), context);
    for (const Patch& patch : harvest.patches) taken_m_.emplace_back(patch.ground_m.head<2>());
    Store(source, harvest);
    return harvest;
  }

  // One transaction, with the evidence of sources that are not harvested yet, too: a run that is
  // killed has lost nothing of it.
  void Store(std::size_t source, HarvestResult& harvest) {
    PatchSource stored = sources_[source];
    stored.gsd_m = harvest.gsd_m;
    database_.AddSource(stored, harvest.patches, sources_);
  }

  PatchDatabase& database_;
  const HarvestRun& run_;
  const HarvestSources& kind_;
  const std::vector<std::string>& paths_;
  std::vector<Eigen::Vector2d> taken_m_;
  std::vector<PatchSource> sources_;  // as they are told apart in the database
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

PatchSource SourceOfFile(SourceKind kind, const std::string& path, const PatchSource& about) {
  PatchSource source = about;
  source.kind = kind;
  source.name = std::filesystem::path(path).filename().string();
  const std::string digest = DigestOfFile(path);
  if (!digest.empty()) source.digest = digest;
  return source;
}

void HarvestPhotos(PatchDatabase& database, const HarvestRun& run, const PhotosToHarvest& photos,
                   std::ostream& out) {
  const SmallBlockCache cache;
  const auto kind = PhotoSources(photos, run.options.orientation_sigma_px);
  Harvester(database, run, *kind, photos.paths).HarvestAll(out);
}

void HarvestOrthophotos(PatchDatabase& database, const HarvestRun& run,
                        const std::vector<std::string>& paths, std::ostream& out) {
  const SmallBlockCache cache;
  const auto kind =
      OrthophotoSources(paths, database.GroundCrs(), run.options.orientation_sigma_px);
  Harvester(database, run, *kind, paths).HarvestAll(out);
}

}  // namespace orient
