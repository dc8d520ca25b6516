#include "block/stages/measured_block.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "block/bundle/sub_blocks.h"
#include "block/inputs/measurement_inputs.h"
#include "block/stages/kappa_start.h"
#include "core/base/error.h"
#include "core/base/median.h"
#include "core/geometry/intersection.h"
#include "exterior/judge.h"
#include "exterior/search/point_resection.h"
#include "exterior/steps/resect.h"

namespace orient::block {
namespace {

// Pixel size in the results of photos that are measured in the photo system and have no scan.
constexpr double kPixelOfPhotoSystem_mm = 0.01;
// Target accuracy of these, unless the block file states one: a pixel of a usual scan.
constexpr double kTargetInPhotoSystem_mm = 0.03;

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

Affine2d FilmTransform(const CameraFile& camera, const Measurements& measured,
                       const std::string& photo, Matrix6d* covariance,
                       std::optional<Finding>* confused) {
  RequireKnownMarks(measured, photo, camera);
  std::vector<PointPair2d> pairs;
  std::vector<std::string> ids;
  for (const MarkMeasurement& mark : measured.MarksOf(photo))
    for (const Fiducial& fiducial : camera.fiducials)
      if (fiducial.id == mark.mark) {
        pairs.push_back({mark.pixel, fiducial.position_mm, mark.sigma_px});
        ids.push_back(mark.mark);
      }
  const auto fit = pairs.size() >= 4 ? FitAffine(pairs) : std::nullopt;
  if (!fit)
    throw InputError(measured.folder + ": photo " + photo +
                     " is measured in pixels, but fewer than four of its camera's marks are, or "
                     "they lie on one line; add them to marks.csv");
  *covariance = fit->covariance;
  *confused = ConfusedMarks(pairs, ids, fit->transform);
  return fit->transform;
}

BlockPhoto PhotoOf(const CameraFile& camera, const Measurements& measured, const std::string& name,
                   std::optional<Finding>* confused) {
  BlockPhoto photo;
  photo.name = name;
  const bool in_pixels = measured.ImagePointsOf(name).front().pixel.has_value();
  if (!in_pixels)
    photo.photo_from_pixel.A = kPixelOfPhotoSystem_mm * PhotoFromPixelAxes(ScanOrientation::kR0);
  else if (camera.camera.kind == CameraKind::kDigital)
    photo.photo_from_pixel = DigitalPhotoFromPixel(camera.camera);
  else
    photo.photo_from_pixel = FilmTransform(camera, measured, name, &photo.interior, confused);
  return photo;
}

// In the photo system, mm.
Eigen::Vector2d InPhoto(const BlockPhoto& photo, const ImagePointMeasurement& point) {
  return point.pixel ? photo.photo_from_pixel * *point.pixel : *point.photo_mm;
}

// Poses and ground points that follow from one another, beginning with surveyed points.
class FirstPoses {
 public:
  FirstPoses(const MeasuredBlockInputs& inputs, std::vector<BlockPhoto>* photos)
      : inputs_(inputs), photos_(*photos), oriented_(photos->size(), false) {
    for (const GroundPoint& point : inputs.measured.points)
      if (point.role == PointRole::kControl) known_[point.name] = point;
    for (bool more = true; more;) {
      more = false;
      for (std::size_t i = 0; i < photos_.size(); ++i) more = Resect(i) || more;
      if (more) Intersect();
    }
    TakeApproximations();
  }

  bool Oriented(std::size_t photo) const { return oriented_[photo]; }
  // Findings of the photo's resection: wrong points, or why there is no pose.
  const Findings& Of(const std::string& photo) { return findings_[photo]; }

 private:
  bool Resect(std::size_t i) {
    if (oriented_[i]) return false;
    BlockPhoto& photo = photos_[i];
    Measurements known = inputs_.measured;
    known.points.clear();
    for (const auto& [name, point] : known_) known.points.push_back(point);
    exterior::FilmPosition position;
    position.photo_from_pixel = photo.photo_from_pixel;
    const exterior::PointResection answer = exterior::ResectByPoints(
        inputs_.camera.camera, {position}, std::nullopt, PointsOf(known, photo.name, position));
    findings_[photo.name] = answer.findings;
    if (!answer.found) return false;
    photo.approximate = answer.found->pose;
    oriented_[i] = true;
    return true;
  }

