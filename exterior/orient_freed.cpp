#include "exterior/orient_freed.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/format_text.h"
#include "exterior/error_model.h"
#include "exterior/freed_distance.h"

namespace orient {
namespace {

constexpr int kMaxRounds = 4;
constexpr double kSettledSigmas = 0.1;
constexpr double kUndetermined = 0.7;  // of the prior's sigma is left

PhotoView ViewOf(const PhotoToOrient& photo, const ExteriorResult& result) {
  const auto position =
      std::find_if(photo.positions.begin(), photo.positions.end(),
                   [&](const FilmPosition& p) { return p.orientation == result.orientation; });
  return {photo.camera, position->photo_from_pixel, *result.pose, position->film_correction};
}

std::vector<PatchObservation> Observations(const std::vector<Patch>& patches,
                                           const ExteriorResult& result, double film_sigma_px) {
  std::map<std::int64_t, const Patch*> by_id;
  for (const Patch& patch : patches) by_id[patch.id] = &patch;
  const double shared = kModelSigmaPx * kModelSigmaPx + film_sigma_px * film_sigma_px;
  std::vector<PatchObservation> observations;
  for (const PatchResult& match : result.patches) {
    if (match.state != PatchState::kMatched || !match.pixel || !match.sigma_px) continue;
    const Patch& patch = *by_id.at(match.id);
    PatchObservation observation{patch.ground_m, *match.pixel,
                                 match.sigma_px->cwiseAbs2().asDiagonal()};
    observation.covariance_px2 += shared * Eigen::Matrix2d::Identity();
    observation.height_effect = patch.height_effect.value_or(Eigen::Vector3d::Zero());
    observation.height_sigma_m = patch.height_sigma_m.value_or(0);
    observations.push_back(observation);
  }
  return observations;
}

double VarianceFactor(const std::vector<PatchObservation>& observations, double sigma0_px) {
  double sum = 0;
  for (const PatchObservation& o : observations) sum += o.covariance_px2.trace() / 2;
  return std::max(1.0, sigma0_px * sigma0_px * static_cast<double>(observations.size()) / sum);
}

std::optional<FreedPose> Free(const PhotoToOrient& photo, const std::vector<Patch>& patches,
                              const ExteriorResult& result, const PrincipalDistancePrior& prior) {
  const PhotoView view = ViewOf(photo, result);
  const auto observations =
      Observations(patches, result, photo.positions.front().film_sigma_mm / view.PixelSize());
  if (observations.empty()) return std::nullopt;
  double ground_m = 0;
  for (const PatchObservation& o : observations)
    ground_m += o.ground_m.z() / static_cast<double>(observations.size());
  const double reach_m = kHeightCorrelationPerHeight * (view.pose.position_m.z() - ground_m);
  return EstimateFreedPose(view, photo.prior, prior, observations,
                           VarianceFactor(observations, result.sigma0_px.value_or(0)),
                           std::max(reach_m, 1.0));
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
    result.covariance = freed->covariance;
    result.principal_distance = FreedPrincipalDistance{freed->principal_distance_mm,
                                                       freed->sigma_mm, prior.value_mm, sigma_mm};
    settled = std::abs(moved_mm) < kSettledSigmas * freed->sigma_mm;
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
