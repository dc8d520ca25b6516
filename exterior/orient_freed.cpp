#include "exterior/orient_freed.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/format_text.h"
#include "exterior/patch_observation.h"

namespace orient {
namespace {

constexpr int kMaxRounds = 4;
constexpr double kSettledSigmas = 0.1;
constexpr double kUndetermined = 0.7;  // of the prior's sigma is left

const FilmPosition& PositionOf(const PhotoToOrient& photo, const ExteriorResult& result) {
  return *std::find_if(photo.positions.begin(), photo.positions.end(),
                       [&](const FilmPosition& p) { return p.orientation == result.orientation; });
}

std::optional<CorrelatedPose> Free(const PhotoToOrient& photo, const std::vector<Patch>& patches,
                                   const ExteriorResult& result,
                                   const PrincipalDistancePrior& prior) {
  const FilmPosition& position = PositionOf(photo, result);
  const PhotoView view = {photo.camera, position.photo_from_pixel, *result.pose,
                          position.film_correction};
  std::map<std::int64_t, const Patch*> by_id;
  for (const Patch& patch : patches) by_id[patch.id] = &patch;
  std::vector<PatchObservation> observations;
  for (const PatchResult& match : result.patches)
    if (match.state == PatchState::kMatched && match.pixel && match.sigma_px)
      observations.push_back(ObservationOf(*by_id.at(match.id), *match.pixel,
                                           match.sigma_px->cwiseAbs2().asDiagonal(), view));
  if (observations.empty()) return std::nullopt;
  return EstimateCorrelatedPose(view, photo.prior, observations,
                                CommonErrorsOf(position, view, observations.front().ground_m.z()),
                                prior);
}

void Weaken(ExteriorResult* result, const std::string& why) {
  if (result->status == Status::kOk) result->status = Status::kWeak;
  result->messages.push_back(why);
}

// `first` was oriented with a principal distance that its user doubts.
ExteriorResult NotFreed(ExteriorResult first) {
  if (first.pose)
    Weaken(&first,
           "the principal distance could not be estimated: the pose is that of the camera "
           "file's");
  return first;
}

}  // namespace

ExteriorResult OrientFreed(const PhotoToOrient& photo, const PhotoImage& image,
                           const std::vector<Patch>& patches, const OrientPhotoOptions& options,
                           const ExteriorResult& first, double sigma_mm) {
  const PrincipalDistancePrior prior{photo.camera.principal_distance_mm, sigma_mm};
  PhotoToOrient now = photo;
  ExteriorResult result = first;
  bool settled = false;
  for (int round = 0; round < kMaxRounds && !settled; ++round) {
    if (round > 0) result = OrientPhoto(now, image, patches, options);
    const auto freed = result.pose ? Free(now, patches, result, prior) : std::nullopt;
    if (!freed) return NotFreed(first);
    const double moved_mm = freed->principal_distance_mm - now.camera.principal_distance_mm;
    result.pose = freed->pose;
    result.covariance = freed->honest_covariance;
    result.principal_distance = FreedPrincipalDistance{
        freed->principal_distance_mm, freed->principal_distance_sigma_mm, prior.value_mm, sigma_mm};
    settled = std::abs(moved_mm) < kSettledSigmas * freed->principal_distance_sigma_mm;
    now.camera.principal_distance_mm = freed->principal_distance_mm;
  }
  if (!settled) Weaken(&result, "pose and principal distance did not settle");
  result.messages.push_back(FormatText(
      "the pose holds with a principal distance of %.3f mm, not with the camera file's %.3f mm",
      result.principal_distance->value_mm, prior.value_mm));
  if (result.principal_distance->sigma_mm > kUndetermined * sigma_mm)
    result.messages.push_back(
        FormatText("the photo does not tell its principal distance: its sigma is still %.3f mm of "
                   "%.3f mm; the flying height takes it where the ground is level",
                   result.principal_distance->sigma_mm, sigma_mm));
  return result;
}

}  // namespace orient