  // Takes approximations for the other photos. Without an attitude, kappa follows from the photo's
  // points and all known positions.
  void TakeApproximations() {
    std::map<std::string, const OrientationRow*> rows;
    for (const OrientationRow& row : inputs_.approximations) rows[row.photo] = &row;
    std::vector<std::size_t> placed, turned;  // the latter index the former
    for (std::size_t i = 0; i < photos_.size(); ++i) {
      const auto row = rows.find(photos_[i].name);
      if (!oriented_[i] && row == rows.end()) continue;
      if (!oriented_[i]) {
        photos_[i].approximate = row->second->pose;
        oriented_[i] = row->second->attitude_known;
        if (!oriented_[i]) turned.push_back(placed.size());
      }
      placed.push_back(i);
    }
    if (turned.empty()) return;
    const auto kappas = KappasOf(placed);
    for (const std::size_t k : turned) {
      if (!kappas[k]) continue;
      photos_[placed[k]].approximate.opk_rad[2] = *kappas[k];
      oriented_[placed[k]] = true;
    }
  }

  std::vector<std::optional<double>> KappasOf(const std::vector<std::size_t>& placed) const {
    std::vector<LevelPhoto> level;
    for (const std::size_t i : placed) {
      level.push_back({photos_[i].approximate.position_m.head<2>(), {}});
      for (const auto& point : inputs_.measured.ImagePointsOf(photos_[i].name))
        level.back().seen_mm[point.point] =
            InPhoto(photos_[i], point) - inputs_.camera.camera.principal_point_mm;
    }
    std::map<std::string, Eigen::Vector2d> ground_m;
    for (const auto& [name, point] : known_) ground_m[name] = point.ground_m.head<2>();
    return KappasByPlaces(level, ground_m);
  }

  void Intersect() {
    std::map<std::string, std::vector<PhotoObservation>> seen;
    for (std::size_t i = 0; i < photos_.size(); ++i) {
      if (!oriented_[i]) continue;
      const double pixel_mm = std::sqrt(std::abs(photos_[i].photo_from_pixel.A.determinant()));
      for (const auto& point : inputs_.measured.ImagePointsOf(photos_[i].name)) {
        const double sigma_mm = point.pixel ? point.sigma * pixel_mm : point.sigma;
        seen[point.point].push_back({&inputs_.camera.camera, photos_[i].approximate,
                                     InPhoto(photos_[i], point),
                                     sigma_mm * sigma_mm * Eigen::Matrix2d::Identity()});
      }
    }
    for (const auto& [name, photos] : seen) {
      if (known_.contains(name) || photos.size() < 2) continue;
      if (const auto met = IntersectPhotos(photos))
        known_[name] = {name, met->ground_m,
                        kPosesSigmas * met->covariance_m2.diagonal().cwiseSqrt(),
                        PointRole::kControl};
    }
  }

  // Factor on the sigmas of points intersected from poses, which have errors of their own.
  static constexpr double kPosesSigmas = 5;

