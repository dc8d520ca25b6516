#include "tools/simulate/photo_rendering.h"

#include <tbb/parallel_for.h>

#include "core/geometry/collinearity.h"

namespace orient::simulation {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kMesh = 8;  // pixels between exactly computed rays; between them rays are linear
constexpr float kWallShare = 0.55f;  // of the roof's tone
constexpr double kWallStep_m = 0.6;  // a hit this far below the top is a wall

struct Node {
  Vector2d photo_mm;
  RaySlope slope;
};

Node operator+(const Node& a, const Node& b) {
  return {a.photo_mm + b.photo_mm, {a.slope.east + b.slope.east, a.slope.north + b.slope.north}};
}
Node operator*(double f, const Node& a) {
  return {f * a.photo_mm, {f * a.slope.east, f * a.slope.north}};
}

class PhotoRenderer {
 public:
  PhotoRenderer(const Camera& camera, const Pose& pose, const ScanGeometry& scan,
                const GroundRaster& ground, const Terrain& terrain, double margin_mm)
      : camera_(camera),
        pose_(pose),
        scan_(scan),
        ground_(ground),
        terrain_(terrain),
        margin_mm_(margin_mm) {
    for (const std::uint16_t tallest : ground.tallest_cm)
      tallest_m_ = std::max(tallest_m_, 0.01 * tallest);
  }

  void RenderBand(int first_row, Image* image) const;

 private:
  Node NodeAt(int col, int row) const;
  float PixelTone(const RaySlope& slope, const RaySlope& per_col, const RaySlope& per_row,
                  double* height) const;
  // The first thing that a ray meets above its ground point, if any, and how far below the top.
  bool MeetObject(const Vector3d& ground_point, const RaySlope& slope, Vector3d* hit,
                  double* below_top) const;

