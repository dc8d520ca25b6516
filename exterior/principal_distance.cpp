#include "exterior/principal_distance.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <map>

#include "core/base/median.h"
#include "core/terrain/view_over_ground.h"
#include "exterior/judge.h"
#include "exterior/steps/error_model.h"
#include "exterior/steps/patch_observation.h"
#include "exterior/steps/photo_task.h"
#include "exterior/steps/resect.h"

namespace orient::exterior {
namespace {

constexpr int kMaxRounds = 4;
constexpr double kSettledSigmas = 0.1;
constexpr double kUndetermined = 0.7;  // share of the prior's sigma that remains
constexpr double kNoPrior = 0.05;      // sigma of a negligible prior, as a share of the distance
constexpr double kContradictedSigmas = 4, kMovedSigmas = 3;

const FilmPosition& PositionOf(const PhotoToOrient& photo, const ExteriorResult& result) {
  return *std::find_if(photo.positions.begin(), photo.positions.end(),
                       [&](const FilmPosition& p) { return p.orientation == result.orientation; });
}

PhotoView ViewOf(const PhotoToOrient& photo, const ExteriorResult& result) {
  const FilmPosition& position = PositionOf(photo, result);
  return {photo.camera, position.photo_from_pixel, *result.pose, position.film_correction};
}

// Edges are left out: a result has of their covariance the sigmas of both axes only.
std::optional<CorrelatedPose> Free(const PhotoToOrient& photo,
                                   const std::vector<patchdb::Patch>& patches,
                                   const ExteriorResult& result, const PosePrior& approximation,
                                   const PrincipalDistancePrior& prior) {
  const FilmPosition& position = PositionOf(photo, result);
  const PhotoView view = ViewOf(photo, result);
  std::map<std::int64_t, const patchdb::Patch*> by_id;
  for (const patchdb::Patch& patch : patches) by_id[patch.id] = &patch;
  std::vector<PatchObservation> observations;
  for (const PatchResult& match : result.patches)
    if (match.state == PatchState::kMatched && match.pixel && match.sigma_px &&
        !IsOfEdge(*match.sigma_px))
      observations.push_back(ObservationOf(*by_id.at(match.id), *match.pixel,
                                           match.sigma_px->cwiseAbs2().asDiagonal(), view));
  if (observations.empty()) return std::nullopt;
  return EstimateCorrelatedPose(view, approximation, observations,
                                CommonErrorsOf(position, view, observations.front().ground_m.z()),
                                prior);
}

// An approximation that the photo contradicts is left out: the principal distance would take up its
// error, as the flying height does.
std::optional<CorrelatedPose> FreeOfWrongApproximation(const PhotoToOrient& photo,
                                                       const std::vector<patchdb::Patch>& patches,
                                                       const ExteriorResult& result,
                                                       const PrincipalDistancePrior& prior) {
  const auto without = Free(photo, patches, result, Weakened(photo.prior), prior);
  if (without && !(Apart({without->pose, without->honest_covariance}, photo.prior) <= kMostApart))
    return without;
  const auto with = Free(photo, patches, result, photo.prior, prior);
  return with ? with : without;
}

double MedianHeight_m(const ExteriorResult& result) {
  std::vector<double> heights_m;
  for (const PatchResult& match : result.patches)
    if (match.state == PatchState::kMatched) heights_m.push_back(match.ground_m->z());
  return UpperMedian(std::move(heights_m));
}

// Whether the target holds all over the frame where the principal distance is unknown, too.
void JudgePrecision(const PhotoToOrient& photo, const CorrelatedPose& estimated,
                    ExteriorResult* result) {
  PhotoView view = ViewOf(photo, *result);
  view.camera.principal_distance_mm = estimated.principal_distance_mm;
  const double height_m = MedianHeight_m(*result), pixel_m = view.GroundPixel(height_m);
  const double worst_px = WorstSigmaWithDistance(view, estimated.with_distance, height_m);
  result->projection_sigma = ProjectionSigmaOf(worst_px, pixel_m);
  std::erase_if(result->findings,
                [](const Finding& one) { return one.reason == Reason::kPoorlyDetermined; });
  result->status = StatusOf(result->findings);
  const double target_px = result->target_m.value_or(pixel_m) / pixel_m;
  if (!(worst_px <= target_px))
    Add({Reason::kPoorlyDetermined, Status::kWeak, worst_px, target_px}, result);
}

// Returns `first`, oriented with a principal distance that the user doubts, with a finding.
ExteriorResult NotEstimated(ExteriorResult first) {
  if (first.pose) Add({Reason::kPrincipalDistanceNotEstimated, Status::kWeak}, &first);
  return first;
}

// The largest distance in the frame between the two views' projections of level ground.
double LargestDifference_px(const PhotoView& one, const PhotoView& other, double height_m) {
  double largest_px = 0;
  for (const SeenPlace& place : OutermostInFrame(one.camera, one.pose, height_m))
    if (const auto there = other.PixelFromGround(place.ground_m))
      largest_px = std::max(largest_px, (*there - one.PixelFromPhoto(place.photo_mm)).norm());
  return largest_px;
}

}  // namespace

ExteriorResult OrientWithPrincipalDistance(const PhotoToOrient& photo, const PhotoImage& image,
                                           const std::vector<patchdb::Patch>& patches,
                                           const OrientPhotoOptions& options,
                                           const ExteriorResult& first, double sigma_mm) {
  const PrincipalDistancePrior prior{photo.camera.principal_distance_mm, sigma_mm};
  PhotoToOrient now = photo;
  ExteriorResult result = first;
  bool settled = false;
  for (int round = 0; round < kMaxRounds && !settled; ++round) {
    if (round > 0) result = OrientPhoto(now, image, patches, options);
    const auto estimated =
        result.pose ? FreeOfWrongApproximation(now, patches, result, prior) : std::nullopt;
    if (!estimated) return NotEstimated(first);
    const double moved_mm = estimated->principal_distance_mm - now.camera.principal_distance_mm;
    result.pose = estimated->pose;
    result.covariance = estimated->honest_covariance;
    JudgePrecision(now, *estimated, &result);
    result.principal_distance = EstimatedPrincipalDistance{estimated->principal_distance_mm,
                                                           estimated->principal_distance_sigma_mm,
                                                           prior.value_mm, sigma_mm};
    settled = std::abs(moved_mm) < kSettledSigmas * estimated->principal_distance_sigma_mm;
    now.camera.principal_distance_mm = estimated->principal_distance_mm;
  }
  if (!settled) Add({Reason::kPrincipalDistanceNotConverged, Status::kWeak}, &result);
  const double found_sigma_mm = result.principal_distance->sigma_mm;
  Add({Reason::kPrincipalDistanceEstimated, Status::kOk, result.principal_distance->value_mm,
       prior.value_mm},
      &result);
  if (found_sigma_mm > kUndetermined * sigma_mm)
    Add({Reason::kPrincipalDistanceUndetermined, Status::kOk, found_sigma_mm, sigma_mm}, &result);
  return result;
}

void JudgePrincipalDistance(const PhotoToOrient& photo, const std::vector<patchdb::Patch>& patches,
                            ExteriorResult* result) {
  if (!result->pose || !result->projection_sigma || !Has(result->findings, Reason::kResidualTrend))
    return;
  const double stated_mm = photo.camera.principal_distance_mm;
  const bool contradicted =
      !(Apart({*result->pose, *result->covariance}, photo.prior) <= kMostApart);
  const auto free =
      Free(photo, patches, *result, contradicted ? Weakened(photo.prior) : photo.prior,
           {stated_mm, kNoPrior * stated_mm});
  if (!free || !(std::abs(free->principal_distance_mm - stated_mm) >
                 kContradictedSigmas * free->principal_distance_sigma_mm))
    return;
  const PhotoView stated = ViewOf(photo, *result);
  PhotoView other = stated;
  other.pose = free->pose;
  other.camera.principal_distance_mm = free->principal_distance_mm;
  const double moved_px = LargestDifference_px(stated, other, MedianHeight_m(*result));
  const bool beyond = moved_px > kMovedSigmas * result->projection_sigma->px;
  Add({Reason::kPrincipalDistanceContradicted, beyond ? Status::kWeak : Status::kOk,
       free->principal_distance_mm, stated_mm,
       fmt::format("the pose with it differs by up to {:.1f} px in the frame", moved_px)},
      result);
}

}  // namespace orient::exterior
