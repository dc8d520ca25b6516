#include "tools/simulate/block_layout.h"

#include <fmt/format.h>

#include "core/geometry/collinearity.h"

namespace orient::simulation {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

const Vector2d kCentre(512000, 5204000);  // of the block
constexpr double kMeanHeight_m = 250;

Vector2d Turned(const Vector2d& v, double angle_rad) {
  const double c = std::cos(angle_rad), s = std::sin(angle_rad);
  return {c * v.x() - s * v.y(), s * v.x() + c * v.y()};
}

// A photo over `place` (in the strips' axes, from the block's centre), with the unrest of flight.
Pose PoseOver(const Vector2d& place, double strip_rad, double kappa_rad, double height_m,
              double tilt_rad, RandomStream* random) {
  const Vector2d over = kCentre + Turned(place, strip_rad);
  const double drift_m = 0.012 * height_m;
  Pose pose;
  pose.position_m = Vector3d(over.x(), over.y(), kMeanHeight_m + height_m);
  for (int i = 0; i < 3; ++i) pose.position_m[i] += drift_m * random->Gaussian();
  pose.opk_rad = Vector3d(tilt_rad * random->Gaussian(), tilt_rad * random->Gaussian(),
                          NormalizeAngle(kappa_rad + 1.2 * tilt_rad * random->Gaussian()));
  return pose;
}

// Extent of the new block in the strips' axes and its photos.
std::vector<PlannedPhoto> PlanNew(const SimulationOptions& options, const SimulatedCamera& camera,
                                  Vector2d* size_m, RandomStream* random) {
  const double height = FlyingHeight(camera, options.gsd_m);
  const Vector2d footprint =
      camera.file.camera.frame_mm * (height / camera.file.camera.principal_distance_mm);
  const double base = footprint.x() * (1 - options.forward_overlap);
  const double apart = footprint.y() * (1 - options.side_overlap);
  const int per_strip = (options.photos + options.strips - 1) / options.strips;
  *size_m = footprint + Vector2d((per_strip - 1) * base, (options.strips - 1) * apart);
  std::vector<PlannedPhoto> photos;
  for (int i = 0; i < options.photos; ++i) {
    const int strip = i / per_strip, number = i % per_strip;
    const Vector2d place((number - 0.5 * (per_strip - 1)) * base,
                         (strip - 0.5 * (options.strips - 1)) * apart);
    const double strip_rad = RadFromDeg(options.kappa_deg);
    const double kappa = strip_rad + (strip % 2 == 0 ? 0 : RadFromDeg(180));
    photos.push_back(
        {fmt::format("new_{}_{}", strip + 1, number + 1),
         PoseOver(place, strip_rad, kappa, height, RadFromDeg(options.tilt_deg), random)});
  }
  return photos;
}

// How many footprints of `footprint_m` at most `step` of it apart cover `length_m`.
int CountToCover(double length_m, double footprint_m, double step) {
  return 1 +
         std::max(0, static_cast<int>(std::ceil((length_m - footprint_m) / (step * footprint_m))));
}

std::vector<PlannedPhoto> PlanOld(const SimulationOptions& options, const SimulatedCamera& camera,
                                  const Vector2d& size_m, RandomStream* random) {
  const double height = FlyingHeight(camera, options.gsd_m * options.old_gsd_ratio);
  const double footprint =
      camera.file.camera.frame_mm.minCoeff() * height / camera.file.camera.principal_distance_mm;
  // The outermost tenth of the new block may do without.
  const int across = CountToCover(0.92 * size_m.x(), footprint, 0.5);
  const int down = CountToCover(0.92 * size_m.y(), footprint, 0.8);
  const auto spread = [&](int count, double length) {
    return count > 1 ? (0.92 * length - footprint) / (count - 1) : 0.0;
  };
  const double step_x = std::max(spread(across, size_m.x()), 0.15 * footprint);
  const double step_y = std::max(spread(down, size_m.y()), 0.15 * footprint);
  std::vector<PlannedPhoto> photos;
  for (int strip = 0; strip < down; ++strip)
    for (int number = 0; number < across; ++number) {
      const Vector2d place((number - 0.5 * (across - 1)) * step_x,
                           (strip - 0.5 * (down - 1)) * step_y);
      const double strip_rad = RadFromDeg(options.kappa_deg);
      const double kappa = strip_rad + RadFromDeg(options.old_kappa_deg + 180.0 * (strip % 2));
      photos.push_back(
          {fmt::format("old_{}_{}", strip + 1, number + 1),
           PoseOver(place, strip_rad, kappa, height, RadFromDeg(options.tilt_deg), random)});
    }
  return photos;
}

void Include(const Bounds& other, Bounds* bounds) {
  bounds->min_x = std::min(bounds->min_x, other.min_x);
  bounds->min_y = std::min(bounds->min_y, other.min_y);
  bounds->max_x = std::max(bounds->max_x, other.max_x);
  bounds->max_y = std::max(bounds->max_y, other.max_y);
}

}  // namespace

BlockLayout PlanBlock(const SimulationOptions& options, const SimulatedCamera& fresh,
                      const SimulatedCamera& old) {
  RandomStream random(Mix(options.seed + 1000));
  BlockLayout layout;
  layout.mean_height_m = kMeanHeight_m;
  Vector2d size;
  layout.fresh = PlanNew(options, fresh, &size, &random);
  layout.old = PlanOld(options, old, size, &random);
  const double low = kMeanHeight_m - 0.5 * options.relief_m;
  layout.ground = FootprintBounds(fresh.file.camera, layout.fresh, low);
  Include(FootprintBounds(old.file.camera, layout.old, low), &layout.ground);
  const double height = FlyingHeight(fresh, options.gsd_m);
  const double margin = 3 * options.position_error_m +
                        2.5 * height * std::tan(RadFromDeg(options.attitude_error_deg)) +
                        4 * options.dem_cell_m;
  layout.ground = {layout.ground.min_x - margin, layout.ground.min_y - margin,
                   layout.ground.max_x + margin, layout.ground.max_y + margin};
  return layout;
}

Bounds FootprintBounds(const Camera& camera, const std::vector<PlannedPhoto>& photos,
                       double low_m) {
  Bounds bounds{1e12, 1e12, -1e12, -1e12};
  for (const PlannedPhoto& photo : photos)
    for (int side = 0; side < 4; ++side)
      for (int step = 0; step <= 8; ++step) {
        const double along = step / 8.0 - 0.5, edge = side % 2 == 0 ? 0.5 : -0.5;
        const Vector2d share = side < 2 ? Vector2d(along, edge) : Vector2d(edge, along);
        const std::optional<Ray> ray = GroundRayFromPhoto(
            camera, photo.pose, camera.frame_centre_mm + share.cwiseProduct(camera.frame_mm));
        const double reach = (low_m - ray.value().origin_m.z()) / ray->direction.z();
        const Vector3d point = ray->origin_m + reach * ray->direction;
        Include({point.x(), point.y(), point.x(), point.y()}, &bounds);
      }
  return bounds;
}

}  // namespace orient::simulation
