#include "exterior/steps/predict.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "core/terrain/pixel_derivatives.h"
#include "patchdb/store/learning.h"

namespace orient::exterior {
namespace {

bool Inside(const Eigen::Vector2d& pixel, const PredictionOptions& options) {
  return pixel.x() >= options.border_px && pixel.y() >= options.border_px &&
         pixel.x() <= options.width_px - options.border_px &&
         pixel.y() <= options.height_px - options.border_px;
}

// Ranks by what earlier attempts have shown, then by distinctness, or a medium value if that is
// unknown. A new patch ranks with those that did as expected.
std::pair<double, double> Rank(const patchdb::Patch& patch) {
  const double taught =
      patchdb::BeliefOf(patch).Mean() - patchdb::BeliefOf(patch.quality, {}).Mean();
  return {taught, patch.distinctness.value_or(0.5)};
}

bool Covered(const Eigen::Vector2d& photo_mm, double border_mm, const PredictionOptions& options) {
  return std::any_of(options.covered.begin(), options.covered.end(), [&](const CoveredArea& area) {
    return ((photo_mm - area.from_mm).array() > -border_mm).all() &&
           ((area.to_mm - photo_mm).array() > -border_mm).all();
  });
}

// Why a patch's ground point, projected under the pose, is not visible; empty if it is.
std::optional<Unseen> WhyNotSeen(const PhotoView& view, const Matrix6d& pose_covariance,
                                 const Eigen::Vector3d& ground_m,
                                 const std::optional<PixelDerivatives>& projection,
                                 const PredictionOptions& options) {
  const double border_mm = options.border_px * view.PixelSize();
  if (!projection) {
    // Behind the camera, or so far outside the frame that the lens model has folded over.
    const Eigen::Vector3d axis = -view.pose.GroundFromPhoto().col(2);
    const bool behind = axis.dot(ground_m - view.pose.position_m) <= 0;
    return behind ? Unseen::kBehindCamera : Unseen::kOutsidePhoto;
  }
  if (!view.camera.InFrame(projection->photo_mm, -border_mm) ||
      !Inside(view.PixelFromPhoto(projection->photo_mm), options))
    return Unseen::kOutsidePhoto;
  if (Covered(projection->photo_mm, border_mm, options)) return Unseen::kCovered;
  if (options.surface != nullptr &&
      HiddenByTerrain(*options.surface, view.pose.position_m, pose_covariance.topLeftCorner<3, 3>(),
                      ground_m))
    return Unseen::kHidden;
  return std::nullopt;
}

}  // namespace

std::vector<PatchPrediction> Predict(const PhotoView& view, const Matrix6d& pose_covariance,
                                     const std::vector<patchdb::Patch>& patches,
                                     const PredictionOptions& options,
                                     std::vector<UnseenPatch>* not_visible) {
  std::vector<PatchPrediction> predictions;
  for (std::size_t i = 0; i < patches.size(); ++i) {
    const auto projection = PixelFromGroundWithDerivatives(view, patches[i].ground_m);
    const auto unseen = WhyNotSeen(view, pose_covariance, patches[i].ground_m, projection, options);
    if (unseen || !projection) {
      if (not_visible != nullptr) not_visible->push_back({i, *unseen});
      continue;
    }
    const auto& by_pose = projection->by_pose;
    const auto& by_ground = projection->by_ground;
    PatchPrediction prediction;
    prediction.patch = i;
    prediction.pixel = view.PixelFromPhoto(projection->photo_mm);
    prediction.covariance_px2 = by_pose * pose_covariance * by_pose.transpose() +
                                by_ground * patches[i].covariance_m2 * by_ground.transpose();
    predictions.push_back(prediction);
  }
  return predictions;
}

std::vector<PatchPrediction> SelectSpread(const std::vector<PatchPrediction>& predictions,
                                          const std::vector<patchdb::Patch>& patches, int count,
                                          const PredictionOptions& options) {
  if (static_cast<int>(predictions.size()) <= count) return predictions;
  const double cell_px =
      std::sqrt(static_cast<double>(options.width_px) * options.height_px / std::max(count, 1));
  std::map<std::pair<int, int>, std::vector<PatchPrediction>> cells;
  for (const PatchPrediction& p : predictions)
    cells[{static_cast<int>(p.pixel.x() / cell_px), static_cast<int>(p.pixel.y() / cell_px)}]
        .push_back(p);
  for (auto& [cell, members] : cells)
    std::stable_sort(members.begin(), members.end(), [&](const auto& a, const auto& b) {
      return Rank(patches[a.patch]) > Rank(patches[b.patch]);
    });
  // The best of every cell, then the second best, until there are enough; of the last rank only as
  // many as are wanted, spread over the photo.
  std::vector<PatchPrediction> selected;
  const auto wanted = static_cast<std::size_t>(count);
  for (std::size_t turn = 0; selected.size() < wanted; ++turn) {
    std::vector<PatchPrediction> next;
    for (const auto& [cell, members] : cells)
      if (turn < members.size()) next.push_back(members[turn]);
    const std::size_t taken = std::min(next.size(), wanted - selected.size());
    for (std::size_t i = 0; i < taken; ++i) selected.push_back(next[i * next.size() / taken]);
  }
  return selected;
}

Bounds UncertainFootprint(const Camera& camera, const PosePrior& prior, double min_height_m,
                          double max_height_m, double k) {
  // The frame is enlarged by how far the attitude's uncertainty moves its edge; the position's is
  // added on the ground. Rays near or above the horizon contribute nothing.
  const double attitude = k * std::sqrt(prior.covariance.diagonal().segment<2>(3).maxCoeff());
  const double turn = k * std::sqrt(prior.covariance(5, 5));
  const double grow =
      std::tan(std::min(attitude, 0.7)) * (camera.principal_distance_mm + camera.FrameRadius());
  Camera ideal = camera;
  ideal.lens = {};  // its inverse need not exist so far outside the frame
  const double turned = std::sin(std::min(turn, std::numbers::pi / 2)) * camera.FrameRadius();
  const Eigen::Vector2d half =
      (camera.frame_mm / 2 + Eigen::Vector2d::Constant(turned))
          .cwiseMin(std::max(camera.FrameRadius(), camera.frame_mm.maxCoeff() / 2)) +
      Eigen::Vector2d::Constant(grow);
  Bounds bounds = Bounds::OfNothing();
  for (int i = -4; i <= 4; ++i)
    for (int j = -4; j <= 4; ++j) {
      const Eigen::Vector2d photo =
          camera.frame_centre_mm + half.cwiseProduct(Eigen::Vector2d(i, j) / 4);
      const auto ray = GroundRayFromPhoto(ideal, prior.pose, photo);
      if (!ray || ray->direction.z() > -0.05) continue;
      for (const double z : {min_height_m, max_height_m}) {
        const double distance = (z - ray->origin_m.z()) / ray->direction.z();
        const Eigen::Vector3d point = ray->origin_m + distance * ray->direction;
        bounds.Include(point.x(), point.y());
      }
    }
  if (bounds.Empty()) return {};
  const Eigen::Vector3d sigma = prior.covariance.diagonal().head<3>().cwiseSqrt();
  // An error in height scales the footprint.
  const double height = std::max(1.0, prior.pose.position_m.z() - min_height_m);
  const double scale = k * sigma.z() / height;
  const double dx = k * sigma.x() + scale * (bounds.max_x - bounds.min_x) / 2;
  const double dy = k * sigma.y() + scale * (bounds.max_y - bounds.min_y) / 2;
  return {bounds.min_x - dx, bounds.min_y - dy, bounds.max_x + dx, bounds.max_y + dy};
}

}  // namespace orient::exterior
