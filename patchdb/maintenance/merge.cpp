#include "patchdb/maintenance/merge.h"

#include <fmt/format.h>

#include <stdexcept>

#include "patchdb/maintenance/merge_rows.h"
#include "patchdb/maintenance/patch_transform.h"
#include "patchdb/maintenance/same_look.h"
#include "patchdb/store/connection.h"
#include "patchdb/store/learn.h"
#include "patchdb/store/patch_rows.h"

namespace orient::patchdb {
namespace {

constexpr double kSamePlace_px = 3;   // of the coarser chip: duplicates lie that near ...
constexpr double kSameLookNcc = 0.7;  // ... and correlate at least so well
// kReplace, kAdd: how near an older patch must lie, as a share of the coarser chip's half side.
constexpr double kSameAreaShare = 0.5;
constexpr int kLookSearch_px = 3;
constexpr double kCoarsest = 8;  // pixel and chip sizes at one place differ by less
constexpr double kSameView_px = 0.25;

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
    return result_;
  }

 private:
  // The target's patch that a patch of the other database is joined to.
  struct Twin {
    Patch patch;
    bool same_view = false;  // cut at the same place from the same source: both have one history
  };

  // Counts only what was committed. Successors are linked once both patches are in the target.
  void TakeSource(const PatchSource& source, const std::vector<std::int64_t>& ids) {
    MergeResult before = result_;
    try {
      target_.Write("merging a source", [&](Connection&) {
        for (const std::int64_t patch : ids) TakePatch(patch, source);
        rows_.LinkSuccessors();
        return 0;
      });
    } catch (...) {
      result_ = before;
      throw;
    }
  }

  void TakePatch(std::int64_t other_id, const PatchSource& source) {
    const auto original = other_.ReadPatch(other_id);
    if (!original) return;
    Require(*original);
    auto patch = transform_(*original);
    if (!patch) {
      ++result_.elsewhere;
      return;
    }
    std::vector<std::int64_t> older;
    const bool newer_only =
        options_.policy == MergePolicy::kReplace || options_.policy == MergePolicy::kAdd;
    if (newer_only) {
      const auto found = OlderNear(*patch, source);
      if (!found) ++result_.not_newer;
      if (!found || patch->life == PatchLife::kRetired) return;
      older = *found;
    }
    if (options_.policy == MergePolicy::kMerge || options_.policy == MergePolicy::kAdd)
      if (const auto twin = FindTwin(*patch, source)) return Join(*patch, *twin, source);
    const std::int64_t id = Add(*patch, source);
    if (options_.policy == MergePolicy::kReplace)
      for (const std::int64_t old : older) result_.superseded += rows_.Supersede(old, id);
  }

  // A patch that this program would not store is not taken over either.
  void Require(const Patch& patch) const {
    try {
      CheckPatch(patch);
    } catch (const std::invalid_argument& error) {
      throw InputError(
          fmt::format("{}: patch {} is damaged: {}", other_.Path(), patch.id, error.what()));
    }
  }

  std::int64_t SourceHere(const PatchSource& source) {
    const auto [id, is_new] = rows_.SourceFor(source);
    result_.sources += is_new ? 1 : 0;
    return id;
  }

  // Maps evidence to the target's sources, made only now: a patch left out leaves no trace.
  void TranslateEvidence(Patch& patch) {
    for (PatchEvidence& evidence : patch.evidence)
      evidence.source_id = rows_.SourceIdFor(evidence.source_id);
  }

  std::int64_t Add(Patch& patch, const PatchSource& source) {
    const std::int64_t source_id = SourceHere(source);
    TranslateEvidence(patch);
    const std::int64_t id = rows_.AddPatch(patch, source_id);
    ++result_.added;
    result_.attempts += rows_.TakeAttempts(patch.id, id, 0);
    return id;
  }

