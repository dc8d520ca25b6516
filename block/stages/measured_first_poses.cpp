#include "block/stages/measured_first_poses.h"

#include <Eigen/LU>
#include <cmath>
#include <set>

#include "block/inputs/measurement_inputs.h"
#include "block/stages/kappa_start.h"
#include "core/geometry/intersection.h"
#include "exterior/search/point_resection.h"

namespace orient::block {
namespace {

// Factor on the sigmas of points intersected from poses, which have errors of their own.
constexpr double kPosesSigmas = 5;

// Film and camera displace all points of a photo. Here each point gets that error as one of its
// own, so that none is rejected for it; the adjustment models it.
void AddSystematic(const BlockPhoto& photo, double camera_sigma_mm,
                   std::vector<exterior::MeasuredPoint>* points) {
  const double pixel_mm = std::sqrt(std::abs(photo.photo_from_pixel.A.determinant()));
  TransformFit film;
  film.transform = photo.photo_from_pixel;
  film.covariance = photo.interior;
  for (exterior::MeasuredPoint& point : *points) {
    const double transform_mm2 = film.CovarianceAt(point.pixel).trace() / 2;
    point.sigma_px =
        std::sqrt(point.sigma_px * point.sigma_px +
                  (std::max(transform_mm2, 0.0) + photo.film_sigma_mm * photo.film_sigma_mm +
                   camera_sigma_mm * camera_sigma_mm) /
                      (pixel_mm * pixel_mm));
  }
}

}  // namespace

MeasuredPhotos ByPhoto(const Measurements& measured) {
  MeasuredPhotos photos;
  for (const ImagePointMeasurement& point : measured.image_points)
    photos[point.photo].image_points.push_back(point);
  for (const MarkMeasurement& mark : measured.marks)
    if (const auto photo = photos.find(mark.photo); photo != photos.end())
      photo->second.marks.push_back(mark);
  for (auto& [name, photo] : photos) photo.folder = measured.folder;
  return photos;
}

Eigen::Vector2d InPhoto(const BlockPhoto& photo, const ImagePointMeasurement& point) {
  return point.pixel ? photo.photo_from_pixel * *point.pixel : *point.photo_mm;
}

FirstPoses::FirstPoses(const StartingCamera& camera, const std::vector<GroundPoint>& surveyed,
                       const std::vector<OrientationRow>& approximations, MeasuredPhotos* measured,
                       std::vector<BlockPhoto>* photos)
    : camera_(camera), measured_(*measured), photos_(*photos), oriented_(photos->size(), false) {
  for (const GroundPoint& point : surveyed)
    if (point.role == PointRole::kControl) known_[point.name] = point;
  for (bool more = true; more;) {
    more = false;
    for (std::size_t i = 0; i < photos_.size(); ++i) more = Resect(i) || more;
    if (more) Intersect();
  }
  TakeApproximations(approximations);
}

bool FirstPoses::Resect(std::size_t i) {
  if (oriented_[i]) return false;
  BlockPhoto& photo = photos_[i];
  Measurements& own = measured_.at(photo.name);
  std::set<std::string> named;
  own.points.clear();
  for (const ImagePointMeasurement& seen : own.image_points)
    if (const auto point = known_.find(seen.point);
        point != known_.end() && named.insert(seen.point).second)
      own.points.push_back(point->second);
  exterior::FilmPosition position;
  position.photo_from_pixel = photo.photo_from_pixel;
  std::vector<exterior::MeasuredPoint> points = PointsOf(own, photo.name, position);
  AddSystematic(photo, camera_.sigma_mm, &points);
  const exterior::PointResection answer =
      exterior::ResectByPoints(camera_.camera, {position}, std::nullopt, points);
  findings_[photo.name] = answer.findings;
  if (!answer.found) return false;
  photo.approximate = answer.found->pose;
  oriented_[i] = true;
  return true;
}

// Takes approximations for the other photos. Without an attitude, kappa follows from the photo's
// points and all known positions.
void FirstPoses::TakeApproximations(const std::vector<OrientationRow>& approximations) {
  std::map<std::string, const OrientationRow*> rows;
  for (const OrientationRow& row : approximations) rows[row.photo] = &row;
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

std::vector<std::optional<double>> FirstPoses::KappasOf(
    const std::vector<std::size_t>& placed) const {
  std::vector<LevelPhoto> level;
  for (const std::size_t i : placed) {
    level.push_back({photos_[i].approximate.position_m.head<2>(), {}});
    for (const ImagePointMeasurement& point : PointsIn(i))
      level.back().seen_mm[point.point] =
          InPhoto(photos_[i], point) - camera_.camera.principal_point_mm;
  }
  std::map<std::string, Eigen::Vector2d> ground_m;
  for (const auto& [name, point] : known_) ground_m[name] = point.ground_m.head<2>();
  return KappasByPlaces(level, ground_m);
}

void FirstPoses::Intersect() {
  std::map<std::string, std::vector<PhotoObservation>> seen;
  for (std::size_t i = 0; i < photos_.size(); ++i) {
    if (!oriented_[i]) continue;
    const double pixel_mm = std::sqrt(std::abs(photos_[i].photo_from_pixel.A.determinant()));
    for (const ImagePointMeasurement& point : PointsIn(i)) {
      if (known_.contains(point.point)) continue;
      const double sigma_mm = point.pixel ? point.sigma * pixel_mm : point.sigma;
      seen[point.point].push_back({&camera_.camera, photos_[i].approximate,
                                   InPhoto(photos_[i], point),
                                   sigma_mm * sigma_mm * Eigen::Matrix2d::Identity()});
    }
  }
  for (const auto& [name, photos] : seen) {
    if (photos.size() < 2) continue;
    if (const auto met = IntersectPhotos(photos))
      known_[name] = {name, met->ground_m, kPosesSigmas * met->covariance_m2.diagonal().cwiseSqrt(),
                      PointRole::kControl};
  }
}

}  // namespace orient::block