  const Camera& camera_;
  const Pose& pose_;
  const ScanGeometry& scan_;
  const GroundRaster& ground_;
  const Terrain& terrain_;
  double margin_mm_;
  double tallest_m_ = 0;  // of all objects
};

Node PhotoRenderer::NodeAt(int col, int row) const {
  Node node;
  node.photo_mm = scan_.PhotoFromPixel(Vector2d(col + 0.5, row + 0.5));
  const std::optional<Ray> ray = GroundRayFromPhoto(camera_, pose_, node.photo_mm);
  if (!ray) return node;  // far outside the frame, where the lens model folds over
  const Vector3d& d = ray->direction;
  node.slope = {d.x() / -d.z(), d.y() / -d.z()};
  return node;
}

bool PhotoRenderer::MeetObject(const Vector3d& ground_point, const RaySlope& slope, Vector3d* hit,
                               double* below_top) const {
  const double tilt = std::hypot(slope.east, slope.north);
  double top = tallest_m_;
  // Lower objects are met only nearer to the ground point: look again in a smaller area.
  for (int round = 0; round < 2 && top > 0; ++round)
    top = ground_.TallestNear(ground_point.x(), ground_point.y(), top * tilt);
  if (top <= 0) return false;
  top += 0.01;
  const int steps = 1 + static_cast<int>(top * tilt / (0.7 * ground_.cell));
  // Height of the ray above the surface `above` metres over its ground point; on bare ground the
  // ray counts as clear, however near.
  Vector3d at;
  const auto clearance = [&](double above) {
    at = {ground_point.x() - slope.east * above, ground_point.y() - slope.north * above,
          ground_point.z() + above};
    const auto object = static_cast<double>(ground_.ObjectAt(at.x(), at.y()));
    return object <= 0 ? 1.0 : at.z() - terrain_.HeightAt(at.x(), at.y()) - object;
  };
  double over = top;  // the lowest place known to be clear
  for (int step = 0; step <= steps; ++step) {
    double under = top * (1 - static_cast<double>(step) / steps);
    if (clearance(under) > 0) {
      over = under;
      continue;
    }
    for (int halving = 0; halving < 8; ++halving) {
      const double middle = 0.5 * (over + under);
      (clearance(middle) > 0 ? over : under) = middle;
    }
    *below_top = -clearance(under);
    *hit = at;
    return true;
  }
  return false;
}

float PhotoRenderer::PixelTone(const RaySlope& slope, const RaySlope& per_col,
                               const RaySlope& per_row, double* height) const {
  Vector3d point = MeetGround(terrain_, pose_.position_m, slope, *height);
  *height = point.z();
  double below_top = 0;
  float share = 1;
  if (MeetObject(point, slope, &point, &below_top) && below_top > kWallStep_m) share = kWallShare;
  // Four samples per pixel; the raster's bilinear interpolation fills the area between them.
  const double depth = pose_.position_m.z() - point.z();
  float sum = 0;
  for (const double dc : {-0.25, 0.25})
    for (const double dr : {-0.25, 0.25})
      sum += ground_.ToneAt(point.x() + depth * (dc * per_col.east + dr * per_row.east),
                            point.y() + depth * (dc * per_col.north + dr * per_row.north));
  return 0.25f * share * sum;
}

void PhotoRenderer::RenderBand(int first_row, Image* image) const {
  const int nodes = (image->width + kMesh - 1) / kMesh + 1;
  std::vector<Node> top, bottom;
  for (int node = 0; node < nodes; ++node) {
    top.push_back(NodeAt(node * kMesh, first_row));
    bottom.push_back(NodeAt(node * kMesh, first_row + kMesh));
  }
  const int last_row = std::min(first_row + kMesh, image->height);
  double height = terrain_.MinHeight();
  for (int row = first_row; row < last_row; ++row) {
    const double f = static_cast<double>(row - first_row) / kMesh;
    for (int col = 0; col < image->width; ++col) {
      const auto cell = static_cast<size_t>(col / kMesh);
      const double e = static_cast<double>(col % kMesh) / kMesh;
      const Node left = (1 - f) * top[cell] + f * bottom[cell];
      const Node right = (1 - f) * top[cell + 1] + f * bottom[cell + 1];
      const Node here = (1 - e) * left + e * right;
      if (!camera_.InFrame(here.photo_mm, margin_mm_)) continue;
      const Node per_col = (1.0 / kMesh) * (right + (-1.0) * left);
      const Node per_row = (1.0 / kMesh) * (bottom[cell] + (-1.0) * top[cell]);
      const double off_axis =
          (here.photo_mm - camera_.principal_point_mm).norm() / camera_.principal_distance_mm;
      const auto fall_off = static_cast<float>(1 / (1 + 0.7 * off_axis * off_axis));
      image->At(col, row) = fall_off * PixelTone(here.slope, per_col.slope, per_row.slope, &height);
    }
  }
}

}  // namespace

Vector3d MeetGround(const Terrain& terrain, const Vector3d& centre, const RaySlope& slope,
                    double start_height) {
  constexpr double kPrecision_m = 0.0005;
  double z = start_height;
  for (int round = 0; round < 60; ++round) {
    const double depth = centre.z() - z;
    const double x = centre.x() + slope.east * depth, y = centre.y() + slope.north * depth;
    const double ground = terrain.HeightAt(x, y);
    const bool close = std::abs(ground - z) < kPrecision_m;
    z = ground;
    if (close) break;
  }
  const double depth = centre.z() - z;
  return {centre.x() + slope.east * depth, centre.y() + slope.north * depth, z};
}

Image RenderPhoto(const Camera& camera, const Pose& pose, const ScanGeometry& scan,
                  const GroundRaster& ground, const Terrain& terrain, double margin_mm) {
  Image image(scan.Setup().width, scan.Setup().height, 0.0f);
  const PhotoRenderer renderer(camera, pose, scan, ground, terrain, margin_mm);
  const int bands = (image.height + kMesh - 1) / kMesh;
  tbb::parallel_for(0, bands, [&](int band) { renderer.RenderBand(band * kMesh, &image); });
  return image;
}

}  // namespace orient::simulation
