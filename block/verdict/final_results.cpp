// What the block adjustment makes of each photo: accepted, kept as it was alone, or failed.
#include <algorithm>
#include <cmath>
#include <set>

#include "core/format_text.h"
#include "exterior/estimate_pose.h"
#include "exterior/orient_photo.h"
#include "tools/block/adjustment_stage.h"
#include "tools/block/view_over_ground.h"
#include "tools/footprint.h"

namespace orient {
namespace {

constexpr int kMinTies = 6;             // of a photo whose own patches do not do
constexpr double kMinRedundancy = 6;    // of its ties together: below, none could be told wrong
constexpr double kWeakSigmaPx = 1.0;    // of a projection anywhere in the frame
constexpr double kMaxAloneChi2 = 27.9;  // six degrees of freedom, 99.99 %

struct Sightings {
  TieCount ties;
  int comparable = 0;  // of the measured ones: another photo's ray could contradict
  int control = 0;
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

// Of each point, how many photos that were adjusted show it.
std::vector<int> AdjustedRays(const AdjustedBlock& adjusted) {
  std::vector<int> rays(adjusted.block.points.size(), 0);
  for (const ImageObservation& observation : adjusted.block.observations)
    rays[observation.point] +=
        adjusted.result.photos[observation.photo].state == PhotoState::kAdjusted ? 1 : 0;
  return rays;
}

Sightings SightingsOf(const AdjustedBlock& adjusted, const std::vector<int>& rays,
                      const std::vector<std::size_t>& observations) {
  Sightings sightings;
  double tie_sum = 0, sum = 0, redundancy = 0;
  for (const std::size_t i : observations) {
    const ObservationResult& result = adjusted.result.observations[i];
    const bool tie = adjusted.block.observations[i].point < adjusted.ties;
    const bool used = result.state == ObservationState::kUsed;
    sightings.ties.measured += tie ? 1 : 0;
    sightings.comparable += tie && rays[adjusted.block.observations[i].point] > 1 ? 1 : 0;
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

AloneResult AloneOf(const ExteriorResult& result) {
  return {result.status, result.pose, result.covariance, result.sigma0_px, result.messages};
}

// A photo that ends without a pose keeps what was said about its patches.
ExteriorResult FailedFrom(const BlockPhotoFile& photo, const std::string& why) {
  ExteriorResult result = photo.by_neighbours ? photo.alone : photo.exterior;
  result.alone = AloneOf(result);
  result.status = Status::kFailed;
  result.pose.reset();
  result.covariance.reset();
  result.footprint_m.clear();
  result.messages.insert(result.messages.begin(), why);
  return result;
}

ExteriorResult Own(const BlockPhotoFile& photo, const std::string& why_by_neighbours) {
  if (photo.by_neighbours) return FailedFrom(photo, why_by_neighbours);
  return photo.exterior;
}

bool TiesContradict(const Sightings& sightings) {
  return sightings.comparable >= kMinTies && 2 * sightings.ties.used < sightings.comparable;
}

constexpr const char* kTiesContradict = "more than half of its tie points contradict its pose";

// Empty where a photo without control of its own may be accepted.
std::string WhyNotTied(const Sightings& sightings, double sigma_px) {
  if (sightings.ties.used < kMinTies)
    return "it hangs on its neighbours by only " + std::to_string(sightings.ties.used) +
           " tie points; at least " + std::to_string(kMinTies) + " are needed";
  if (TiesContradict(sightings)) return kTiesContradict;
  if (sightings.tie_redundancy < kMinRedundancy)
    return "its tie points do not control one another: most join it to one other photo only";
  if (!(sigma_px <= kWeakSigmaPx))
    return FormatText(
        "its tie points determine its pose poorly: in the worst corner of the frame its "
        "projection is uncertain by %.2f px",
        sigma_px);
  return "";
}

double WorstSigma(const AdjustmentInputs& inputs, const PhotoView& view,
                  const Matrix6d& covariance) {
  return WorstProjectionSigma(view, covariance,
                              GroundHeightUnder(inputs.surface, view.camera, view.pose));
}

constexpr const char* kNotAtRest =
    "the block's adjustment did not come to rest: this is what its own patches gave";

// Patches as the adjusted pose sees them.
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
    patch.reason = "does not agree with the block";
  }
}

// A photo that was weak for nothing but its precision has that of the block, if ties and not only
// the same few patches give it.
void LiftImprecision(const Sightings& sightings, ExteriorResult* result) {
  if (result->status != Status::kWeak || sightings.ties.used < kMinTies ||
      sightings.tie_redundancy < kMinRedundancy)
    return;
  // What else made it weak is still so.
  if (std::erase_if(result->messages, SpeaksOfPrecision) > 0 && result->messages.empty())
    result->status = Status::kOk;
}

// The photo was ok or weak alone: what speaks against its pose in the block.
void JudgeAlone(const AdjustmentInputs& inputs, const BlockPhotoFile& photo,
                const PhotoView& adjusted, const Sightings& sightings, double sigma_px,
                ExteriorResult* result) {
  const ExteriorResult& alone = photo.exterior;
  const PhotoView alone_view = photo.View(inputs.camera);
  result->status = alone.status;
  result->messages = alone.messages;
  LiftImprecision(sightings, result);
  if (!(sigma_px <= kWeakSigmaPx)) {
    result->status = Status::kWeak;
    result->messages.push_back(FormatText(
        "the pose is poorly determined: in the worst corner of the frame its projection is "
        "uncertain by %.2f px",
        sigma_px));
  }
  if (TiesContradict(sightings)) {
    result->status = Status::kWeak;
    result->messages.emplace_back(kTiesContradict);
  }
  // A calibrated lens moves poses, and is no contradiction: compared is what the photo's own camera
  // makes of the adjusted view.
  const auto as_alone = PoseShowingTheSame(
      adjusted, alone_view, GroundHeightUnder(inputs.surface, adjusted.camera, adjusted.pose));
  const Vector6d moved = PoseDifference(as_alone.value_or(*result->pose), *alone.pose);
  const double chi2 = moved.dot((*alone.covariance + *result->covariance).ldlt().solve(moved));
  if (chi2 > kMaxAloneChi2) {
    result->status = Status::kWeak;
    result->messages.push_back(FormatText(
        "the block moved it by %.0f sigma from where its own patches put it: they or its ties are "
        "wrong",
        std::sqrt(chi2)));
  }
}

// A pose that was not adjusted, for the camera that the block found: it shows the same ground.
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

// The adjustment moves a photo's film transform within its covariance. What is written is the film
// transform of interior orientation, so the pose that goes with it is the one that shows with it
// what the adjusted photo shows.
PhotoView WithOwnFilm(const AdjustmentInputs& inputs, const AdjustedBlock& adjusted,
                      std::size_t photo) {
  const PhotoView moved = AdjustedView(adjusted.block, adjusted.result, photo);
  PhotoView own = moved;
  own.photo_from_pixel = adjusted.block.photos[photo].photo_from_pixel;
  if (adjusted.result.photos[photo].interior_correction.isZero()) return own;
  const double height_m = GroundHeightUnder(inputs.surface, moved.camera, moved.pose);
  own.pose = PoseShowingTheSame(moved, own, height_m).value_or(moved.pose);
  return own;
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
  if (!adjusted.result.converged) {
    ExteriorResult result = Own(file, "the block's adjustment did not come to rest");
    result.ties = sightings.ties;
    if (!result.pose) return result;
    result.status = Status::kWeak;
    result.messages.emplace_back(kNotAtRest);
    return result;
  }
  if (!adjusted_well || sightings.ties.used == 0) {
    std::string why = "its ties do not connect it to control patches";
    if (part != nullptr && !part->message.empty()) why += ": " + part->message;
    ExteriorResult result = Own(file, why);
    UseCalibratedCamera(inputs, adjusted, photo, &result);
    result.ties = sightings.ties;
    if (result.status == Status::kOk && TiesContradict(sightings)) {
      result.status = Status::kWeak;
      result.messages.emplace_back(kTiesContradict);
    }
    return result;
  }
  const PhotoView view = WithOwnFilm(inputs, adjusted, photo);
  const double sigma_px = WorstSigma(inputs, view, now.covariance);
  if (file.by_neighbours) {
    const std::string objection = WhyNotTied(sightings, sigma_px);
    if (!objection.empty()) {
      ExteriorResult result = FailedFrom(file, objection);
      result.ties = sightings.ties;
      return result;
    }
  }
  ExteriorResult result = file.exterior;
  result.alone = AloneOf(file.by_neighbours ? file.alone : file.exterior);
  result.pose = view.pose;
  result.covariance = now.covariance;
  result.ties = sightings.ties;
  result.sigma0_px = sightings.sigma0_px;
  result.footprint_m = Footprint(view, inputs.surface);
  UpdatePatches(adjusted, observations, view, &result);
  if (file.by_neighbours) {
    result.status = file.exterior.status;
    LiftImprecision(sightings, &result);
    result.messages.insert(result.messages.begin(),
                           "oriented by " + std::to_string(sightings.ties.used) +
                               " tie points with its neighbours; its own patches did not do");
    if (!file.located_by.empty()) result.messages[0] += "; " + file.located_by;
  } else {
    JudgeAlone(inputs, file, view, sightings, sigma_px, &result);
  }
  return result;
}

// A photo that hangs on others is no better than they: where none of those that hang together is
// ok by patches of its own, it is weak.
void JudgeHanging(const AdjustmentInputs& inputs, const AdjustedBlock& adjusted,
                  const std::vector<Sightings>& sightings, std::vector<ExteriorResult>* results) {
  std::set<int> held;
  for (std::size_t i = 0; i < adjusted.photo_of.size(); ++i)
    if (!inputs.photos[adjusted.photo_of[i]].by_neighbours &&
        (*results)[adjusted.photo_of[i]].status == Status::kOk && sightings[i].control > 0)
      held.insert(adjusted.result.photos[i].part);
  for (std::size_t i = 0; i < adjusted.photo_of.size(); ++i) {
    ExteriorResult& result = (*results)[adjusted.photo_of[i]];
    if (!inputs.photos[adjusted.photo_of[i]].by_neighbours || result.status != Status::kOk ||
        held.contains(adjusted.result.photos[i].part))
      continue;
    result.status = Status::kWeak;
    result.messages.emplace_back("the photos that it hangs on are weak themselves");
  }
}

}  // namespace

std::vector<ExteriorResult> FinalResults(const AdjustmentInputs& inputs,
                                         const AdjustedBlock& adjusted) {
  std::vector<ExteriorResult> results = OwnResults(inputs.photos);
  const auto observations = ObservationsByPhoto(adjusted);
  const std::vector<int> rays = AdjustedRays(adjusted);
  std::vector<Sightings> sightings;
  for (std::size_t i = 0; i < adjusted.photo_of.size(); ++i) {
    sightings.push_back(SightingsOf(adjusted, rays, observations[i]));
    results[adjusted.photo_of[i]] = Final(inputs, adjusted, i, observations[i], sightings[i]);
  }
  JudgeHanging(inputs, adjusted, sightings, &results);
  return results;
}

void HoldToControl(const std::vector<ExteriorResult>& without,
                   std::vector<ExteriorResult>* results) {
  for (std::size_t i = 0; i < results->size(); ++i) {
    ExteriorResult& result = (*results)[i];
    const ExteriorResult& held = without[i];
    if (held.status == Status::kFailed) {
      result = held;
      if (!result.messages.empty())
        result.messages[0].insert(0, "without GNSS and approximations: ");
    } else if (held.status == Status::kWeak && result.status == Status::kOk) {
      result.status = Status::kWeak;
      std::string why = "without GNSS and approximations it is weak";
      for (std::size_t k = 0; k < held.messages.size(); ++k)
        why.append(k == 0 ? ": " : "; ").append(held.messages[k]);
      result.messages.push_back(std::move(why));
    }
  }
}

void HoldAllToControl(std::vector<ExteriorResult>* results) {
  for (ExteriorResult& result : *results) {
    if (result.status != Status::kOk) continue;
    result.status = Status::kWeak;
    result.messages.emplace_back("without GNSS and approximations the block does not come to rest");
  }
}

std::vector<ExteriorResult> OwnResults(const std::vector<BlockPhotoFile>& photos) {
  std::vector<ExteriorResult> results;
  for (const BlockPhotoFile& photo : photos)
    results.push_back(Own(photo, "it has no tie points with its neighbours"));
  return results;
}

}  // namespace orient
