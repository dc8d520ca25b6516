#include "block/stages/measured_block.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "block/inputs/persons_word.h"
#include "core/base/error.h"
#include "core/geometry/intersection.h"
#include "exterior/search/point_resection.h"

namespace orient::block {
namespace {

// Photos measured in the photo system have no scan: a pixel of the results is so large.
constexpr double kPixelOfPhotoSystem_mm = 0.01;

Affine2d FilmTransform(const CameraFile& camera, const Measurements& measured,
                       const std::string& photo, Matrix6d* covariance) {
  RequireKnownMarks(measured, photo, camera);
  std::vector<PointPair2d> pairs;
  for (const MarkMeasurement& mark : measured.MarksOf(photo))
    for (const Fiducial& fiducial : camera.fiducials)
      if (fiducial.id == mark.mark)
        pairs.push_back({mark.pixel, fiducial.position_mm, mark.sigma_px});
  const auto fit = pairs.size() >= 4 ? FitAffine(pairs) : std::nullopt;
  if (!fit)
    throw InputError(measured.folder + ": photo " + photo +
                     " is measured in pixels, but fewer than four of its camera's marks are, or "
                     "they lie on one line; add them to marks.csv");
  *covariance = fit->covariance;
  return fit->transform;
}

BlockPhoto PhotoOf(const CameraFile& camera, const Measurements& measured,
                   const std::string& name) {
  BlockPhoto photo;
  photo.name = name;
  const bool in_pixels = measured.ImagePointsOf(name).front().pixel.has_value();
  if (!in_pixels)
    photo.photo_from_pixel.A = kPixelOfPhotoSystem_mm * PhotoFromPixelAxes(ScanOrientation::kR0);
  else if (camera.camera.kind == CameraKind::kDigital)
    photo.photo_from_pixel = DigitalPhotoFromPixel(camera.camera);
  else
    photo.photo_from_pixel = FilmTransform(camera, measured, name, &photo.interior);
  return photo;
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
    for (std::size_t i = 0; i < photos_.size(); ++i)
      if (const OrientationRow* row = inputs.approximations.Find(photos_[i].name);
          row && !oriented_[i]) {
        photos_[i].approximate = row->pose;
        oriented_[i] = true;
      }
  }

  bool Oriented(std::size_t photo) const { return oriented_[photo]; }
  // Of the photo's resection: wrong points, or why there is no pose.
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

  void Intersect() {
    std::map<std::string, std::vector<PhotoObservation>> seen;
    for (std::size_t i = 0; i < photos_.size(); ++i) {
      if (!oriented_[i]) continue;
      const Affine2d& to_mm = photos_[i].photo_from_pixel;
      const double pixel_mm = std::sqrt(std::abs(to_mm.A.determinant()));
      for (const auto& point : inputs_.measured.ImagePointsOf(photos_[i].name)) {
        const double sigma_mm = point.pixel ? point.sigma * pixel_mm : point.sigma;
        seen[point.point].push_back({&inputs_.camera.camera, photos_[i].approximate,
                                     point.pixel ? to_mm * *point.pixel : *point.photo_mm,
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

  // Intersected from poses that have errors of their own.
  static constexpr double kPosesSigmas = 5;

  const MeasuredBlockInputs& inputs_;
  std::vector<BlockPhoto>& photos_;
  std::vector<bool> oriented_;
  std::map<std::string, GroundPoint> known_;
  std::map<std::string, Findings> findings_;
};

ExteriorResult ResultOf(const AdjustedBlock& adjusted, std::size_t i) {
  const AdjustedPhoto& photo = adjusted.result.photos[i];
  ExteriorResult result;
  result.photo = adjusted.block.photos[i].name;
  if (photo.state != PhotoState::kAdjusted || !adjusted.result.converged) {
    result.findings = {{.reason = adjusted.result.converged ? Reason::kPhotosUndetermined
                                                            : Reason::kBlockNotConverged,
                        .at_best = Status::kFailed,
                        .value = 1,
                        .where = result.photo}};
  } else {
    result.pose = photo.pose;
    result.covariance = photo.covariance;
    result.ties = TieCount{photo.observations, photo.observations, std::nullopt};
    const BlockPart& part = adjusted.result.parts[static_cast<std::size_t>(photo.part)];
    if (!part.by_control)
      result.findings.push_back(
          {.reason = Reason::kTiesUncontrolled, .at_best = Status::kWeak, .value = 1});
  }
  result.status = StatusOf(result.findings);
  return result;
}

BlockOptions OptionsOf(const MeasuredBlockInputs& inputs) {
  BlockOptions options;
  options.self_calibration = inputs.self_calibration;
  options.full_covariance = inputs.pose_covariance;
  return options;
}

}  // namespace

MeasuredBlock AdjustMeasurements(const MeasuredBlockInputs& inputs) {
  std::set<std::string> names;
  for (const auto& seen : inputs.measured.image_points) names.insert(seen.photo);
  if (names.empty())
    throw InputError(inputs.measured.folder +
                     " holds no image points: give image_points.csv, or photos and a patch "
                     "database in the block file");
  std::vector<BlockPhoto> photos;
  for (const std::string& name : names)
    photos.push_back(PhotoOf(inputs.camera, inputs.measured, name));
  FirstPoses first(inputs, &photos);
  MeasuredBlock done;
  AdjustedBlock& adjusted = done.adjusted;
  adjusted.block.cameras = {inputs.camera.camera};
  for (std::size_t i = 0; i < photos.size(); ++i)
    if (first.Oriented(i)) adjusted.block.photos.push_back(photos[i]);
  AddMeasuredTies(inputs.measured, &adjusted.block);
  adjusted.ties = adjusted.block.points.size();
  adjusted.surveyed = AddSurveyedPoints(inputs.measured, &adjusted.block);
  if (!adjusted.block.photos.empty())
    adjusted.result = AdjustBlock(adjusted.block, OptionsOf(inputs));
  done.findings = adjusted.result.findings;
  for (std::size_t i = 0, k = 0; i < photos.size(); ++i) {
    ExteriorResult result;
    result.photo = photos[i].name;
    if (first.Oriented(i)) result = ResultOf(adjusted, k++);
    for (Finding finding : first.Of(photos[i].name)) {
      if (first.Oriented(i)) finding.at_best = Status::kOk;  // found by other means
      result.findings.push_back(finding);
    }
    ApplyVerdict(inputs.measured, &result);
    done.results.push_back(std::move(result));
  }
  return done;
}

}  // namespace orient::block
