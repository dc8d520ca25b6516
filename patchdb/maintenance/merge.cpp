#include "patchdb/maintenance/merge.h"

#include "patchdb/connection.h"
#include "patchdb/maintenance/merge_rows.h"
#include "patchdb/maintenance/patch_transform.h"
#include "patchdb/maintenance/same_look.h"

namespace orient {
namespace {

constexpr int kLookSearch_px = 3;

class Merge {
 public:
  Merge(PatchDatabase& target, const PatchDatabase& other, const MergeOptions& options)
      : target_(target),
        other_(other),
        options_(options),
        transform_(target.GroundCrs(), other.GroundCrs()),
        rows_(target, other) {}

  MergeResult Run(const MergeProgress& progress) {
    std::map<std::int64_t, std::vector<std::int64_t>> ids;
    VisitPatches(other_, options_.filter,
                 [&](const PatchSummary& patch) { ids[patch.source_id].push_back(patch.id); });
    const std::vector<PatchSource> sources = other_.Sources();
    for (std::size_t i = 0; i < sources.size(); ++i) {
      const auto patches = ids.find(sources[i].id);
      if (patches != ids.end()) TakeSource(sources[i], patches->second);
      if (progress) progress(static_cast<int>(i) + 1, static_cast<int>(sources.size()));
    }
    target_.Write("linking successors", [&](Connection&) { return rows_.LinkSuccessors(); });
    return result_;
  }

 private:
  // Counts only what was committed.
  void TakeSource(const PatchSource& source, const std::vector<std::int64_t>& ids) {
    MergeResult before = result_;
    try {
      target_.Write("merging a source", [&](Connection&) {
        const auto [id, is_new] = rows_.SourceFor(source);
        result_.sources += is_new ? 1 : 0;
        for (const std::int64_t patch : ids) TakePatch(patch, source, id);
        return 0;
      });
    } catch (...) {
      result_ = before;
      throw;
    }
  }

  void TakePatch(std::int64_t other_id, const PatchSource& source, std::int64_t source_id) {
    const auto original = other_.ReadPatch(other_id);
    if (!original) return;
    auto patch = transform_(*original);
    if (!patch) {
      ++result_.elsewhere;
      return;
    }
    for (PatchEvidence& evidence : patch->evidence)
      evidence.source_id = rows_.SourceIdFor(evidence.source_id);
    if (options_.policy == MergePolicy::kReplace) return Replace(*patch, source, source_id);
    if (options_.policy == MergePolicy::kCopy) {
      Add(*patch, source_id);
      return;
    }
    if (const auto twin = Twin(*patch)) return Join(*patch, *twin, source_id);
    Add(*patch, source_id);
  }

  std::int64_t Add(const Patch& patch, std::int64_t source_id) {
    const std::int64_t id = rows_.AddPatch(patch, source_id);
    ++result_.added;
    result_.attempts += rows_.TakeAttempts(patch.id, id);
    return id;
  }

  // The patch here that shows the same thing at the same place.
  std::optional<Patch> Twin(const Patch& patch) const {
    std::optional<Patch> twin;
    double best = options_.same_look_ncc;
    for (const std::int64_t id :
         rows_.PatchesNear(patch.ground_m, options_.same_place_px * patch.gsd_m)) {
      auto candidate = target_.ReadPatch(id);
      if (!candidate) continue;
      const double correlation = BestCorrelation(*candidate, patch, kLookSearch_px);
      if (correlation < best) continue;
      best = correlation;
      twin = std::move(candidate);
    }
    return twin;
  }

  // One patch, its better view, both histories.
  void Join(const Patch& patch, const Patch& twin, std::int64_t source_id) {
    ++result_.duplicates;
    const bool better =
        patch.life == PatchLife::kActive && patch.quality.value_or(0) > twin.quality.value_or(0);
    if (better) {
      rows_.ChangePatch(patch, twin.id, source_id);
      ++result_.improved;
    }
    rows_.AddEvidence(twin.id, {better ? twin.source_id : source_id, {}, {}});
    for (const PatchEvidence& evidence : patch.evidence) rows_.AddEvidence(twin.id, evidence);
    rows_.CountViews(twin.id);
    result_.attempts += rows_.TakeAttempts(patch.id, twin.id);
    rows_.Remember(patch.id, twin.id);
  }

  // Newer than every patch of its place: it takes their place.
  void Replace(const Patch& patch, const PatchSource& source, std::int64_t source_id) {
    const double radius_m = options_.same_area_share * 0.5 * patch.chip.width * patch.gsd_m;
    std::vector<std::int64_t> older;
    for (const NearPatch& near : rows_.DatedPatchesNear(patch.ground_m, radius_m)) {
      if (near.source_date && source.date && *near.source_date < *source.date) {
        if (near.is_active) older.push_back(near.id);
      } else {
        ++result_.not_newer;
        return;
      }
    }
    if (patch.life == PatchLife::kRetired) return;
    const std::int64_t id = Add(patch, source_id);
    for (const std::int64_t old : older) result_.superseded += rows_.Supersede(old, id);
  }

  PatchDatabase& target_;
  const PatchDatabase& other_;
  const MergeOptions& options_;
  PatchTransform transform_;
  MergeRows rows_;
  MergeResult result_;
};

}  // namespace

MergeResult MergeDatabase(PatchDatabase& target, const PatchDatabase& other,
                          const MergeOptions& options, const MergeProgress& progress) {
  return Merge(target, other, options).Run(progress);
}

}  // namespace orient
