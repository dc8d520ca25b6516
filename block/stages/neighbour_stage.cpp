#include "block/stages/neighbour_stage.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <list>
#include <map>
#include <mutex>

#include "block/inputs/approximations.h"
#include "block/inputs/digest.h"
#include "block/stages/exterior_inputs.h"
#include "block/stages/keypoint_stage.h"
#include "core/base/chi_square.h"
#include "core/base/error.h"
#include "core/base/progress.h"
#include "core/files/orientation_table.h"
#include "core/geometry/rotation.h"
#include "patchdb/harvest/harvest.h"

namespace orient::block {
namespace {
namespace fs = std::filesystem;

// In addition to the number of photos.
constexpr int kFurtherRounds = 20;
constexpr int kPatchesOfAPhoto = 500;
// Lenders whose patches are kept in memory: a photo's weigh some 10 MB.
constexpr std::size_t kLendersInMemory = 24;
// Neighbours' patches have numbers below zero, which no database gives.
constexpr std::int64_t kNumbersOfAPhoto = 100000;

// Patches of the photos that have a pose, cut from a photo on request; the most recently requested
// ones are kept.
class NeighbourPatches {
 public:
  NeighbourPatches(const NeighbourStage& stage, const std::vector<BlockPhotoFile>& photos)
      : stage_(stage), photos_(photos) {}

  std::vector<patchdb::Patch> In(const Bounds& area) {
    const std::lock_guard<std::mutex> lock(mutex_);
    std::vector<patchdb::Patch> patches;
    for (std::size_t i = 0; i < photos_.size(); ++i) {
      if (!photos_[i].HasPose() || !photos_[i].footprint.Overlaps(area)) continue;
      for (const patchdb::Patch& patch : Of(i))
        if (area.Contains(patch.ground_m.x(), patch.ground_m.y())) patches.push_back(patch);
    }
    return patches;
  }

 private:
  const std::vector<patchdb::Patch>& Of(std::size_t i) {
    const auto known = std::find_if(kept_.begin(), kept_.end(),
                                    [i](const auto& lender) { return lender.first == i; });
    if (known != kept_.end()) {
      kept_.splice(kept_.begin(), kept_, known);
      return known->second;
    }
    std::vector<patchdb::Patch> patches;
    try {
      const Raster raster = Raster::OpenScan(photos_[i].path);
      patchdb::HarvestOptions options;
      options.max_count = kPatchesOfAPhoto;
      patches = patchdb::HarvestPhoto(raster, photos_[i].View(stage_.camera.camera),
                                      photos_[i].exterior.covariance, stage_.surface, options)
                    .patches;
    } catch (const InputError&) {  // a photo that cannot be read lends nothing
    }
    for (std::size_t k = 0; k < patches.size(); ++k) {
      patches[k].id =
          -(static_cast<std::int64_t>(i + 1) * kNumbersOfAPhoto + static_cast<std::int64_t>(k));
      if (photos_[i].negative)
        for (float& value : patches[k].chip.values) value = -value;
    }
    kept_.emplace_front(i, std::move(patches));
    if (kept_.size() > kLendersInMemory) kept_.pop_back();
    return kept_.front().second;
  }

