#include "exterior/steps/correlated_pose.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "core/geometry/collinearity.h"
#include "core/terrain/pixel_derivatives.h"
#include "exterior/steps/shared_errors.h"
#include "exterior/steps/unseen_errors.h"

namespace orient::exterior {
namespace {

constexpr std::size_t kMinObservations = 4;
constexpr int kIterations = 4, kIterationsWithDistance = 6;
// Residuals of next to nothing (hardly any redundancy, and what did not fit taken out) are no
// reason to believe that nothing is uncertain.
constexpr double kLeastNoiseFactor = 0.1;
// Heights that the residuals hardly show keep their stated variance.
constexpr double kLeastHeightRedundancy = 0.5;

// The linearised problem about one pose; two rows (col, row) an observation.
struct Linearised {
  Eigen::MatrixXd by_unknowns;  // the pose's six, and the principal distance where it is an unknown
  Eigen::Matrix<double, Eigen::Dynamic, 6> by_interior;
  Eigen::VectorXd by_height;  // px per standard deviation of the height error
  Eigen::VectorXd residuals;  // measured - computed, px
};

std::optional<Linearised> Linearise(const PhotoView& view,
                                    const std::vector<PatchObservation>& observations,
                                    Eigen::Index unknowns) {
  const Affine2d pixel_from_photo = view.photo_from_pixel.Inverse();
  const Eigen::Index rows = 2 * static_cast<Eigen::Index>(observations.size());
  Linearised system{Eigen::MatrixXd(rows, unknowns), Eigen::MatrixXd(rows, 6),
                    Eigen::VectorXd(rows), Eigen::VectorXd(rows)};
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
    system.by_height.segment<2>(2 * i) = d->by_ground * o.height_effect * o.height_sigma_m;
    system.residuals.segment<2>(2 * i) = o.pixel - view.PixelFromPhoto(d->photo_mm);
  }
  return system;
}

Eigen::VectorXd NoiseVariances(const std::vector<PatchObservation>& observations) {
  Eigen::VectorXd variances(2 * static_cast<Eigen::Index>(observations.size()));
  for (std::size_t i = 0; i < observations.size(); ++i)
    variances.segment<2>(2 * static_cast<Eigen::Index>(i))
        .setConstant(observations[i].covariance_px2.trace() / 2);
  return variances;
}

// Covariance of the film's deformation at any two observations, the same in col and row.
Eigen::MatrixXd FilmCovariance(const std::vector<PatchObservation>& observations,
                               const CommonErrors& common) {
  const Eigen::Index n = static_cast<Eigen::Index>(observations.size());
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(2 * n, 2 * n);
  if (common.film_sigma_px <= 0) return covariance;
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j) {
      const double distance = (observations[static_cast<std::size_t>(i)].pixel -
                               observations[static_cast<std::size_t>(j)].pixel)
                                  .norm() /
                              common.film_correlation_px;
      covariance.block<2, 2>(2 * i, 2 * j) = Eigen::Matrix2d::Identity() *
                                             std::pow(common.film_sigma_px, 2) *
                                             std::exp(-distance * distance);
    }
  return covariance;
}

// A variance that so many degrees of freedom tell is uncertain itself: errors follow Student's
// distribution, whose variance is larger by this.
double Student(double redundancy) {
  constexpr double kLeast = 3;
  return std::max(redundancy, kLeast) / (std::max(redundancy, kLeast) - 2);
}

// One component's estimate: v' W C W v / tr(P C), with W the inverse of the whole covariance and P
// what is left of it once the pose has followed the observations (restricted maximum likelihood,
// Patterson & Thompson 1971).
double Component(const Eigen::VectorXd& weighted, const Eigen::MatrixXd& left,
                 const Eigen::MatrixXd& component) {
  const double expected = left.cwiseProduct(component).sum();
  return expected > 0 ? weighted.dot(component * weighted) / expected : 1.0;
}

using UnknownDistance = std::optional<PrincipalDistancePrior>;

// Of the pose's six unknowns, and of the principal distance where it is an unknown.
Eigen::MatrixXd PriorInformation(const PosePrior& prior, const UnknownDistance& unknown) {
  const Eigen::Index unknowns = unknown ? 7 : 6;
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(unknowns, unknowns);
  information.topLeftCorner<6, 6>() = prior.covariance.inverse();
  if (unknown) information(6, 6) = 1 / (unknown->sigma_mm * unknown->sigma_mm);
  return information;
}

Eigen::VectorXd PriorMinusNow(const PosePrior& prior, const UnknownDistance& unknown,
                              const PhotoView& now) {
  Eigen::VectorXd off(unknown ? 7 : 6);
  off.head<6>() = PoseDifference(prior.pose, now.pose);
  if (unknown) off[6] = unknown->value_mm - now.camera.principal_distance_mm;
  return off;
}

