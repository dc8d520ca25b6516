#include "block/stages/measured_block.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>

#include "block/bundle/adjusted_view.h"
#include "block/bundle/sub_blocks.h"
#include "block/inputs/film_positions.h"
#include "block/inputs/measurement_inputs.h"
#include "block/stages/measured_first_poses.h"
#include "core/base/error.h"
#include "core/base/median.h"
#include "exterior/judge.h"
#include "exterior/search/point_checks.h"
#include "exterior/search/point_resection.h"
#include "exterior/steps/resect.h"

namespace orient::block {
namespace {

// Pixel size in the results of photos that are measured in the photo system and have no scan.
constexpr double kPixelOfPhotoSystem_mm = 0.01;
// Target accuracy of these, unless the block file states one: a pixel of a usual scan.
constexpr double kTargetInPhotoSystem_mm = 0.03;

// A camera that is to be calibrated displaces image points by so much of its principal distance.
constexpr double kDoubtfulCamera = 1e-3;

// Marks fit their positions in the camera file up to film and scanner errors; confused ones do not.
std::optional<Finding> ConfusedMarks(const std::vector<PointPair2d>& pairs,
                                     const std::vector<std::string>& ids, const Affine2d& fit) {
  constexpr double kMost_mm = 0.3, kSigmas = 5;
  const double pixel_mm = std::sqrt(std::abs(fit.A.determinant()));
  double worst_mm = 0;
  std::string names;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const double off_mm = (fit * pairs[i].source - pairs[i].target).norm();
    if (off_mm <= std::max(kMost_mm, kSigmas * pairs[i].sigma * pixel_mm)) continue;
    worst_mm = std::max(worst_mm, off_mm);
    names += fmt::format("{}{} ({:.2f} mm)", names.empty() ? "" : ", ", ids[i], off_mm);
  }
  if (names.empty()) return std::nullopt;
  if (pairs.size() == 4) names += "; with four marks it is unclear which is wrong";
  return Finding{.reason = Reason::kMeasuredMarksContradict,
                 .at_best = Status::kFailed,
                 .value = worst_mm,
                 .limit = kMost_mm,
                 .where = names};
}

// Marks' clicks and film deformation: one sigma of each mark in the photo system.
std::vector<PointPair2d> WithFilm(std::vector<PointPair2d> pairs, const Affine2d& transform) {
  const double pixel_mm = std::sqrt(std::abs(transform.A.determinant()));
  for (PointPair2d& pair : pairs) pair.sigma = std::hypot(pair.sigma * pixel_mm, kFilmSigma_mm);
  return pairs;
}

double MeanSigma(const std::vector<PointPair2d>& pairs) {
  double sum = 0;
  for (const PointPair2d& pair : pairs) sum += pair.sigma;
  return sum / static_cast<double>(pairs.size());
}

// Stores the film's transform with its covariance. Returns a finding where marks are confused.
std::optional<Finding> SetFilm(const CameraFile& camera, const Measurements& measured,
                               BlockPhoto* photo) {
  RequireKnownMarks(measured, photo->name, camera);
  std::vector<PointPair2d> pairs;
  std::vector<std::string> ids;
  for (const MarkMeasurement& mark : measured.MarksOf(photo->name))
    for (const Fiducial& fiducial : camera.fiducials)
      if (fiducial.id == mark.mark) {
        pairs.push_back({mark.pixel, fiducial.position_mm, mark.sigma_px});
        ids.push_back(mark.mark);
      }
  const auto fit = pairs.size() >= 4 ? FitAffine(pairs) : std::nullopt;
  if (!fit)
    throw InputError(measured.folder + ": photo " + photo->name +
                     " is measured in pixels, but fewer than four of its camera's marks are, or "
                     "they lie on one line; add them to marks.csv");
  const std::vector<PointPair2d> weighted = WithFilm(pairs, fit->transform);
  const TransformFit with_film = FitAffine(weighted).value();
  photo->photo_from_pixel = with_film.transform;
  photo->interior = PooledCovariance(with_film, 1);
  photo->film_sigma_mm = FilmSigma_mm(with_film, 1, MeanSigma(weighted));
  return ConfusedMarks(pairs, ids, with_film.transform);
}

bool IsInPixels(const Measurements& own) { return own.image_points.front().pixel.has_value(); }

// `own`: what was measured in the photo.
BlockPhoto PhotoOf(const CameraFile& camera, const Measurements& own, const std::string& name,
                   std::optional<Finding>* confused) {
  BlockPhoto photo;
  photo.name = name;
  if (camera.camera.kind == CameraKind::kFilm) photo.film_sigma_mm = kFilmSigma_mm;
  if (!IsInPixels(own))
    photo.photo_from_pixel.A = kPixelOfPhotoSystem_mm * PhotoFromPixelAxes(ScanOrientation::kR0);
  else if (camera.camera.kind == CameraKind::kDigital)
    photo.photo_from_pixel = DigitalPhotoFromPixel(camera.camera);
  else
    *confused = SetFilm(camera, own, &photo);
  return photo;
}

// What was measured in a photo and what the adjustment made of it.
struct Seen {
  int used = 0, ties = 0, rejected = 0;
  double redundancy = 0;                          // of the used ones together
  std::vector<double> heights_m;                  // of their ground
  std::vector<exterior::MeasuredPoint> surveyed;  // the used ones that are, as adjusted
  std::vector<double> redundancies;               // of these, mean of both image coordinates
  Matrix6d covariance = Matrix6d::Zero();         // of the adjusted pose, without film bending
  double height_m = 0;                            // of the ground that the photo shows
};

void Add(const AdjustedBlock& adjusted, std::size_t observed, Seen* photo) {
  const ImageObservation& observation = adjusted.block.observations[observed];
  const ObservationResult& result = adjusted.result.observations[observed];
  const AdjustedPoint& point = adjusted.result.points[observation.point];
  const bool wrong = result.state == ObservationState::kRejected || point.control_rejected;
  photo->rejected += wrong ? 1 : 0;
  if (result.state != ObservationState::kUsed) return;
  ++photo->used;
  photo->ties += observation.point < adjusted.ties ? 1 : 0;
  photo->redundancy += result.redundancy;
  photo->heights_m.push_back(point.ground_m.z());
  const auto& control = adjusted.block.points[observation.point].control;
  if (!control || wrong) return;
  const VarianceFactors& factors = adjusted.result.factors;
  const double sigma_px = std::sqrt(observation.covariance_px2.trace() / 2);
  const Eigen::Vector3d variance_m2 = control->covariance_m2.diagonal() * factors.surveyed_ground;
  photo->surveyed.push_back({.name = {},
                             .ground_m = point.ground_m,
                             .sigma_m = variance_m2.cwiseSqrt(),
                             .pixel = observation.pixel,
                             .sigma_px = sigma_px * std::sqrt(factors.measured_image)});
  photo->redundancies.push_back(result.redundancy / 2);
}

std::vector<Seen> SeenIn(const AdjustedBlock& adjusted) {
  std::vector<Seen> seen(adjusted.block.photos.size());
  for (std::size_t i = 0; i < adjusted.block.observations.size(); ++i)
    Add(adjusted, i, &seen[adjusted.block.observations[i].photo]);
  for (std::size_t i = 0; i < adjusted.result.photos.size(); ++i) {
    seen[i].covariance = adjusted.result.photos[i].covariance;
    if (!seen[i].heights_m.empty()) seen[i].height_m = Median(std::move(seen[i].heights_m));
  }
  return seen;
}

// By how much a wrong image point of surveyed ground may displace the photo's projection before it
// shows, pixels.
double HiddenIn(const Seen& seen, const PhotoView& view) {
  exterior::PointPose pose{.position = {}, .pose = view.pose};
  for (std::size_t i = 0; i < seen.surveyed.size(); ++i)
    pose.hidden.push_back(exterior::HiddenBy(view, seen.covariance, seen.surveyed[i],
                                             seen.surveyed.size(), seen.redundancies[i]));
  return exterior::HiddenDisplacement(pose, view, seen.height_m);
}

// Whether the points check one another. Photos with ties enough hang together, as in other blocks;
// others rest on their surveyed points, as where there is no block.
std::optional<Finding> JudgePoints(const Seen& seen, const PhotoView& view, double worst_px,
                                   double wanted_px) {
  const bool hangs = seen.ties >= kLeastTies;
  if (hangs ? seen.redundancy < kLeastTieRedundancy : seen.surveyed.empty())
    return Finding{Reason::kTiesUncontrolled, Status::kWeak, seen.redundancy, kLeastTieRedundancy};
  const Finding alone =
      hangs ? exterior::JudgePointsAlone(seen.used, seen.rejected, worst_px, 0, wanted_px)
            : exterior::JudgePointsAlone(static_cast<int>(seen.surveyed.size()), seen.rejected,
                                         worst_px, HiddenIn(seen, view), wanted_px);
  if (alone.at_best == Status::kOk) return std::nullopt;
  return alone;
}

// As elsewhere, a pose is judged by how precisely it projects the ground, and by whether the points
// check one another.
void Judge(const AdjustedBlock& adjusted, std::size_t i, const Seen& seen, bool in_pixels,
           const MeasuredBlockInputs& inputs, ExteriorResult* result) {
  const double height_m = seen.height_m;
  const PhotoView view = ViewWithGivenFilm(adjusted.block, adjusted.result, i, height_m);
  result->pose = view.pose;
  const double pixel_m = view.GroundPixel(height_m);
  const double worst_px = exterior::WorstProjectionSigma(view, *result->covariance, height_m);
  const double target_px = in_pixels ? 1 : kTargetInPhotoSystem_mm / kPixelOfPhotoSystem_mm;
  result->target_m = inputs.target_m.value_or(target_px * pixel_m);
  result->projection_sigma = exterior::ProjectionSigmaOf(worst_px, pixel_m);
  const double wanted_px = *result->target_m / pixel_m;
  if (!(worst_px <= wanted_px)) {
    result->findings.push_back({.reason = Reason::kPoorlyDetermined,
                                .at_best = Status::kWeak,
                                .value = worst_px,
                                .limit = wanted_px});
    return;
  }
  if (const auto unchecked = JudgePoints(seen, view, worst_px, wanted_px))
    result->findings.push_back(*unchecked);
}

ExteriorResult ResultOf(const AdjustedBlock& adjusted, std::size_t i, const Seen& seen,
                        bool in_pixels, const MeasuredBlockInputs& inputs) {
  const AdjustedPhoto& photo = adjusted.result.photos[i];
  ExteriorResult result;
  result.photo = adjusted.block.photos[i].name;
  if (photo.state != PhotoState::kAdjusted || !adjusted.result.converged) {
    result.findings = {
        adjusted.result.converged
            ? Finding{Reason::kPhotosUndetermined, Status::kFailed, 1, {}, result.photo}
            : Finding{Reason::kBlockNotConverged, Status::kFailed}};
  } else {
    result.covariance = photo.covariance;
    result.ties = TieCount{photo.observations, photo.observations, std::nullopt};
    const BlockPart& part = adjusted.result.parts[static_cast<std::size_t>(photo.part)];
    if (!part.by_control)
      result.findings.push_back({.reason = Reason::kNotConnected,
                                 .at_best = Status::kWeak,
                                 .where = part.finding ? ": " + Sentence(*part.finding) : ""});
    Judge(adjusted, i, seen, in_pixels, inputs, &result);
  }
  result.status = StatusOf(result.findings);
  return result;
}

// Results of the photos that could be adjusted, or have no first pose.
void SetResults(const MeasuredBlockInputs& inputs, const MeasuredPhotos& measured,
                const std::vector<BlockPhoto>& photos, const AdjustedBlock& adjusted,
                const std::vector<Seen>& seen, FirstPoses* first,
                std::map<std::string, ExteriorResult>* results) {
  for (std::size_t i = 0, k = 0; i < photos.size(); ++i) {
    const std::string& name = photos[i].name;
    ExteriorResult& result = (*results)[name];
    if (first->Oriented(i)) {
      result = ResultOf(adjusted, k, seen[k], IsInPixels(measured.at(name)), inputs);
      ++k;
    }
    for (Finding finding : first->Of(name)) {
      if (first->Oriented(i)) finding.at_best = Status::kOk;  // found by other means
      result.findings.push_back(finding);
    }
    ApplyVerdict(inputs.measured, &result);
  }
}

std::vector<std::string> NamesOf(const MeasuredPhotos& measured) {
  std::vector<std::string> names;
  for (const auto& [name, own] : measured) names.push_back(name);
  return names;
}

BlockOptions OptionsOf(const MeasuredBlockInputs& inputs) {
  BlockOptions options;
  options.self_calibration = inputs.self_calibration;
  options.full_covariance = inputs.pose_covariance;
  options.most_photos = static_cast<std::size_t>(inputs.sub_block_photos);
  options.gnss = inputs.known.model;
  options.gnss_shift_sigma_m = kGnssShift_m;
  return options;
}

// Stores a result for every photo: the final one where it is rejected or its marks are confused.
std::vector<BlockPhoto> PhotosToAdjust(const MeasuredBlockInputs& inputs,
                                       const MeasuredPhotos& measured,
                                       std::map<std::string, ExteriorResult>* results) {
  if (measured.empty())
    throw InputError(inputs.measured.folder +
                     " holds no image points: give image_points.csv, or photos and a patch "
                     "database in the block file");
  std::vector<BlockPhoto> photos;
  for (const auto& [name, own] : measured) {
    ExteriorResult& result = (*results)[name];
    result.photo = name;
    if (inputs.measured.DecisionOn(name, DecisionKind::kReject)) {
      ApplyVerdict(inputs.measured, &result);
      continue;
    }
    std::optional<Finding> confused;
    BlockPhoto photo = PhotoOf(inputs.camera, own, name, &confused);
    AddKnown(inputs.known, &photo);
    if (confused)
      exterior::Add(*confused, &result);
    else
      photos.push_back(std::move(photo));
  }
  if (inputs.self_calibration && std::ssize(photos) > inputs.sub_block_photos)
    throw InputError(fmt::format(
        "self_calibration would give each sub-block a camera of its own: {} photos are measured, "
        "more than sub_block_photos = {}",
        photos.size(), inputs.sub_block_photos));
  return photos;
}

}  // namespace

