// Adjusts three photos from measured points, one of them with a gross error; made up from a truth,
// so that the program can say how far its result is off.
#include <Eigen/Core>
#include <cmath>
#include <cstdio>
#include <random>
#include <string>

#include "block/bundle/adjustment.h"
#include "core/geometry/collinearity.h"

using Eigen::Vector2d, Eigen::Vector3d;
namespace block = orient::block;

constexpr double kSigma_px = 0.3, kGrossError_px = 20;
constexpr double kControl_m = 0.05;  // one sigma of a control point's coordinates

const orient::Pose kTruth[] = {{{0, 0, 1500}, {0.01, -0.02, 0.03}},
                               {{900, 20, 1510}, {-0.02, 0.01, 0.02}},
                               {{1800, -10, 1490}, {0, 0.02, 0.04}}};

block::BlockToAdjust Photos() {
  block::BlockToAdjust b;
  b.cameras.resize(1);
  b.cameras[0].principal_distance_mm = 153;
  b.cameras[0].frame_mm = {230, 230};
  for (const orient::Pose& truth : kTruth) {
    block::BlockPhoto photo;
    photo.name = "photo " + std::to_string(b.photos.size() + 1);
    photo.photo_from_pixel = {Vector2d(0.02, -0.02).asDiagonal(), {-115, 115}};  // 20 um pixels
    photo.approximate.position_m = truth.position_m + Vector3d(5, -5, 5);  // and angles of zero
    b.photos.push_back(photo);
  }
  return b;
}

// Slanting rows of points on hilly ground: every eighth has known coordinates, the others are ties.
void Measure(block::BlockToAdjust* b) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 63; ++i) {
    const double x = -100 + 250 * (i % 9), y = 900 - i * 30;
    const Vector3d ground(x, y, 100 + 40 * std::sin(x / 500) * std::cos(y / 700));
    block::BlockPoint point;
    const Vector3d error_m = kControl_m * Vector3d(normal(random), normal(random), normal(random));
    if (i % 8 == 0)
      point.control = {ground + error_m, Eigen::Matrix3d::Identity() * kControl_m * kControl_m};
    b->points.push_back(point);
    for (std::size_t photo = 0; photo < b->photos.size(); ++photo) {
      const auto photo_mm = orient::PhotoFromGround(b->cameras[0], kTruth[photo], ground);
      if (!photo_mm || !b->cameras[0].InFrame(*photo_mm)) continue;
      const Vector2d pixel = b->photos[photo].photo_from_pixel.Inverse() * *photo_mm;
      const Vector2d noise_px = kSigma_px * Vector2d(normal(random), normal(random));
      b->observations.push_back({photo, b->points.size() - 1, pixel + noise_px,
                                 Eigen::Matrix2d::Identity() * kSigma_px * kSigma_px});
    }
  }
  b->observations[b->observations.size() / 2].pixel.x() += kGrossError_px;
}

int main() {
  block::BlockToAdjust b = Photos();
  Measure(&b);
  const block::BlockResult result = block::AdjustBlock(b);
  std::printf("converged: %d, sigma0 %.3f\n", result.converged, result.sigma0);
  for (std::size_t i = 0; i < b.photos.size(); ++i) {
    const orient::Vector6d pose = result.photos[i].pose.AsVector();
    std::printf("%s, %s\n", b.photos[i].name.c_str(), Name(result.photos[i].state));
    for (int k = 0; k < 6; ++k)  // x y z in metres, omega phi kappa in radians
      std::printf("  %10.5f, sigma %.5f, off by %8.5f\n", pose[k],
                  std::sqrt(result.photos[i].covariance(k, k)), pose[k] - kTruth[i].AsVector()[k]);
  }
  for (std::size_t i = 0; i < b.observations.size(); ++i) {
    const block::ObservationResult& o = result.observations[i];
    std::printf("point %2zu in %s, %s: residual %6.2f %6.2f px\n", b.observations[i].point,
                b.photos[b.observations[i].photo].name.c_str(), Name(o.state), o.residual_px.x(),
                o.residual_px.y());
  }
}
