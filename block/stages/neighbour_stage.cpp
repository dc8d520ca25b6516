#include "tools/block/neighbour_stage.h"

#include <algorithm>
#include <filesystem>
#include <list>
#include <map>
#include <mutex>
#include <sstream>

#include "core/error.h"
#include "core/files/atomic_write.h"
#include "core/files/orientation_table.h"
#include "core/format_text.h"
#include "core/geometry/rotation.h"
#include "patchdb/harvest.h"
#include "tools/approximations.h"
#include "tools/block/keypoint_stage.h"
#include "tools/block/stage_folder.h"
#include "tools/made_from.h"
#include "tools/progress.h"
#include "tools/shared_options.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

// Beyond as many as there are photos.
constexpr int kFurtherRounds = 20;
constexpr int kPatchesOfAPhoto = 500;
// Lenders whose patches are kept in memory: a photo's weigh some 10 MB.
constexpr std::size_t kLendersInMemory = 24;
// Neighbours' patches have numbers below zero, which no database gives.
constexpr std::int64_t kNumbersOfAPhoto = 100000;

// Patches of the photos that have a pose, each photo's cut when somebody asks; those that were
// asked for last are kept.
class NeighbourPatches {
 public:
  NeighbourPatches(const NeighbourStage& stage, const std::vector<BlockPhotoFile>& photos)
      : stage_(stage), photos_(photos) {}

  std::vector<Patch> In(const Bounds& area) {
    const std::lock_guard<std::mutex> lock(mutex_);
    std::vector<Patch> patches;
    for (std::size_t i = 0; i < photos_.size(); ++i) {
      if (!photos_[i].HasPose() || !photos_[i].footprint.Overlaps(area)) continue;
      for (const Patch& patch : Of(i))
        if (area.Contains(patch.ground_m.x(), patch.ground_m.y())) patches.push_back(patch);
    }
    return patches;
  }