std::size_t RequireAdjustable(const MeasuredBlockInputs& inputs) {
  std::map<std::string, ExteriorResult> results;
  return PhotosToAdjust(inputs, ByPhoto(inputs.measured), &results).size();
}

JudgedBlock AdjustMeasurements(const MeasuredBlockInputs& inputs) {
  MeasuredPhotos measured = ByPhoto(inputs.measured);
  std::map<std::string, ExteriorResult> results;  // by photo
  std::vector<BlockPhoto> photos = PhotosToAdjust(inputs, measured, &results);
  const double camera_sigma_mm =
      inputs.self_calibration ? kDoubtfulCamera * inputs.camera.camera.principal_distance_mm : 0;
  FirstPoses first({inputs.camera.camera, camera_sigma_mm}, inputs.measured.points,
                   inputs.approximations, &measured, &photos);
  JudgedBlock done;
  AdjustedBlock& adjusted = done.adjusted;
  adjusted.by_measurements = true;
  adjusted.block.cameras = {inputs.camera.camera};
  for (std::size_t i = 0; i < photos.size(); ++i)
    if (first.Oriented(i)) adjusted.block.photos.push_back(photos[i]);
  AddMeasuredTies(inputs.measured, &adjusted.block);
  adjusted.ties = adjusted.block.points.size();
  adjusted.surveyed = AddSurveyedPoints(inputs.measured, &adjusted.block);
  if (!adjusted.block.photos.empty())
    adjusted.result = AdjustWholeOrInSubBlocks(adjusted.block, OptionsOf(inputs));
  const std::vector<Seen> seen = SeenIn(adjusted);
  AddFilmBends([&](std::size_t photo) { return seen[photo].height_m; }, &adjusted);
  done.findings = adjusted.result.findings;
  if (auto unknown = UnknownPhotos(inputs.measured, NamesOf(measured)))
    done.findings.push_back(*std::move(unknown));
  SetResults(inputs, measured, photos, adjusted, seen, &first, &results);
  for (auto& [name, result] : results) done.results.push_back(std::move(result));
  for (const BlockPhoto& photo : adjusted.block.photos)
    adjusted.photo_of.push_back(
        static_cast<std::size_t>(std::distance(results.begin(), results.find(photo.name))));
  return done;
}

}  // namespace orient::block
