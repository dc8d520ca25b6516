#include "exterior/freed_distance.h"

#include <Eigen/Dense>
#include <cmath>

#include "core/geometry/collinearity.h"
#include "exterior/shared_errors.h"

namespace orient {
namespace {

using Vector7d = Eigen::Matrix<double, 7, 1>;
using Matrix7d = Eigen::Matrix<double, 7, 7>;

constexpr std::size_t kMinObservations = 4;
constexpr int kIterations = 6;

struct Linearised {
  Eigen::Matrix<double, Eigen::Dynamic, 7> design;
  Eigen::VectorXd residuals;  // measured - computed, px
  Eigen::VectorXd by_height;  // px per standard deviation of the height error
};

std::optional<Linearised> Linearise(const PhotoView& view,
                                    const std::vector<PatchObservation>& observations) {
  const Eigen::Matrix2d pixel_from_photo = view.photo_from_pixel.A.inverse();
  const auto rows = 2 * static_cast<Eigen::Index>(observations.size());
  Linearised system{Eigen::MatrixXd(rows, 7), Eigen::VectorXd(rows), Eigen::VectorXd(rows)};
  for (std::size_t i = 0; i < observations.size(); ++i) {
    const PatchObservation& o = observations[i];
    const auto d = PhotoFromGroundWithDerivatives(view.camera, view.pose, o.ground_m);
    if (!d) return std::nullopt;
    const auto row = 2 * static_cast<Eigen::Index>(i);
    system.design.block<2, 6>(row, 0) = pixel_from_photo * d->by_pose;
    system.design.block<2, 1>(row, 6) = pixel_from_photo * d->by_principal_distance;
    system.residuals.segment<2>(row) = o.pixel - view.PixelFromPhoto(d->photo_mm);
    system.by_height.segment<2>(row) =
        pixel_from_photo * d->by_ground * o.height_effect * o.height_sigma_m;
  }
  return system;
}

// Blocks of two rows: each observation's own, and what all heights do to them together.
Eigen::MatrixXd Covariance(const std::vector<PatchObservation>& observations,
                           const Eigen::VectorXd& by_height, double variance_factor,
                           double correlation_m) {
  Eigen::MatrixXd covariance = by_height.asDiagonal() *
                               HeightCorrelation(observations, correlation_m) *
                               by_height.asDiagonal();
  for (std::size_t i = 0; i < observations.size(); ++i) {
    const auto row = 2 * static_cast<Eigen::Index>(i);
    covariance.block<2, 2>(row, row) += variance_factor * observations[i].covariance_px2;
  }
  return covariance;
}

}  // namespace

std::optional<FreedPose> EstimateFreedPose(const PhotoView& view, const PosePrior& prior,
                                           const PrincipalDistancePrior& distance,
                                           const std::vector<PatchObservation>& all,
                                           double variance_factor, double height_correlation_m) {
  const std::vector<PatchObservation> observations = Thinned(all);
  if (observations.size() < kMinObservations) return std::nullopt;
  Matrix7d prior_information = Matrix7d::Zero();
  prior_information.topLeftCorner<6, 6>() = prior.covariance.inverse();
  prior_information(6, 6) = 1 / (distance.sigma_mm * distance.sigma_mm);
  PhotoView now = view;
  Matrix7d covariance;
  for (int i = 0; i < kIterations; ++i) {
    const auto system = Linearise(now, observations);
    if (!system) return std::nullopt;
    const Eigen::LLT<Eigen::MatrixXd> noise(
        Covariance(observations, system->by_height, variance_factor, height_correlation_m));
    if (noise.info() != Eigen::Success) return std::nullopt;
    const Eigen::Matrix<double, Eigen::Dynamic, 7> weighted = noise.solve(system->design);
    const Eigen::LLT<Matrix7d> normals(system->design.transpose() * weighted + prior_information);
    if (normals.info() != Eigen::Success) return std::nullopt;
    Vector7d off;
    off << PoseDifference(prior.pose, now.pose),
        distance.value_mm - now.camera.principal_distance_mm;
    const Vector7d step =
        normals.solve(weighted.transpose() * system->residuals + prior_information * off);
    now.pose = Pose::FromVector(now.pose.AsVector() + step.head<6>());
    now.camera.principal_distance_mm += step[6];
    covariance = normals.solve(Matrix7d::Identity());
  }
  if (!covariance.allFinite() || !(now.camera.principal_distance_mm > 0)) return std::nullopt;
  return FreedPose{now.pose, covariance.topLeftCorner<6, 6>(), now.camera.principal_distance_mm,
                   std::sqrt(covariance(6, 6))};
}

}  // namespace orient
