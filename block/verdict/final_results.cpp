#include "block/verdict/final_results.h"

#include <fmt/ranges.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <set>

#include "block/bundle/adjusted_view.h"
#include "block/verdict/judge.h"
#include "core/terrain/footprint.h"
#include "core/terrain/view_over_ground.h"
#include "exterior/judge.h"
#include "exterior/orient_photo.h"
#include "exterior/steps/resect.h"

namespace orient::block {
namespace {

struct Sightings {
  TieCount ties;
  int comparable = 0;  // measured ties that another photo's ray could contradict
  int control = 0;
  std::vector<std::string> points_rejected;  // control points that a person measured in it
  double tie_redundancy = 0;
  double sigma0_px = 0;  // of one coordinate, from all used sightings and their redundancy
};

// The observations of each photo of the block.
std::vector<std::vector<std::size_t>> ObservationsByPhoto(const AdjustedBlock& adjusted) {
  std::vector<std::vector<std::size_t>> of_photo(adjusted.photo_of.size());
  for (std::size_t i = 0; i < adjusted.block.observations.size(); ++i)
    of_photo[adjusted.block.observations[i].photo].push_back(i);
  return of_photo;
}

// For each point, whether rays of adjusted photos could contradict each other, which they cannot if
// they meet only at a very small angle.
std::vector<bool> Comparable(const AdjustedBlock& adjusted) {
  std::vector<int> rays(adjusted.block.points.size(), 0);
  std::vector<bool> met(rays.size(), false);
  for (std::size_t i = 0; i < adjusted.block.observations.size(); ++i) {
    const ImageObservation& observation = adjusted.block.observations[i];
    if (adjusted.result.photos[observation.photo].state != PhotoState::kAdjusted) continue;
    ++rays[observation.point];
    if (adjusted.result.observations[i].state != ObservationState::kWeakAngle)
      met[observation.point] = true;
  }
  for (std::size_t point = 0; point < rays.size(); ++point)
    met[point] = met[point] && rays[point] > 1;
  return met;
}

// Whether it is of a control point measured by a person and rejected by the block.
bool IsRejectedPoint(const AdjustedBlock& adjusted, std::size_t observation) {
  const std::size_t i = adjusted.block.observations[observation].point;
  const BlockPoint& point = adjusted.block.points[i];
  return point.by_hand && point.control && !point.held_out &&
         (adjusted.result.points[i].control_rejected ||
          adjusted.result.observations[observation].state == ObservationState::kRejected);
}

std::string NameOf(const AdjustedBlock& adjusted, std::size_t point) {
  for (const SurveyedPoint& one : adjusted.surveyed)
    if (one.point == point) return one.name;
  return std::to_string(adjusted.block.points[point].id);
}

Sightings SightingsOf(const AdjustedBlock& adjusted, const std::vector<bool>& comparable,
                      const std::vector<std::size_t>& observations) {
  Sightings sightings;
  double tie_sum = 0, sum = 0, redundancy = 0;
  for (const std::size_t i : observations) {
    const ObservationResult& result = adjusted.result.observations[i];
    const bool tie = adjusted.block.observations[i].point < adjusted.ties;
    const bool used = result.state == ObservationState::kUsed;
    sightings.ties.measured += tie ? 1 : 0;
    if (IsRejectedPoint(adjusted, i))
      sightings.points_rejected.push_back(NameOf(adjusted, adjusted.block.observations[i].point));
    sightings.comparable += tie && comparable[adjusted.block.observations[i].point] ? 1 : 0;
    if (!used) continue;
    sum += result.residual_px.squaredNorm();
    redundancy += result.redundancy;
    if (tie) {
      ++sightings.ties.used;
      tie_sum += result.residual_px.squaredNorm();
      sightings.tie_redundancy += result.redundancy;
    } else {
      ++sightings.control;
    }
  }
  if (sightings.ties.used > 0) sightings.ties.rms_px = std::sqrt(tie_sum / sightings.ties.used);
  if (redundancy > 0) sightings.sigma0_px = std::sqrt(sum / redundancy);
  return sightings;
}

// Adds a finding if the photo's pose came from measured points alone and the block rejects points
// other than those already left out of that pose.
void NameRejectedPoints(const Sightings& sightings, ExteriorResult* result) {
  if (!Has(result->findings, Reason::kByPointsAlone)) return;
  std::vector<std::string> rejected = sightings.points_rejected;
  for (const Finding& finding : result->findings)
    if (finding.reason == Reason::kPointsWrong)
      std::erase_if(rejected, [&](const std::string& name) {
        return (", " + finding.where + ",").find(", " + name + ",") != std::string::npos;
      });
  if (rejected.empty()) return;
  exterior::Add({.reason = Reason::kPointsOffPose,
                 .at_best = Status::kWeak,
                 .value = static_cast<double>(rejected.size()),
                 .where = fmt::format("{}", fmt::join(rejected, ", "))},
                result);
}

AloneResult AloneOf(const ExteriorResult& result) {
  return {result.status, result.pose, result.covariance, result.sigma0_px, result.findings};
}

// A photo that ends without a pose keeps the results of its patches.
ExteriorResult FailedFrom(const BlockPhotoFile& photo, const Finding& why) {
  ExteriorResult result = photo.by_neighbours ? photo.alone : photo.exterior;
  result.alone = AloneOf(result);
  result.status = Status::kFailed;
  WithdrawPose(&result);
  result.findings.insert(result.findings.begin(), why);
  return result;
}

ExteriorResult Own(const BlockPhotoFile& photo, const Finding& why_by_neighbours) {
  if (photo.by_neighbours) return FailedFrom(photo, why_by_neighbours);
  return photo.exterior;
}

Finding Failing(Reason reason, std::string where = {}) {
  return {.reason = reason, .at_best = Status::kFailed, .where = std::move(where)};
}

// Updates residuals and states of the patches for the adjusted pose.
void UpdatePatches(const AdjustedBlock& adjusted, const std::vector<std::size_t>& observations,
                   const PhotoView& view, ExteriorResult* result) {
  std::map<std::size_t, std::size_t> observation_of;
  for (const std::size_t i : observations) observation_of[adjusted.block.observations[i].point] = i;
  std::erase_if(result->patches, [](const PatchResult& patch) { return patch.id < 0; });
  for (PatchResult& patch : result->patches) {
    if (!patch.ground_m || !patch.pixel) continue;
    if (const auto seen = view.PixelFromGround(*patch.ground_m))
      patch.residual_px = *patch.pixel - *seen;
    const auto point = adjusted.patch.find(patch.id);
    if (patch.state != PatchState::kMatched || point == adjusted.patch.end()) continue;
    const auto observation = observation_of.find(point->second);
    const bool rejected =
        adjusted.result.points[point->second].control_rejected ||
        (observation != observation_of.end() &&
         adjusted.result.observations[observation->second].state == ObservationState::kRejected);
    if (!rejected) continue;
    patch.state = PatchState::kRejected;
    patch.findings = {{.reason = Reason::kPatchContradictsBlock}};
  }
}

// How far the block moved a photo from its pose by its own patches. A calibrated lens moves poses
// without contradiction: compared is the pose that shows with the photo's own camera what the
// adjusted view shows.
Vector6d MovedFromAlone(const AdjustmentInputs& inputs, const BlockPhotoFile& photo,
                        const PhotoView& adjusted, const ExteriorResult& result) {
  const auto as_alone =
      PoseShowingTheSame(adjusted, photo.View(inputs.camera),
                         GroundHeightUnder(inputs.surface, adjusted.camera, adjusted.pose));
  return PoseDifference(as_alone.value_or(*result.pose), *photo.exterior.pose);
}

// For a photo with a pose by its own patches; after UpdatePatches. If the block holds it off that
// pose, it is undecidable which of the two is right, and the covariance covers both.
void CompareWithAlone(const AdjustmentInputs& inputs, const BlockPhotoFile& photo,
                      const PhotoView& view, double height_m, TiedPhoto* tied,
                      ExteriorResult* result) {
  const Vector6d moved = MovedFromAlone(inputs, photo, view, *result);
  tied->moved_chi2 =
      moved.dot((*photo.exterior.covariance + *result->covariance).ldlt().solve(moved));
  tied->own = OwnPatchesOf(photo.exterior.patches, result->patches);
  if (!IsHeldOff(tied->own)) return;
  *result->covariance += moved * moved.transpose();
  tied->worst_sigma_px = exterior::WorstProjectionSigma(view, *result->covariance, height_m);
  result->projection_sigma =
      exterior::ProjectionSigmaOf(tied->worst_sigma_px, view.GroundPixel(height_m));
}

// Converts a pose that was not adjusted to the calibrated camera, so that it shows the same ground.
void UseCalibratedCamera(const AdjustmentInputs& inputs, const AdjustedBlock& adjusted,
                         std::size_t photo, ExteriorResult* result) {
  const auto& parameters = adjusted.result.calibration;
  const bool calibrated =
      std::any_of(parameters.begin(), parameters.end(), [](const CalibrationParameter& parameter) {
        return parameter.state == CalibrationState::kEstimated;
      });
  if (!calibrated || !result->pose) return;
  PhotoView own = inputs.photos[adjusted.photo_of[photo]].View(inputs.camera);
  own.pose = *result->pose;
  PhotoView with = own;
  with.camera = adjusted.result.cameras[adjusted.block.photos[photo].camera];
  if (const auto pose =
          PoseShowingTheSame(own, with, GroundHeightUnder(inputs.surface, own.camera, own.pose)))
    result->pose = *pose;
}

PhotoView WithOwnFilm(const AdjustmentInputs& inputs, const AdjustedBlock& adjusted,
                      std::size_t photo) {
  const Camera& camera = adjusted.result.cameras[adjusted.block.photos[photo].camera];
  return ViewWithGivenFilm(
      adjusted.block, adjusted.result, photo,
      GroundHeightUnder(inputs.surface, camera, adjusted.result.photos[photo].pose));
}

ExteriorResult NotConverged(const BlockPhotoFile& file, const Sightings& sightings) {
  ExteriorResult result = Own(file, Failing(Reason::kBlockNotConverged));
  result.ties = sightings.ties;
  if (result.pose)
    exterior::Add({.reason = Reason::kBlockNotConverged,
                   .at_best = Status::kWeak,
                   .where = ": this is the pose of its own patches or points"},
                  &result);
  return result;
}

ExteriorResult Final(const AdjustmentInputs& inputs, const AdjustedBlock& adjusted,
                     std::size_t photo, const std::vector<std::size_t>& observations,
                     const Sightings& sightings) {
  const BlockPhotoFile& file = inputs.photos[adjusted.photo_of[photo]];
  const AdjustedPhoto& now = adjusted.result.photos[photo];
  const BlockPart* part = now.part >= 0 && now.part < std::ssize(adjusted.result.parts)
                              ? &adjusted.result.parts[static_cast<std::size_t>(now.part)]
                              : nullptr;
  const bool adjusted_well =
      now.state == PhotoState::kAdjusted && part != nullptr && part->by_control;
  TiedPhoto tied{sightings.ties.used, sightings.comparable, sightings.tie_redundancy};
  if (!adjusted.result.converged) return NotConverged(file, sightings);
  if (!adjusted_well || sightings.ties.used == 0) {
    const bool told = part != nullptr && part->finding;
    ExteriorResult result =
        Own(file, Failing(Reason::kNotConnected, told ? ": " + Sentence(*part->finding) : ""));
    UseCalibratedCamera(inputs, adjusted, photo, &result);
    result.ties = sightings.ties;
    if (result.status == Status::kOk && TiesContradict(tied))
      exterior::Add(TiesContradictFinding(Status::kWeak), &result);
    return result;
  }
  const PhotoView view = WithOwnFilm(inputs, adjusted, photo);
  const double height_m = GroundHeightUnder(inputs.surface, view.camera, view.pose);
  const double pixel_m = view.GroundPixel(height_m);
  tied.control_elsewhere = part->control_points - sightings.control;
  tied.worst_sigma_px = exterior::WorstProjectionSigma(view, now.covariance, height_m);
  if (file.exterior.target_m) tied.target_px = *file.exterior.target_m / pixel_m;
  const Findings left_open = file.by_neighbours ? JudgeTied(tied) : Findings();
  if (StatusOf(left_open) == Status::kFailed) {
    ExteriorResult result = FailedFrom(file, left_open.front());
    result.ties = sightings.ties;
    return result;
  }
  ExteriorResult result = file.exterior;
  result.alone = AloneOf(file.by_neighbours ? file.alone : file.exterior);
  result.pose = view.pose;
  result.covariance = now.covariance;
  result.projection_sigma = exterior::ProjectionSigmaOf(tied.worst_sigma_px, pixel_m);
  result.ties = sightings.ties;
  result.sigma0_px = sightings.sigma0_px;
  result.footprint_m = Footprint(view, inputs.surface);
  UpdatePatches(adjusted, observations, view, &result);
  exterior::RejudgeSources(&result);
  if (!file.by_neighbours) CompareWithAlone(inputs, file, view, height_m, &tied, &result);
  NameRejectedPoints(sightings, &result);
  RejudgePrecision(tied, &result);
  if (file.by_neighbours) {
    const std::string located = file.located_by.empty() ? "" : "; " + file.located_by;
    result.findings.insert(
        result.findings.begin(),
        {.reason = Reason::kOrientedByNeighbours, .value = sightings.ties.used, .where = located});
    for (const Finding& finding : left_open) exterior::Add(finding, &result);
  } else {
    for (const Finding& finding : JudgeAgainstOwnPatches(tied)) exterior::Add(finding, &result);
  }
  return result;
}

// Whether a photo's pose rests on control of its own and not on its neighbours'.
bool HoldsOthers(const BlockPhotoFile& photo, const ExteriorResult& result, int control) {
  const Findings& alone = photo.exterior.findings;
  return !photo.by_neighbours && result.status == Status::kOk && control > 0 &&
         std::none_of(alone.begin(), alone.end(), IsByFewPoints);
}

// A photo that depends on others is no better than they: if none of the photos connected with it
// is ok by control of its own, it is weak.
void JudgeHanging(const AdjustmentInputs& inputs, const AdjustedBlock& adjusted,
                  const std::vector<Sightings>& sightings, std::vector<ExteriorResult>* results) {
  std::set<int> held;
  for (std::size_t i = 0; i < adjusted.photo_of.size(); ++i)
    if (HoldsOthers(inputs.photos[adjusted.photo_of[i]], (*results)[adjusted.photo_of[i]],
                    sightings[i].control))
      held.insert(adjusted.result.photos[i].part);
  for (std::size_t i = 0; i < adjusted.photo_of.size(); ++i) {
    ExteriorResult& result = (*results)[adjusted.photo_of[i]];
    if (!inputs.photos[adjusted.photo_of[i]].by_neighbours || result.status != Status::kOk ||
        held.contains(adjusted.result.photos[i].part))
      continue;
    exterior::Add({Reason::kNeighboursWeak, Status::kWeak}, &result);
  }
}

}  // namespace

std::vector<ExteriorResult> FinalResults(const AdjustmentInputs& inputs,
                                         const AdjustedBlock& adjusted) {
  std::vector<ExteriorResult> results = OwnResults(inputs.photos);
  const auto observations = ObservationsByPhoto(adjusted);
  const std::vector<bool> comparable = Comparable(adjusted);
  std::vector<Sightings> sightings;
  for (std::size_t i = 0; i < adjusted.photo_of.size(); ++i) {
    sightings.push_back(SightingsOf(adjusted, comparable, observations[i]));
    results[adjusted.photo_of[i]] = Final(inputs, adjusted, i, observations[i], sightings[i]);
  }
  JudgeHanging(inputs, adjusted, sightings, &results);
  return results;
}

void HoldToControl(const std::vector<ExteriorResult>& without,
                   std::vector<ExteriorResult>* results) {
  for (std::size_t i = 0; i < results->size(); ++i) HoldTo(without[i], &(*results)[i]);
}

void HoldAllToControl(std::vector<ExteriorResult>* results) {
  for (ExteriorResult& result : *results)
    if (result.status == Status::kOk)
      exterior::Add({Reason::kBlockNotConvergedWithoutPriors, Status::kWeak}, &result);
}

std::vector<ExteriorResult> OwnResults(const std::vector<BlockPhotoFile>& photos) {
  std::vector<ExteriorResult> results;
  for (const BlockPhotoFile& photo : photos)
    results.push_back(Own(photo, Failing(Reason::kNoTies)));
  return results;
}

}  // namespace orient::block