void Move(const Eigen::VectorXd& step, PhotoView* now) {
  now->pose = Pose::FromVector(now->pose.AsVector() + step.head<6>());
  if (step.size() > 6) now->camera.principal_distance_mm += step[6];
}

// The two variance components after a step. `left`: what of the residuals' weights is left once the
// unknowns have followed. Returns the noise's redundancy.
double UpdateComponents(const Eigen::VectorXd& weighted, const Eigen::MatrixXd& left,
                        const Eigen::MatrixXd& noise, const Eigen::MatrixXd& heights,
                        CorrelatedPose* estimate) {
  const Eigen::MatrixXd of_noise = estimate->noise_factor * noise;
  const Eigen::MatrixXd of_heights = estimate->height_factor * heights;
  estimate->noise_factor =
      std::max(estimate->noise_factor * Component(weighted, left, of_noise), kLeastNoiseFactor);
  if (left.cwiseProduct(of_heights).sum() > kLeastHeightRedundancy)
    estimate->height_factor =
        std::clamp(estimate->height_factor * Component(weighted, left, of_heights), 0.01, 10.0);
  return left.cwiseProduct(of_noise).sum();
}

}  // namespace

std::optional<CorrelatedPose> EstimateCorrelatedPose(
    const PhotoView& view, const PosePrior& prior, const std::vector<PatchObservation>& all,
    const CommonErrors& common, const std::optional<PrincipalDistancePrior>& unknown) {
  const std::vector<PatchObservation> observations = Thinned(all);
  if (observations.size() < kMinObservations) return std::nullopt;
  const Eigen::MatrixXd noise = NoiseVariances(observations).asDiagonal();
  const Eigen::MatrixXd correlation = HeightCorrelation(observations, common.height_correlation_m);
  const Eigen::MatrixXd film = FilmCovariance(observations, common);
  const Eigen::MatrixXd prior_information = PriorInformation(prior, unknown);
  const Eigen::Index unknowns = prior_information.rows();

  CorrelatedPose estimate;
  PhotoView now = view;
  Eigen::MatrixXd known, honest;  // covariances of all unknowns
  const int iterations = unknown ? kIterationsWithDistance : kIterations;
  for (int i = 0; i < iterations; ++i) {
    const auto system = Linearise(now, observations, unknowns);
    if (!system) return std::nullopt;
    const Eigen::MatrixXd& design = system->by_unknowns;
    const Eigen::MatrixXd heights =
        system->by_height.asDiagonal() * correlation * system->by_height.asDiagonal();
    const Eigen::LLT<Eigen::MatrixXd> covariance(
        estimate.noise_factor * noise + estimate.height_factor * heights + film +
        system->by_interior * common.interior * system->by_interior.transpose());
    if (covariance.info() != Eigen::Success) return std::nullopt;
    const Eigen::MatrixXd weighted_design = covariance.solve(design);
    const Eigen::LLT<Eigen::MatrixXd> normals(design.transpose() * weighted_design +
                                              prior_information);
    if (normals.info() != Eigen::Success) return std::nullopt;
    const Eigen::VectorXd step =
        normals.solve(weighted_design.transpose() * system->residuals +
                      prior_information * PriorMinusNow(prior, unknown, now));
    Move(step, &now);
    known = normals.solve(Eigen::MatrixXd::Identity(unknowns, unknowns));

    const Eigen::MatrixXd left =
        covariance.solve(Eigen::MatrixXd::Identity(noise.rows(), noise.cols())) -
        weighted_design * known * weighted_design.transpose();
    const double redundancy = UpdateComponents(covariance.solve(system->residuals - design * step),
                                               left, noise, heights, &estimate);
    if (i + 1 < iterations) continue;
    const double student = Student(redundancy);
    const LinearEstimator estimator{known * weighted_design.transpose(),
                                    student * estimate.noise_factor * noise.diagonal(),
                                    system->by_height, estimate.height_factor};
    known += (1 - 1 / student) * estimator.by_observation * estimator.noise_px2.asDiagonal() *
             estimator.by_observation.transpose();
    honest = known + CovarianceOfUnseenErrors(estimator, observations, common.height_correlation_m);
  }
  if (!honest.allFinite() || !(now.camera.principal_distance_mm > 0)) return std::nullopt;
  estimate.pose = now.pose;
  estimate.covariance = known.topLeftCorner<6, 6>();
  estimate.honest_covariance = honest.topLeftCorner<6, 6>();
  estimate.principal_distance_mm = now.camera.principal_distance_mm;
  if (unknown) estimate.principal_distance_sigma_mm = std::sqrt(honest(6, 6));
  return estimate;
}

}  // namespace orient::exterior