  // The target's patch that shows the same thing at the same place. Active and retired ones are not
  // joined, so that no place loses its active patch, unless the target's is known to show this
  // source's view: then it was retired there, and does not come again.
  std::optional<Twin> FindTwin(const Patch& patch, const PatchSource& source) const {
    const auto source_id = target_.FindSource(source).id;
    std::optional<Twin> twin;
    double best = kSameLookNcc;
    for (const NearPatch& near :
         rows_.PatchesNear(patch.ground_m, kCoarsest * kSamePlace_px * patch.gsd_m)) {
      if (near.distance_m > kSamePlace_px * std::max(near.gsd_m, patch.gsd_m)) continue;
      auto candidate = target_.ReadPatch(near.id);
      if (!candidate) continue;
      if (candidate->source_id == source_id && near.distance_m < kSameView_px * patch.gsd_m)
        return Twin{*std::move(candidate), true};
      const bool joinable = candidate->life == patch.life ||
                            (patch.life == PatchLife::kActive && Shows(*candidate, source_id));
      const double correlation = joinable ? BestCorrelation(*candidate, patch, kLookSearch_px) : 0;
      if (!joinable || correlation < best) continue;
      best = correlation;
      twin = Twin{*std::move(candidate), false};
    }
    return twin;
  }

  static bool Shows(const Patch& patch, const std::optional<std::int64_t>& source_id) {
    return source_id &&
           (patch.source_id == *source_id ||
            std::any_of(patch.evidence.begin(), patch.evidence.end(),
                        [&](const PatchEvidence& e) { return e.source_id == *source_id; }));
  }

  // Which of two states of one history is later: a restore begins an epoch, a retirement ends it.
  static bool IsLater(const Patch& patch, const Patch& than) {
    if (patch.epoch != than.epoch) return patch.epoch > than.epoch;
    return patch.life == PatchLife::kRetired && than.life == PatchLife::kActive;
  }

  // Joins the two into one patch with the better view and both histories.
  void Join(Patch& patch, const Twin& twin, const PatchSource& source) {
    ++result_.duplicates;
    const std::int64_t id = twin.patch.id, source_id = SourceHere(source);
    TranslateEvidence(patch);
    const bool later = twin.same_view && IsLater(patch, twin.patch);
    if (later) rows_.SetLife(patch, id);
    const PatchLife life = later ? patch.life : twin.patch.life;
    const bool better = life == PatchLife::kActive && patch.life == PatchLife::kActive &&
                        patch.quality.value_or(0) > twin.patch.quality.value_or(0);
    if (better) {
      rows_.ChangePatch(patch, id, source_id);
      rows_.ForgetResiduals(id);
      ++result_.improved;
    }
    JoinEvidence(patch, twin, source_id, better);
    // Epochs of one history are the same; in two histories they are counted from the present one.
    const std::int64_t epochs =
        twin.same_view ? 0 : std::int64_t{twin.patch.epoch} - std::int64_t{patch.epoch};
    result_.attempts += rows_.TakeAttempts(patch.id, id, epochs);
    if (later) LearnAnew(target_.Sql(), id, false);
    rows_.Remember(patch, id);
  }

  void JoinEvidence(const Patch& patch, const Twin& twin, std::int64_t source_id, bool better) {
    const std::int64_t id = twin.patch.id;
    const std::int64_t own = better ? source_id : twin.patch.source_id;
    std::vector<PatchEvidence> all = patch.evidence;
    all.push_back({better ? twin.patch.source_id : source_id, {}, {}});
    for (PatchEvidence& evidence : all) {
      if (evidence.source_id == own) continue;
      if (!better && !twin.same_view) evidence.residual_px.reset();  // for another ground point
      rows_.AddEvidence(id, evidence, better && evidence.pixel);
    }
    rows_.CountViews(id);
  }

  // The target's patches that this one is newer than; empty if one at its place is as new, or if a
  // date is unknown.
  std::optional<std::vector<std::int64_t>> OlderNear(const Patch& patch,
                                                     const PatchSource& source) const {
    const double share = 0.5 * kSameAreaShare, side_m = patch.chip.width * patch.gsd_m;
    std::vector<std::int64_t> older;
    for (const NearPatch& near : rows_.PatchesNear(patch.ground_m, kCoarsest * share * side_m)) {
      if (near.distance_m > share * std::max(side_m, near.chip_px * near.gsd_m)) continue;
      if (!near.source_date || !source.date || !IsBefore(*near.source_date, *source.date))
        return std::nullopt;
      if (near.is_active) older.push_back(near.id);
    }
    return older;
  }

  // ISO 8601 dates; 2020 is not before 2020-05-01.
  static bool IsBefore(const std::string& a, const std::string& b) {
    const std::size_t common = std::min(a.size(), b.size());
    return a.compare(0, common, b, 0, common) < 0;
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

}  // namespace orient::patchdb