  const NeighbourStage& stage_;
  const std::vector<BlockPhotoFile>& photos_;
  std::mutex mutex_;
  std::list<std::pair<std::size_t, std::vector<patchdb::Patch>>>
      kept_;  // by photo, the last asked first
};

// The inputs are all lenders of a round: coarse, but rounds and failed photos are few.
Inputs InputsOfRound(const NeighbourStage& stage, const std::vector<BlockPhotoFile>& photos,
                     const Inputs& located) {
  Inputs lenders;
  for (const BlockPhotoFile& photo : photos) lenders[photo.name] = DigestOfPhoto(photo);
  Inputs inputs = stage.exterior.inputs;
  inputs["method"] = "neighbours 2";
  inputs["lenders"] = DigestOf(lenders);
  if (!located.empty()) inputs["keypoints"] = DigestOf(located);
  return inputs;
}

// Whether the photo could be oriented given an approximation: it has a scan and a film transform,
// and no person has rejected it.
bool MayBeTried(const BlockPhotoFile& photo, const NeighbourStage& stage) {
  if (photo.HasPose() || Has(photo.exterior.findings, Reason::kRejectedByPerson)) return false;
  std::error_code ignored;
  if (!fs::exists(photo.path, ignored)) return false;
  if (stage.camera.camera.kind == CameraKind::kDigital) return true;
  try {
    return ReadInteriorResult(InteriorResultPath(stage.interior_directory, photo.name))
        .photo_from_pixel.has_value();
  } catch (const InputError&) {
    return false;
  }
}

// The rounds so far: the photos oriented in the last one, and where each failed photo looked for
// patches. It is tried again only if a newly oriented photo lends some there.
struct RoundsSoFar {
  int count = 0;
  std::vector<std::size_t> fresh;
  std::map<std::string, Bounds> sought;
};

bool AnythingNew(const RoundsSoFar& rounds, const std::vector<BlockPhotoFile>& photos,
                 const std::string& name) {
  const auto area = rounds.sought.find(name);
  if (area == rounds.sought.end()) return true;
  return std::any_of(rounds.fresh.begin(), rounds.fresh.end(),
                     [&](std::size_t i) { return photos[i].footprint.Overlaps(area->second); });
}

std::vector<std::size_t> ToBeTried(const NeighbourStage& stage, const RoundsSoFar& rounds,
                                   const std::vector<BlockPhotoFile>& photos) {
  std::vector<std::size_t> open, tried;
  std::vector<std::string> names;
  for (std::size_t i = 0; i < photos.size(); ++i) {
    if (!AnythingNew(rounds, photos, photos[i].name) || !MayBeTried(photos[i], stage) ||
        stage.approximations.Table().Find(photos[i].name) == nullptr)
      continue;
    open.push_back(i);
    names.push_back(photos[i].name);
  }
  for (const std::size_t i : stage.approximations.Next(names)) tried.push_back(open[i]);
  return tried;
}

void LearnFrom(const std::vector<BlockPhotoFile>& photos, BlockApproximations* approximations) {
  std::vector<ExteriorResult> results;
  for (const BlockPhotoFile& photo : photos)
    if (photo.HasPose()) results.push_back(photo.exterior);
  approximations->Learn(results);
}

// The photos that a round tries, and their approximations. `located`: photos with approximations
// from keypoints, whose accuracy is not a stated one.
struct Round {
  std::vector<std::size_t> tried;
  OrientationTable table;
  Inputs located;
};

ExteriorRunOptions OptionsOf(const NeighbourStage& stage, const Round& what,
                             const std::vector<BlockPhotoFile>& photos) {
  ExteriorRunOptions options = stage.exterior;
  options.photos.clear();
  for (const std::size_t i : what.tried) options.photos.push_back(photos[i].path);
  options.pictures.reset();  // beside the round's results: they show no control patches
  options.resume = true;
  options.learn = false;  // these patches are not from the database
  options.table = what.table;
  if (!what.located.empty()) options.accuracy_is_stated = false;
  options.inputs = InputsOfRound(stage, photos, what.located);
  return options;
}

// A photo that did not get as far as looking for patches is not tried again.
void NoteSought(const ExteriorResult& result, RoundsSoFar* rounds) {
  Bounds& sought = rounds->sought.try_emplace(result.photo, Bounds::OfNothing()).first->second;
  if (const auto& area = result.asked_of_neighbours) {
    sought.Include(area->min_x, area->min_y);
    sought.Include(area->max_x, area->max_y);
  }
}

// Photos that the round oriented take over their poses.
void RunRound(const NeighbourStage& stage, const Round& what, RoundsSoFar* rounds,
              std::vector<BlockPhotoFile>* photos) {
  const std::string round = std::to_string(++rounds->count);
  const ResultStore store =
      ExteriorStore((fs::path(stage.directory) / ("round-" + round)).string());
  NeighbourPatches lent(stage, *photos);
  ExteriorRunOptions options = OptionsOf(stage, what, *photos);
  options.out = store.Folder();
  options.further_patches = [&](const std::string&, const Bounds& area) { return lent.In(area); };
  ProgressTask progress(stage.listener, "orientation by neighbours, round " + round,
                        static_cast<int>(what.tried.size()));
  for (const ExteriorResult& result : RunExterior(options, [&] { progress.Advance(); }))
    NoteSought(result, rounds);
  rounds->fresh.clear();
  for (const std::size_t i : what.tried) {
    BlockPhotoFile now = ReadBlockPhoto((*photos)[i].path, store.PathOf((*photos)[i].name),
                                        stage.camera, stage.marks, stage.interior_directory);
    if (!now.HasPose()) continue;
    now.by_neighbours = true;
    now.alone = (*photos)[i].exterior;
    (*photos)[i] = std::move(now);
    rounds->fresh.push_back(i);
  }
}

const double kMaxChi2 = ChiSquareLimit(6, 1e-4);

// A photo that keypoints located far from its approximation is weak: they may be right, or the
// neighbours wrong.
void CompareWithStated(const NeighbourStage& stage, BlockPhotoFile* photo) {
  const OrientationRow* stated = stage.approximations.Table().Find(photo->name);
  if (stated == nullptr) return;
  const Vector6d variance =
      SigmaOfApproximation(*stated, stage.exterior.position_sigma_m,
                           stage.exterior.attitude_sigma_rad, stage.exterior.kappa_sigma_rad)
          .cwiseAbs2() +
      photo->exterior.covariance->diagonal();
  const Vector6d off = PoseDifference(*photo->exterior.pose, stated->pose);
  const double chi2 = off.cwiseAbs2().cwiseQuotient(variance).sum();
  if (chi2 <= kMaxChi2) return;
  photo->exterior.status = Status::kWeak;
  photo->exterior.findings.push_back({.reason = Reason::kContradictsApproximation,
                                      .at_best = Status::kWeak,
                                      .value = std::sqrt(chi2),
                                      .where = "its neighbours are"});
}

// Photos still without a pose, located by keypoints that they share with oriented photos; the
// patches decide. `tried` is empty if there are none.
Round LocatedByKeypoints(const NeighbourStage& stage, const std::vector<BlockPhotoFile>& photos,
                         KeypointStage* keypoints, std::map<std::size_t, int>* agreeing) {
  Round round;
  round.table = stage.approximations.Table();
  std::vector<std::size_t> open;
  for (std::size_t i = 0; i < photos.size(); ++i)
    if (MayBeTried(photos[i], stage)) open.push_back(i);
  ProgressTask progress(stage.listener, "keypoints of photos not found yet",
                        static_cast<int>(open.size()));
  for (const std::size_t i : open) {
    progress.Advance();
    const auto found =
        keypoints->Locate(i, photos, stage.approximations.Table().Find(photos[i].name));
    if (!found) continue;
    round.tried.push_back(i);
    (*agreeing)[i] = found->keypoints;
    std::erase_if(round.table.rows,
                  [&](const OrientationRow& row) { return row.photo == photos[i].name; });
    round.table.rows.push_back(found->row);
    round.located[photos[i].name] = Digest(TextOf(&found->row));
  }
  return round;
}

// Records photos located by keypoints and confirmed by patches; `refused`: those not confirmed.
void TellOfKeypoints(const NeighbourStage& stage, const std::map<std::size_t, int>& agreeing,
                     std::vector<BlockPhotoFile>* photos, std::map<std::size_t, int>* refused) {
  for (const auto& [i, count] : agreeing) {
    BlockPhotoFile& photo = (*photos)[i];
    if (!photo.HasPose()) {
      (*refused)[i] = count;
      continue;
    }
    photo.located_by = "located by " + std::to_string(count) +
                       " keypoints (SIFT) that it shares with oriented photos";
    CompareWithStated(stage, &photo);
  }
}

// Adds findings to photos that keypoints did not help, once the rounds are over.
void TellOfThoseInVain(const std::set<std::size_t>& in_vain,
                       const std::map<std::size_t, int>& refused,
                       std::vector<BlockPhotoFile>* photos) {
  for (std::size_t i = 0; i < photos->size(); ++i) {
    BlockPhotoFile& photo = (*photos)[i];
    if (photo.HasPose()) continue;
    const auto add = [&](std::optional<double> agreeing, std::string where) {
      photo.exterior.findings.push_back({.reason = Reason::kKeypointsUnconfirmed,
                                         .at_best = Status::kFailed,
                                         .value = agreeing,
                                         .where = std::move(where)});
    };
    if (const auto located = refused.find(i); located != refused.end())
      add(located->second,
          fmt::format("{} keypoints (SIFT) that it shares with oriented photos agree on where it "
                      "is, but patches do not confirm it",
                      located->second));
    else if (in_vain.contains(i))
      add({}, "keypoints (SIFT) that it shares with oriented photos do not agree on where it is");
  }
}

// Runs rounds until no photo is left to try: first from the known approximations and, if these do
// not suffice, from keypoints. Returns nothing, or what stopped a round if photos that it tried
// have no pose (e.g. because none of them lies on the DEM); the other photos are unaffected.
// `refused`: photos that keypoints located and patches did not confirm there.
std::optional<Finding> RunRounds(const NeighbourStage& stage, KeypointStage* keypoints,
                                 std::vector<BlockPhotoFile>* photos,
                                 std::map<std::size_t, int>* refused) {
  RoundsSoFar rounds;
  std::optional<Finding> stopped;
  std::vector<std::size_t> not_tried;
  while (rounds.count < kFurtherRounds + std::ssize(*photos)) {
    LearnFrom(*photos, &stage.approximations);
    Round round;
    if (!stopped) round = {ToBeTried(stage, rounds, *photos), stage.approximations.Table(), {}};
    std::map<std::size_t, int> agreeing;
    if (round.tried.empty()) round = LocatedByKeypoints(stage, *photos, keypoints, &agreeing);
    if (round.tried.empty()) break;
    try {
      RunRound(stage, round, &rounds, photos);
      TellOfKeypoints(stage, agreeing, photos, refused);
    } catch (const InputError& error) {
      const bool again = stopped || !agreeing.empty();
      stopped = Finding{.reason = Reason::kNeighboursNotTried, .where = error.what()};
      not_tried = round.tried;
      if (again) break;
    }
  }
  const bool all_found = std::all_of(not_tried.begin(), not_tried.end(),
                                     [&](std::size_t i) { return (*photos)[i].HasPose(); });
  return all_found ? std::nullopt : stopped;
}

}  // namespace

void RunNeighbourStage(const NeighbourStage& stage, std::vector<BlockPhotoFile>* photos,
                       Findings* findings) {
  if (std::none_of(photos->begin(), photos->end(),
                   [](const BlockPhotoFile& photo) { return photo.HasPose(); }))
    return;
  KeypointStage keypoints({stage.camera, stage.marks, stage.surface, stage.interior_directory,
                           (fs::path(stage.directory) / "keypoints").string(),
                           stage.exterior.inputs, stage.exterior.jobs});
  std::map<std::size_t, int> refused;
  const auto stopped = RunRounds(stage, &keypoints, photos, &refused);
  keypoints.RemoveUnused();
  if (stopped) findings->push_back(*stopped);
  TellOfThoseInVain(keypoints.InVain(), refused, photos);
}

}  // namespace orient::block
