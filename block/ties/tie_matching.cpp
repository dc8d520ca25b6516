#include "block/ties/tie_matching.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/terrain/pixel_derivatives.h"
#include "exterior/steps/match.h"
#include "exterior/steps/photo_task.h"
#include "exterior/steps/pixel_lattice.h"

namespace orient::block {
namespace {

// Sigma of heights above the surface, in ground pixels: roofs and tree crowns are good ties.
constexpr double kHeightSigma_px = 5;
constexpr double kMaxRadius_px = 80;  // of a search window, however little is known of the poses

// Largest distance between the starting point and the result of matching back.
constexpr double kMaxWayBack_px = 0.4;

// Positions in `from` for the pixels of `to` are computed on a lattice and interpolated linearly.
constexpr double kLatticeStep = 5;
constexpr double kSearchMarginPx = 3;
constexpr double kBackRadiusPx = 3;
constexpr int kMaxSupersampling = 8;

using Matrix2x6d = Eigen::Matrix<double, 2, 6>;

// Derivative of `to`'s pixel by `from`'s for horizontal ground shown by both.
std::optional<Eigen::Matrix2d> LocalScale(const TiePhoto& to, const TiePhoto& from,
                                          const Eigen::Vector3d& ground_m) {
  const auto of_to = PixelFromGroundWithDerivatives(to.view, ground_m);
  const auto of_from = PixelFromGroundWithDerivatives(from.view, ground_m);
  if (!of_to || !of_from) return std::nullopt;
  const Eigen::Matrix2d plane = of_from->by_ground.leftCols<2>();
  if (std::abs(plane.determinant()) < 1e-12) return std::nullopt;
  return of_to->by_ground.leftCols<2>() * plane.inverse();
}

bool Complete(const Image& image) {
  return std::none_of(image.values.begin(), image.values.end(),
                      [](float value) { return std::isnan(value); });
}

}  // namespace

exterior::AlignedPatch AlignWindow(const TiePhoto& to, const TiePhoto& from,
                                   const GroundSurface& surface, const Eigen::Vector2d& centre_px,
                                   const Eigen::Vector2d& shift_px, int side) {
  exterior::AlignedPatch aligned;
  aligned.predicted_px = centre_px;
  aligned.image = Image(side, side, kNoData);
  const Eigen::Vector2d first = centre_px - Eigen::Vector2d::Constant(side / 2.0);
  const exterior::PixelLattice lattice(
      side, kLatticeStep, [&](const Eigen::Vector2d& pixels) -> std::optional<Eigen::Vector2d> {
        const auto ground = to.view.GroundFromPixel(first + pixels, surface);
        const auto seen = ground ? from.view.PixelFromGround(*ground) : std::nullopt;
        if (!seen) return std::nullopt;
        return Eigen::Vector2d(*seen + shift_px);
      });
  const auto area = lattice.Area();
  if (!area || area->second.maxCoeff() > 4.0 * side) return aligned;
  const ImageWindow window =
      from.image->Around(area->first, area->second + Eigen::Vector2d::Constant(3), 1);
  const int samples = exterior::SamplesOfPixel(lattice.Scale(), kMaxSupersampling);
  const auto in_window = [&](double col, double row) {
    return window.ImageFromRaster(lattice.At(col, row));
  };
  for (int row = 0; row < side; ++row)
    for (int col = 0; col < side; ++col)
      aligned.image.At(col, row) =
          exterior::MeanOverPixel(window.image, col, row, samples, in_window);
  return aligned;
}

Eigen::Matrix2d DifferenceCovariance(const TiePhoto& owner, const TiePhoto& other,
                                     const Eigen::Vector3d& ground_m, double height_sigma_m) {
  const auto of_owner = PixelFromGroundWithDerivatives(owner.view, ground_m);
  const auto of_other = PixelFromGroundWithDerivatives(other.view, ground_m);
  const auto scale = LocalScale(other, owner, ground_m);
  if (!of_owner || !of_other || !scale) return Eigen::Matrix2d::Identity() * 1e12;
  const Matrix2x6d by_owner = *scale * of_owner->by_pose;
  // A height error acts along the owner's line of sight: it moves the other photo's pixel only.
  const Eigen::Vector3d sight = owner.view.pose.position_m - ground_m;
  const Eigen::Vector2d by_height = of_other->by_ground * (sight / sight.z());
  return of_other->by_pose * other.pose_covariance * of_other->by_pose.transpose() +
         by_owner * owner.pose_covariance * by_owner.transpose() +
         height_sigma_m * height_sigma_m * by_height * by_height.transpose();
}

std::optional<TieSighting> MatchPlace(const TiePhoto& owner, const TiePhoto& other,
                                      const TiePlace& place, const GroundSurface& surface,
                                      const TieOptions& options) {
  const auto predicted = other.view.PixelFromGround(place.ground_m);
  const auto scale = LocalScale(other, owner, place.ground_m);
  const auto of_owner = PixelFromGroundWithDerivatives(owner.view, place.ground_m);
  if (!predicted || !scale || !of_owner) return std::nullopt;
  const double gsd_m = 1 / of_owner->by_ground.leftCols<2>().norm() * std::numbers::sqrt2;
  const Eigen::Matrix2d covariance =
      DifferenceCovariance(owner, other, place.ground_m, kHeightSigma_px * gsd_m);
  const Eigen::Vector2d radius = (exterior::kWindowSigmas * covariance.diagonal().cwiseSqrt() +
                                  Eigen::Vector2d::Constant(kSearchMarginPx))
                                     .cwiseMin(Eigen::Vector2d::Constant(kMaxRadius_px));

  const exterior::AlignedPatch there =
      AlignWindow(other, owner, surface, *predicted, Eigen::Vector2d::Zero(), options.template_px);
  if (!Complete(there.image)) return std::nullopt;
  exterior::PreciseOptions precise;
  precise.min_score = options.min_score;
  const exterior::PreciseMatch match =
      exterior::PreciseSearch(there, *other.image, radius).ByGrey(precise);
  if (!match.found) return std::nullopt;

  const exterior::AlignedPatch back = AlignWindow(owner, other, surface, place.pixel,
                                                  match.pixel - *predicted, options.template_px);
  if (!Complete(back.image)) return std::nullopt;
  const exterior::PreciseMatch returned =
      exterior::PreciseSearch(back, *owner.image, Eigen::Vector2d::Constant(kBackRadiusPx))
          .ByGrey(precise);
  if (!returned.found) return std::nullopt;
  const Eigen::Vector2d way_back = returned.pixel - place.pixel;
  if (way_back.norm() > kMaxWayBack_px) return std::nullopt;

  TieSighting sighting;
  // Matching both ways measures the shift twice, each time interpolating the other photo.
  sighting.pixel = match.pixel - 0.5 * *scale * way_back;
  sighting.covariance_px2 = match.covariance_px2;
  sighting.ncc = match.ncc;
  return sighting;
}

}  // namespace orient::block
