#include "core/terrain/view_over_ground.h"

#include <Eigen/Dense>
#include <cmath>
#include <utility>

#include "core/base/median.h"

namespace orient {
namespace {

constexpr int kNodes = 6;            // of the frame, each way
constexpr int kHeights = 13;         // of the frame, each way, edges and middle among them
constexpr double kFlattest = -0.05;  // direction down of a ray, of length 1
constexpr double kHorizon = -1e-3;
constexpr int kSteps = 10;
constexpr double kSettledMm = 1e-7;

// `unit`: offset from the frame's centre in units of the frame's size.
Eigen::Vector2d InFrame(const Camera& camera, const Eigen::Vector2d& unit) {
  return camera.frame_centre_mm + unit.cwiseProduct(camera.frame_mm);
}

// Appends what the frame shows at `unit` (frame sizes from its centre), unless the ray points
// higher than `flattest`.
void Look(const Camera& camera, const Pose& pose, const Eigen::Vector2d& unit, double height_m,
          double flattest, std::vector<SeenPlace>* places) {
  const Eigen::Vector2d photo_mm = InFrame(camera, unit);
  const auto ray = GroundRayFromPhoto(camera, pose, photo_mm);
  if (!ray || ray->direction.z() > flattest) return;
  const double reach = (height_m - ray->origin_m.z()) / ray->direction.z();
  places->push_back({photo_mm, ray->origin_m + reach * ray->direction});
}

}  // namespace

std::vector<SeenPlace> PlacesInFrame(const Camera& camera, const Pose& pose, double height_m) {
  std::vector<SeenPlace> places;
  for (int i = 0; i < kNodes * kNodes; ++i) {
    const int col = i % kNodes, row = i / kNodes;
    Look(camera, pose, {(col + 0.5) / kNodes - 0.5, (row + 0.5) / kNodes - 0.5}, height_m,
         kFlattest, &places);
  }
  return places;
}

std::vector<SeenPlace> OutermostInFrame(const Camera& camera, const Pose& pose, double height_m) {
  std::vector<SeenPlace> places;
  for (const double i : {-0.5, 0.0, 0.5})
    for (const double j : {-0.5, 0.0, 0.5}) Look(camera, pose, {i, j}, height_m, kHorizon, &places);
  return places;
}

std::vector<double> HeightsInFrame(const GroundSurface& surface, const Camera& camera,
                                   const Pose& pose) {
  std::vector<double> heights;
  for (int i = 0; i < kHeights * kHeights; ++i) {
    const Eigen::Vector2d unit = Eigen::Vector2d(i % kHeights, i / kHeights) / (kHeights - 1) -
                                 Eigen::Vector2d::Constant(0.5);
    const auto ray = GroundRayFromPhoto(camera, pose, InFrame(camera, unit));
    if (!ray) continue;
    if (const auto ground = surface.Intersect(*ray)) heights.push_back(ground->z());
  }
  return heights;
}

double ShareWithHeights(const GroundSurface& surface, const Camera& camera, const Pose& pose) {
  constexpr int kPlaces = 40;
  int asked = 0, met = 0;
  for (int i = 0; i < kPlaces * kPlaces; ++i) {
    const int col = i % kPlaces, row = i / kPlaces;
    const Eigen::Vector2d unit((col + 0.5) / kPlaces - 0.5, (row + 0.5) / kPlaces - 0.5);
    const auto ray = GroundRayFromPhoto(camera, pose, InFrame(camera, unit));
    if (!ray || ray->direction.z() > kHorizon) continue;
    ++asked;
    met += surface.Intersect(*ray) ? 1 : 0;
  }
  return asked == 0 ? 1 : static_cast<double>(met) / asked;
}

double GroundHeightUnder(const GroundSurface& surface, const Camera& camera, const Pose& pose) {
  if (const auto axis = GroundRayFromPhoto(camera, pose, camera.principal_point_mm))
    if (const auto ground = surface.Intersect(*axis)) return ground->z();
  if (const auto below = surface.HeightAt(pose.position_m.x(), pose.position_m.y())) return *below;
  std::vector<double> heights = HeightsInFrame(surface, camera, pose);
  return heights.empty() ? surface.MeanHeight() : Median(std::move(heights));
}

std::optional<Pose> PoseShowingTheSame(const PhotoView& view, const PhotoView& with,
                                       double height_m) {
  const std::vector<SeenPlace> places = PlacesInFrame(view.camera, view.pose, height_m);
  if (places.size() < 4) return std::nullopt;
  Pose pose = view.pose;
  // Metres and radians scaled alike, so that the normal equations are well conditioned.
  const double distance = std::max(1.0, std::abs(pose.position_m.z() - height_m));
  Vector6d unit = Vector6d::Ones();
  unit.head<3>().setConstant(distance);
  for (int step = 0; step < kSteps; ++step) {
    Matrix6d normal = Matrix6d::Zero();
    Vector6d right = Vector6d::Zero();
    for (const SeenPlace& place : places) {
      const auto now = PhotoFromGroundWithDerivatives(with.camera, pose, place.ground_m);
      if (!now) return std::nullopt;
      const Eigen::Matrix<double, 2, 6> rows = now->by_pose * unit.asDiagonal();
      normal += rows.transpose() * rows;
      right += rows.transpose() *
               (with.PhotoFromPixel(view.PixelFromPhoto(place.photo_mm)) - now->photo_mm);
    }
    const Vector6d change = unit.cwiseProduct(normal.ldlt().solve(right));
    pose = Pose::FromVector(pose.AsVector() + change);
    if (change.cwiseQuotient(unit).norm() * with.camera.principal_distance_mm < kSettledMm) break;
  }
  return pose;
}

}  // namespace orient
