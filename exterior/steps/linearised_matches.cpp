#include "exterior/steps/linearised_matches.h"

#include <Eigen/LU>

#include "core/geometry/principal_axes.h"
#include "core/terrain/pixel_derivatives.h"
#include "exterior/steps/shared_errors.h"

namespace orient::exterior {
namespace {

std::optional<Linearised> Linearise(const PhotoView& view,
                                    const std::vector<PatchObservation>& observations,
                                    Eigen::Index unknowns) {
  const Affine2d pixel_from_photo = view.photo_from_pixel.Inverse();
  const Eigen::Index rows = 2 * static_cast<Eigen::Index>(observations.size());
  Linearised system(rows, unknowns);
  for (Eigen::Index i = 0; i < rows / 2; ++i) {
    const PatchObservation& o = observations[static_cast<std::size_t>(i)];
    const auto d = PixelFromGroundWithDerivatives(view, o.ground_m);
    if (!d) return std::nullopt;
    system.by_unknowns.block<2, 6>(2 * i, 0) = d->by_pose;
    if (unknowns > 6) system.by_unknowns.block<2, 1>(2 * i, 6) = d->by_principal_distance;
    // photo = A pixel + t: an error of A and t shows in the pixel as -A^-1 (dA pixel + dt).
    Eigen::Matrix<double, 2, 6> affine;
    affine << o.pixel.x(), o.pixel.y(), 0, 0, 1, 0, 0, 0, o.pixel.x(), o.pixel.y(), 0, 1;
    system.by_interior.middleRows<2>(2 * i) = -pixel_from_photo.A * affine;
    system.by_height[0].segment<2>(2 * i) = d->by_ground * o.height_effect * o.height_sigma_m;
    system.by_height[1].segment<2>(2 * i) = d->by_ground.col(2) * o.surface_sigma_m;
    system.residuals.segment<2>(2 * i) = o.pixel - view.PixelFromPhoto(d->photo_mm);
  }
  return system;
}

}  // namespace

double OwnVariance(const PatchObservation& match) {
  return 2 / match.covariance_px2.inverse().trace();
}

bool IsOfEdge(const Eigen::Matrix2d& c) {
  constexpr double kMostRatio = 100;  // of variances
  // In terms of the principal axes' ratio r: trace^2 / determinant = r + 2 + 1 / r.
  return c.trace() * c.trace() > (kMostRatio + 2) * c.determinant();
}

GroupedMatches Group(const std::vector<PatchObservation>& all) {
  GroupedMatches grouped{all, Grouped(all), {}};
  for (const std::vector<std::size_t>& group : grouped.groups) {
    PatchObservation mean = all[group.front()];
    mean.ground_m.setZero();
    mean.pixel.setZero();
    double weights = 0;
    Eigen::Matrix2d information = Eigen::Matrix2d::Zero();
    for (const std::size_t i : group) {
      const double weight = 1 / OwnVariance(all[i]);
      mean.ground_m += weight * all[i].ground_m;
      mean.pixel += weight * all[i].pixel;
      weights += weight;
      information += all[i].covariance_px2.inverse();
    }
    mean.ground_m /= weights;
    mean.pixel /= weights;
    mean.covariance_px2 = information.inverse();
    grouped.means.push_back(mean);
  }
  return grouped;
}

OwnCovariances OwnCovariancesOf(const std::vector<PatchObservation>& observations) {
  const Eigen::Index rows = 2 * std::ssize(observations);
  OwnCovariances own{Eigen::MatrixXd::Zero(rows, rows), Eigen::MatrixXd::Zero(rows, rows)};
  for (Eigen::Index i = 0; i < rows / 2; ++i) {
    const PatchObservation& observation = observations[static_cast<std::size_t>(i)];
    Eigen::Matrix2d open = Eigen::Matrix2d::Zero();
    if (IsOfEdge(observation.covariance_px2)) {
      const PrincipalAxes axes = AxesOf(observation.covariance_px2);
      open = axes.values[1] * axes.vectors.col(1) * axes.vectors.col(1).transpose();
    }
    own.measured.block<2, 2>(2 * i, 2 * i) = observation.covariance_px2 - open;
    own.open.block<2, 2>(2 * i, 2 * i) = open;
  }
  return own;
}

std::optional<Linearised> Linearise(const PhotoView& view, const GroupedMatches& matches,
                                    Eigen::Index unknowns) {
  const auto single = Linearise(view, matches.all, unknowns);
  if (!single || matches.groups.size() == matches.all.size()) return single;
  const Eigen::Index rows = 2 * std::ssize(matches.groups);
  Linearised mean(rows, unknowns);
  for (Eigen::Index g = 0; g < rows / 2; ++g) {
    const auto group = static_cast<std::size_t>(g);
    for (const std::size_t i : matches.groups[group]) {
      const Eigen::Matrix2d share =
          matches.means[group].covariance_px2 * matches.all[i].covariance_px2.inverse();
      const Eigen::Index from = 2 * static_cast<Eigen::Index>(i);
      mean.by_unknowns.middleRows<2>(2 * g) += share * single->by_unknowns.middleRows<2>(from);
      mean.by_interior.middleRows<2>(2 * g) += share * single->by_interior.middleRows<2>(from);
      for (std::size_t kind = 0; kind < kHeightKinds; ++kind)
        mean.by_height[kind].segment<2>(2 * g) += share * single->by_height[kind].segment<2>(from);
      mean.residuals.segment<2>(2 * g) += share * single->residuals.segment<2>(from);
    }
  }
  return mean;
}

}  // namespace orient::exterior