 private:
  const std::vector<Patch>& Of(std::size_t i) {
    const auto known = std::find_if(kept_.begin(), kept_.end(),
                                    [i](const auto& lender) { return lender.first == i; });
    if (known != kept_.end()) {
      kept_.splice(kept_.begin(), kept_, known);
      return known->second;
    }
    std::vector<Patch> patches;
    try {
      const Raster raster = Raster::Open(photos_[i].path);
      HarvestOptions options;
      options.max_count = kPatchesOfAPhoto;
      patches = HarvestPhoto(raster, photos_[i].View(stage_.camera.camera),
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
  std::list<std::pair<std::size_t, std::vector<Patch>>> kept_;  // by photo, the last asked first
};

// Of all that lend patches in a round: coarse, but rounds are few and failed photos, too.
std::string DigestOfRound(const NeighbourStage& stage, const std::vector<BlockPhotoFile>& photos,
                          const std::string& more) {
  std::string text = "neighbours 2" + stage.inputs + more;
  for (const BlockPhotoFile& photo : photos)
    text += photo.name + DigestOfFile(photo.path) + photo.made_from +
            Digest(ReadFile(photo.result_path)) + (photo.HasPose() ? "+" : "-");
  return Digest(text);
}

// Whether the photo could be tried if anything were known of it: a scan, a film transform.
bool MayBeTried(const BlockPhotoFile& photo, const NeighbourStage& stage) {
  if (photo.HasPose()) return false;
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

// The rounds so far: who was oriented in the last one, and where each photo that failed looked for
// patches. It is tried again only where somebody new lends some there.
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

// Where a photo of a round looked for patches, beside its result: an interrupted run goes on with
// the same photos as if it had not been.
std::string SoughtPath(const StageFolder& folder, const std::string& photo) {
  return (fs::path(folder.Directory()) / (photo + ".sought")).string();
}

void WriteSought(const std::string& path, const Bounds& area) {
  WriteFileAtomically(path, area.Empty() ? "nowhere\n"
                                         : FormatText("%.17g %.17g %.17g %.17g\n", area.min_x,
                                                      area.min_y, area.max_x, area.max_y));
}

Bounds ReadSought(const std::string& path) {
  Bounds area;
  try {
    std::istringstream text(ReadFile(path));
    if (text >> area.min_x >> area.min_y >> area.max_x >> area.max_y) return area;
  } catch (const InputError&) {  // it came not so far
  }
  return Bounds::OfNothing();
}

// What a round tries, and what is known of it; `more`: text of what else its results depend on.
// `located`: by keypoints, which is no accuracy that anybody vouches for.
struct Round {
  std::vector<std::size_t> tried;
  OrientationTable table;
  std::string more;
  bool located = false;
};

// Photos that the round oriented take over their poses.
void RunRound(const NeighbourStage& stage, const Round& what, RoundsSoFar* rounds,
              std::vector<BlockPhotoFile>* photos) {
  const std::vector<std::size_t>& tried = what.tried;
  const std::string round = std::to_string(++rounds->count);
  const StageFolder folder((fs::path(stage.directory) / ("round-" + round)).string(),
                           ".exterior.json");
  const std::string digest = DigestOfRound(stage, *photos, what.more);
  ExteriorRunOptions options = stage.exterior;
  options.photos.clear();
  for (const std::size_t i : tried) {
    const std::string& name = (*photos)[i].name;
    options.photos.push_back((*photos)[i].path);
    if (folder.IsCurrent(name, digest))
      rounds->sought[name] = ReadSought(SoughtPath(folder, name));
    else
      folder.Drop(name);
  }
  NeighbourPatches lent(stage, *photos);
  std::mutex mutex;
  options.out = folder.Directory();
  options.pictures.reset();  // beside the round's results: they show no control patches
  options.resume = true;
  options.feedback = false;
  options.table = what.table;
  if (what.located) options.accuracy_is_stated = false;
  options.further_patches = [&](const std::string& name, const Bounds& area) {
    {
      const std::lock_guard<std::mutex> lock(mutex);
      auto& sought = rounds->sought.try_emplace(name, Bounds::OfNothing()).first->second;
      sought.Include(area.min_x, area.min_y);
      sought.Include(area.max_x, area.max_y);
    }
    return lent.In(area);
  };
  Progress progress("orientation by neighbours, round " + round, static_cast<int>(tried.size()));
  RunExterior(options, [&](const ExteriorResult& result) {
    {
      // Those that did not come so far as to look for patches have nothing to hope for.
      const std::lock_guard<std::mutex> lock(mutex);
      WriteSought(SoughtPath(folder, result.photo),
                  rounds->sought.try_emplace(result.photo, Bounds::OfNothing()).first->second);
    }
    folder.Note(result.photo, digest);
    progress.Advance();
  });
  rounds->fresh.clear();
  for (const std::size_t i : tried) {
    BlockPhotoFile now = ReadBlockPhoto((*photos)[i].path, folder.ResultPath((*photos)[i].name),
                                        stage.camera, stage.marks, stage.interior_directory);
    if (!now.HasPose()) continue;
    now.by_neighbours = true;
    now.alone = (*photos)[i].exterior;
    (*photos)[i] = std::move(now);
    rounds->fresh.push_back(i);
  }
}

// Chi-square of six degrees of freedom, 99.99 %.
constexpr double kMaxChi2 = 27.9;

// A photo that keypoints located where nobody expected it is weak: they may be right, or the
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
  photo->exterior.messages.push_back(FormatText(
      "the pose lies %.0f sigma from its approximation: either that is worse than its accuracy "
      "says, or its neighbours lie elsewhere",
      std::sqrt(chi2)));
}

// Photos that still have no pose, where keypoints that they share with oriented ones say where they
// are; the patches decide. Empty `tried`: there are none.
Round LocatedByKeypoints(const NeighbourStage& stage, const std::vector<BlockPhotoFile>& photos,
                         KeypointStage* keypoints, std::map<std::size_t, int>* agreeing) {
  Round round;
  round.table = stage.approximations.Table();
  round.located = true;
  std::vector<std::size_t> open;
  for (std::size_t i = 0; i < photos.size(); ++i)
    if (MayBeTried(photos[i], stage)) open.push_back(i);
  Progress progress("keypoints of photos not found yet", static_cast<int>(open.size()));
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
    round.more += " " + photos[i].name;
    const Vector6d pose = found->row.pose.AsVector();
    for (int k = 0; k < 6; ++k)
      round.more += FormatText(" %.17g %.17g", pose[k], (*found->row.sigma)[k]);
  }
  return round;
}

// What keypoints found that the patches confirmed; `refused`: what they did not.
void TellOfKeypoints(const NeighbourStage& stage, const std::map<std::size_t, int>& agreeing,
                     std::vector<BlockPhotoFile>* photos, std::map<std::size_t, int>* refused) {
  for (const auto& [i, count] : agreeing) {
    BlockPhotoFile& photo = (*photos)[i];
    if (!photo.HasPose()) {
      (*refused)[i] = count;
      continue;
    }
    photo.located_by = "located by " + std::to_string(count) +
                       " keypoints (SIFT) that it shares with photos that are oriented";
    CompareWithStated(stage, &photo);
  }
}

// Once the rounds are over.
void TellOfThoseInVain(const std::set<std::size_t>& in_vain,
                       const std::map<std::size_t, int>& refused,
                       std::vector<BlockPhotoFile>* photos) {
  for (std::size_t i = 0; i < photos->size(); ++i) {
    BlockPhotoFile& photo = (*photos)[i];
    if (photo.HasPose() || photo.exterior.messages.empty()) continue;
    const auto located = refused.find(i);
    std::string& message = photo.exterior.messages.back();
    if (located != refused.end())
      message += "; " + std::to_string(located->second) +
                 " keypoints (SIFT) that it shares with oriented photos agree on where it is, but "
                 "no patches there do";
    else if (in_vain.contains(i))
      message +=
          "; nor do keypoints (SIFT) that it shares with oriented photos agree on where it is";
  }
}

// Rounds until nobody is left to try, with what is known of the photos first and, where that does
// not do, with what keypoints say. Empty, or what stopped a round, where photos that it was to try
// have no pose: none of them lies on the DEM, say; the others need not suffer for it.
// `refused`: photos that keypoints located and patches did not confirm there.
std::string RunRounds(const NeighbourStage& stage, KeypointStage* keypoints,
                      std::vector<BlockPhotoFile>* photos, std::map<std::size_t, int>* refused) {
  RoundsSoFar rounds;
  std::string stopped;
  std::vector<std::size_t> not_tried;
  while (rounds.count < kFurtherRounds + std::ssize(*photos)) {
    LearnFrom(*photos, &stage.approximations);
    Round round;
    if (stopped.empty())
      round = {ToBeTried(stage, rounds, *photos), stage.approximations.Table(), "", false};
    std::map<std::size_t, int> agreeing;
    if (round.tried.empty()) round = LocatedByKeypoints(stage, *photos, keypoints, &agreeing);
    if (round.tried.empty()) break;
    try {
      RunRound(stage, round, &rounds, photos);
      TellOfKeypoints(stage, agreeing, photos, refused);
    } catch (const InputError& error) {
      const bool again = !stopped.empty() || !agreeing.empty();
      stopped = error.what();
      not_tried = round.tried;
      if (again) break;
    }
  }
  const bool all_found = std::all_of(not_tried.begin(), not_tried.end(),
                                     [&](std::size_t i) { return (*photos)[i].HasPose(); });
  return all_found ? "" : stopped;
}

}  // namespace

void RunNeighbourStage(const NeighbourStage& stage, std::vector<BlockPhotoFile>* photos,
                       std::vector<std::string>* messages) {
  if (std::none_of(photos->begin(), photos->end(),
                   [](const BlockPhotoFile& photo) { return photo.HasPose(); }))
    return;
  KeypointStage keypoints({stage.camera, stage.marks, stage.surface, stage.interior_directory,
                           (fs::path(stage.directory) / "keypoints").string(), stage.inputs,
                           stage.exterior.jobs});
  std::map<std::size_t, int> refused;
  const std::string stopped = RunRounds(stage, &keypoints, photos, &refused);
  keypoints.RemoveUnused();
  if (!stopped.empty())
    messages->push_back("The photos left could not be tried with their neighbours' patches: " +
                        stopped);
  TellOfThoseInVain(keypoints.InVain(), refused, photos);
}

}  // namespace orient
