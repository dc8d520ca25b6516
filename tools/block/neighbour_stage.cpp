#include "tools/block/neighbour_stage.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <mutex>

#include "core/error.h"
#include "core/files/orientation_table.h"
#include "patchdb/harvest.h"
#include "tools/block/stage_folder.h"
#include "tools/made_from.h"
#include "tools/progress.h"
#include "tools/shared_options.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

constexpr int kMaxRounds = 20;
constexpr int kPatchesOfAPhoto = 500;
// Neighbours' patches have numbers below zero, which no database gives.
constexpr std::int64_t kNumbersOfAPhoto = 100000;

// Patches of the photos that have a pose, each photo's cut when somebody first asks.
class NeighbourPatches {
 public:
  NeighbourPatches(const NeighbourStage& stage, const std::vector<BlockPhotoFile>& photos)
      : stage_(stage), photos_(photos) {}

  std::vector<Patch> In(const Bounds& area) {
    const std::lock_guard<std::mutex> lock(mutex_);
    std::vector<Patch> patches;
    for (std::size_t i = 0; i < photos_.size(); ++i) {
      if (!photos_[i].HasPose() || !Touch(photos_[i].footprint, area)) continue;
      for (const Patch& patch : Of(i))
        if (area.Contains(patch.ground_m.x(), patch.ground_m.y())) patches.push_back(patch);
    }
    return patches;
  }

  // Who would be asked.
  std::vector<std::size_t> Sources() const {
    std::vector<std::size_t> sources;
    for (std::size_t i = 0; i < photos_.size(); ++i)
      if (photos_[i].HasPose()) sources.push_back(i);
    return sources;
  }

 private:
  static bool Touch(const Bounds& a, const Bounds& b) {
    return a.min_x < b.max_x && b.min_x < a.max_x && a.min_y < b.max_y && b.min_y < a.max_y;
  }

  const std::vector<Patch>& Of(std::size_t i) {
    const auto known = patches_.find(i);
    if (known != patches_.end()) return known->second;
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
    return patches_[i] = std::move(patches);
  }

  const NeighbourStage& stage_;
  const std::vector<BlockPhotoFile>& photos_;
  std::mutex mutex_;
  std::map<std::size_t, std::vector<Patch>> patches_;
};

// Of all that lend patches in a round: coarse, but rounds are few and failed photos, too.
std::string DigestOfRound(const NeighbourStage& stage, const std::vector<BlockPhotoFile>& photos) {
  std::string text = "neighbours 1" + stage.inputs;
  for (const BlockPhotoFile& photo : photos)
    text += photo.name + DigestOfFile(photo.path) + DigestOfFile(photo.result_path) +
            (photo.HasPose() ? "+" : "-");
  return Digest(text);
}

// Whether the photo could be tried at all: an approximation, a film transform.
bool MayBeTried(const BlockPhotoFile& photo, const NeighbourStage& stage,
                const OrientationTable& approximations) {
  if (photo.HasPose() || approximations.Find(photo.name) == nullptr) return false;
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

// Whether the round oriented anybody.
bool RunRound(const NeighbourStage& stage, int round, const OrientationTable& approximations,
              std::vector<BlockPhotoFile>* photos) {
  const StageFolder folder(
      (fs::path(stage.directory) / ("round-" + std::to_string(round))).string(), ".exterior.json");
  const std::string digest = DigestOfRound(stage, *photos);
  ExteriorRunOptions options = stage.exterior;
  options.photos.clear();
  std::vector<std::size_t> tried;
  for (std::size_t i = 0; i < photos->size(); ++i) {
    const BlockPhotoFile& photo = (*photos)[i];
    if (!MayBeTried(photo, stage, approximations)) continue;
    tried.push_back(i);
    options.photos.push_back(photo.path);
    if (!folder.IsCurrent(photo.name, digest)) folder.Drop(photo.name);
  }
  if (tried.empty()) return false;
  NeighbourPatches lent(stage, *photos);
  options.out = folder.Directory();
  options.resume = true;
  options.feedback = false;
  options.further_patches = [&](const std::string&, const Bounds& area) { return lent.In(area); };
  Progress progress("orientation by neighbours, round " + std::to_string(round),
                    static_cast<int>(tried.size()));
  try {
    RunExterior(options, [&](const ExteriorResult& result) {
      folder.Note(result.photo, digest);
      progress.Advance();
    });
  } catch (const InputError&) {
    // What concerns all photos has stopped their own stage: none of those left lies on the DEM.
    return false;
  }
  bool any = false;
  for (const std::size_t i : tried) {
    BlockPhotoFile now = ReadBlockPhoto((*photos)[i].path, folder.ResultPath((*photos)[i].name),
                                        stage.camera, stage.marks, stage.interior_directory);
    if (!now.HasPose()) continue;
    now.by_neighbours = true;
    now.alone = (*photos)[i].exterior;
    (*photos)[i] = std::move(now);
    any = true;
  }
  return any;
}

}  // namespace

void RunNeighbourStage(const NeighbourStage& stage, std::vector<BlockPhotoFile>* photos) {
  const OrientationTable approximations = ReadOrientationTable(stage.exterior.approximations);
  for (int round = 1; round <= kMaxRounds; ++round) {
    const bool somebody = std::any_of(photos->begin(), photos->end(),
                                      [](const BlockPhotoFile& photo) { return photo.HasPose(); });
    if (!somebody || !RunRound(stage, round, approximations, photos)) return;
  }
}

}  // namespace orient