  const MeasuredBlockInputs& inputs_;
  std::vector<BlockPhoto>& photos_;
  std::vector<bool> oriented_;
  std::map<std::string, GroundPoint> known_;
  std::map<std::string, Findings> findings_;
};

// Median height of the adjusted points.
double MedianHeight(const AdjustedBlock& adjusted) {
  std::vector<double> heights;
  for (const AdjustedPoint& point : adjusted.result.points)
    if (point.adjusted) heights.push_back(point.ground_m.z());
  return heights.empty() ? 0 : Median(std::move(heights));
}

// As elsewhere, a pose is judged by how precisely it projects the ground.
void JudgePrecision(const AdjustedBlock& adjusted, std::size_t i, const MeasuredBlockInputs& inputs,
                    ExteriorResult* result) {
  const BlockPhoto& photo = adjusted.block.photos[i];
  const PhotoView view{adjusted.block.cameras.front(), photo.photo_from_pixel, *result->pose,
                       photo.film_correction};
  const double height_m = MedianHeight(adjusted), pixel_m = view.GroundPixel(height_m);
  const double worst_px = exterior::WorstProjectionSigma(view, *result->covariance, height_m);
  const bool scanned = inputs.measured.ImagePointsOf(photo.name).front().pixel.has_value();
  const double target_px = scanned ? 1 : kTargetInPhotoSystem_mm / kPixelOfPhotoSystem_mm;
  result->target_m = inputs.target_m.value_or(target_px * pixel_m);
  result->projection_sigma = exterior::ProjectionSigmaOf(worst_px, pixel_m);
  if (!(worst_px <= *result->target_m / pixel_m))
    result->findings.push_back({.reason = Reason::kPoorlyDetermined,
                                .at_best = Status::kWeak,
                                .value = worst_px,
                                .limit = *result->target_m / pixel_m});
}

ExteriorResult ResultOf(const AdjustedBlock& adjusted, std::size_t i,
                        const MeasuredBlockInputs& inputs) {
  const AdjustedPhoto& photo = adjusted.result.photos[i];
  ExteriorResult result;
  result.photo = adjusted.block.photos[i].name;
  if (photo.state != PhotoState::kAdjusted || !adjusted.result.converged) {
    result.findings = {
        adjusted.result.converged
            ? Finding{Reason::kPhotosUndetermined, Status::kFailed, 1, {}, result.photo}
            : Finding{Reason::kBlockNotConverged, Status::kFailed}};
  } else {
    result.pose = photo.pose;
    result.covariance = photo.covariance;
    result.ties = TieCount{photo.observations, photo.observations, std::nullopt};
    const BlockPart& part = adjusted.result.parts[static_cast<std::size_t>(photo.part)];
    if (!part.by_control)
      result.findings.push_back({.reason = Reason::kNotConnected,
                                 .at_best = Status::kWeak,
                                 .where = part.finding ? ": " + Sentence(*part.finding) : ""});
    JudgePrecision(adjusted, i, inputs, &result);
  }
  result.status = StatusOf(result.findings);
  return result;
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

}  // namespace

JudgedBlock AdjustMeasurements(const MeasuredBlockInputs& inputs) {
  std::set<std::string> names;
  for (const auto& seen : inputs.measured.image_points) names.insert(seen.photo);
  if (names.empty())
    throw InputError(inputs.measured.folder +
                     " holds no image points: give image_points.csv, or photos and a patch "
                     "database in the block file");
  std::vector<BlockPhoto> photos;
  std::map<std::string, ExteriorResult> results;  // by photo
  for (const std::string& name : names) {
    ExteriorResult& result = results[name];
    result.photo = name;
    if (inputs.measured.DecisionOn(name, DecisionKind::kReject)) {
      ApplyVerdict(inputs.measured, &result);
      continue;
    }
    std::optional<Finding> confused;
    photos.push_back(PhotoOf(inputs.camera, inputs.measured, name, &confused));
    AddKnown(inputs.known, &photos.back());
    if (!confused) continue;
    photos.pop_back();
    exterior::Add(*confused, &result);
  }
  FirstPoses first(inputs, &photos);
  JudgedBlock done;
  AdjustedBlock& adjusted = done.adjusted;
  adjusted.block.cameras = {inputs.camera.camera};
  for (std::size_t i = 0; i < photos.size(); ++i)
    if (first.Oriented(i)) adjusted.block.photos.push_back(photos[i]);
  AddMeasuredTies(inputs.measured, &adjusted.block);
  adjusted.ties = adjusted.block.points.size();
  adjusted.surveyed = AddSurveyedPoints(inputs.measured, &adjusted.block);
  if (inputs.self_calibration && std::ssize(adjusted.block.photos) > inputs.sub_block_photos)
    throw InputError(fmt::format(
        "self_calibration would give each sub-block a camera of its own: {} photos are measured, "
        "more than sub_block_photos = {}",
        adjusted.block.photos.size(), inputs.sub_block_photos));
  if (!adjusted.block.photos.empty())
    adjusted.result = AdjustWholeOrInSubBlocks(adjusted.block, OptionsOf(inputs));
  done.findings = adjusted.result.findings;
  if (auto unknown = UnknownPhotos(inputs.measured, {names.begin(), names.end()}))
    done.findings.push_back(*std::move(unknown));
  for (std::size_t i = 0, k = 0; i < photos.size(); ++i) {
    ExteriorResult& result = results[photos[i].name];
    if (first.Oriented(i)) result = ResultOf(adjusted, k++, inputs);
    for (Finding finding : first.Of(photos[i].name)) {
      if (first.Oriented(i)) finding.at_best = Status::kOk;  // found by other means
      result.findings.push_back(finding);
    }
    ApplyVerdict(inputs.measured, &result);
  }
  for (auto& [name, result] : results) done.results.push_back(std::move(result));
  return done;
}

}  // namespace orient::block
