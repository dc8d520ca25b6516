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

// Single matches, and the groups of them whose weighted means are the observations.
struct GroupedMatches {
  const std::vector<PatchObservation>& all;
  std::vector<std::vector<std::size_t>> groups;
  std::vector<PatchObservation> means;  // of the groups; their covariances have both axes alike
};

double OwnVariance(const PatchObservation& match) { return match.covariance_px2.trace() / 2; }

GroupedMatches Group(const std::vector<PatchObservation>& all) {
  GroupedMatches grouped{all, Grouped(all), {}};
  for (const std::vector<std::size_t>& group : grouped.groups) {
    PatchObservation mean = all[group.front()];
    mean.ground_m.setZero();
    mean.pixel.setZero();
    double weights = 0;
    for (const std::size_t i : group) {
      const double weight = 1 / OwnVariance(all[i]);
      mean.ground_m += weight * all[i].ground_m;
      mean.pixel += weight * all[i].pixel;
      weights += weight;
    }
    mean.ground_m /= weights;
    mean.pixel /= weights;
    mean.covariance_px2 = Eigen::Matrix2d::Identity() / weights;
    grouped.means.push_back(mean);
  }
  return grouped;
}

Eigen::VectorXd NoiseVariances(const std::vector<PatchObservation>& observations) {
  Eigen::VectorXd variances(2 * std::ssize(observations));
  for (Eigen::Index i = 0; i < std::ssize(observations); ++i)
    variances.segment<2>(2 * i).setConstant(OwnVariance(observations[static_cast<std::size_t>(i)]));
  return variances;
}

// The linearised problem of the means: the matches' equations, averaged.
std::optional<Linearised> Linearise(const PhotoView& view, const GroupedMatches& matches,
                                    Eigen::Index unknowns) {
  const auto single = Linearise(view, matches.all, unknowns);
  if (!single || matches.groups.size() == matches.all.size()) return single;
  const Eigen::Index rows = 2 * std::ssize(matches.groups);
  Linearised mean{Eigen::MatrixXd::Zero(rows, unknowns), Eigen::MatrixXd::Zero(rows, 6),
                  Eigen::VectorXd::Zero(rows), Eigen::VectorXd::Zero(rows)};
  for (Eigen::Index g = 0; g < rows / 2; ++g) {
    const auto group = static_cast<std::size_t>(g);
    for (const std::size_t i : matches.groups[group]) {
      const double share = OwnVariance(matches.means[group]) / OwnVariance(matches.all[i]);
      const Eigen::Index from = 2 * static_cast<Eigen::Index>(i);
      mean.by_unknowns.middleRows<2>(2 * g) += share * single->by_unknowns.middleRows<2>(from);
      mean.by_interior.middleRows<2>(2 * g) += share * single->by_interior.middleRows<2>(from);
      mean.by_height.segment<2>(2 * g) += share * single->by_height.segment<2>(from);
      mean.residuals.segment<2>(2 * g) += share * single->residuals.segment<2>(from);
    }
  }
  return mean;
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

// How many observations the stated precision of surveyed points is worth, where all of an
// observation's variance is theirs: unlike matching's it is known, and twelve points tell it to a
// fifth only.
constexpr double kTrustInSurvey = 30;

// The two variance components after a step. `left`: what of the residuals' weights is left once the
// unknowns have followed. `stated`: redundancy that the stated variances are worth. Returns the
// noise's redundancy.
double UpdateComponents(const Eigen::VectorXd& weighted, const Eigen::MatrixXd& left,
                        const Eigen::MatrixXd& noise, const Eigen::MatrixXd& heights, double stated,
                        CorrelatedPose* estimate) {
  const Eigen::MatrixXd of_noise = estimate->noise_factor * noise;
  const Eigen::MatrixXd of_heights = estimate->height_factor * heights;
  const double redundancy = left.cwiseProduct(of_noise).sum();
  const double by_residuals = estimate->noise_factor * Component(weighted, left, of_noise);
  estimate->noise_factor =
      std::max((redundancy * by_residuals + stated) / (redundancy + stated), kLeastNoiseFactor);
  if (left.cwiseProduct(of_heights).sum() > kLeastHeightRedundancy)
    estimate->height_factor =
        std::clamp(estimate->height_factor * Component(weighted, left, of_heights), 0.01, 10.0);
  return redundancy + stated;
}

// What the matches' variances consist of.
struct Variances {
  double own_px2 = 0;  // of matching, mean
  double stated = 0;   // redundancy that the stated precision of ground points is worth
};

Variances VariancesOf(const std::vector<PatchObservation>& matches) {
  Variances variances;
  const auto count = static_cast<double>(matches.size());
  for (const PatchObservation& match : matches) {
    variances.own_px2 += (OwnVariance(match) - match.ground_px2) / count;
    variances.stated += kTrustInSurvey * match.ground_px2 / OwnVariance(match) / count;
  }
  return variances;
}

std::vector<ResidualTrend> TrendsOf(const std::vector<PatchObservation>& observations,
                                    const Eigen::VectorXd& residuals) {
  TrendInput input;
  for (Eigen::Index i = 0; i < std::ssize(observations); ++i) {
    const PatchObservation& observation = observations[static_cast<std::size_t>(i)];
    input.pixels.push_back(observation.pixel);
    input.residuals_px.emplace_back(residuals.segment<2>(2 * i));
    input.sources.push_back(observation.source);
  }
  return FindTrends(input);
}

// What does not change from step to step.
struct Model {
  const GroupedMatches& matches;
  const CommonErrors& common;
  const PosePrior& prior;
  const UnknownDistance& unknown;
  Eigen::MatrixXd noise, correlation, film, prior_information;
};

// One step of Gauss-Newton with the variance components as they are.
struct Step {
  Linearised system;
  Eigen::MatrixXd heights;                 // covariance, px^2
  Eigen::LLT<Eigen::MatrixXd> covariance;  // of all observations
  Eigen::MatrixXd weighted_design, known;  // the latter: covariance of the unknowns
  Eigen::VectorXd step;

  Eigen::VectorXd Residuals() const { return system.residuals - system.by_unknowns * step; }
  // What of the residuals' weights is left once the unknowns have followed.
  Eigen::MatrixXd Left() const {
    const Eigen::Index rows = system.residuals.size();
    return covariance.solve(Eigen::MatrixXd::Identity(rows, rows)) -
           weighted_design * known * weighted_design.transpose();
  }
};

std::optional<Step> StepFrom(const PhotoView& now, const Model& model,
                             const CorrelatedPose& estimate) {
  const Eigen::Index unknowns = model.prior_information.rows();
  const auto system = Linearise(now, model.matches, unknowns);
  if (!system) return std::nullopt;
  Step step{*system, {}, {}, {}, {}, {}};
  step.heights =
      system->by_height.asDiagonal() * model.correlation * system->by_height.asDiagonal();
  step.covariance.compute(
      estimate.noise_factor * model.noise + estimate.height_factor * step.heights + model.film +
      system->by_interior * model.common.interior * system->by_interior.transpose());
  if (step.covariance.info() != Eigen::Success) return std::nullopt;
  step.weighted_design = step.covariance.solve(system->by_unknowns);
  const Eigen::LLT<Eigen::MatrixXd> normals(system->by_unknowns.transpose() * step.weighted_design +
                                            model.prior_information);
  if (normals.info() != Eigen::Success) return std::nullopt;
  step.step =
      normals.solve(step.weighted_design.transpose() * system->residuals +
                    model.prior_information * PriorMinusNow(model.prior, model.unknown, now));
  step.known = normals.solve(Eigen::MatrixXd::Identity(unknowns, unknowns));
  return step;
}

// The unknowns' covariance, first with what the residuals show only. Trends are noted.
struct Covariances {
  Eigen::MatrixXd known, honest;
};

Covariances CovariancesOf(const Step& step, const Model& model, const Variances& of_matches,
                          double redundancy, CorrelatedPose* estimate) {
  const std::vector<PatchObservation>& observations = model.matches.means;
  const double fade_m = model.common.height_correlation_m;
  const double student = Student(redundancy);
  const double factor = student * estimate->noise_factor;
  const LinearEstimator estimator{step.known * step.weighted_design.transpose(),
                                  factor * model.noise.diagonal(), factor * of_matches.own_px2,
                                  step.system.by_height, estimate->height_factor};
  Covariances covariances{step.known, {}};
  covariances.known += (1 - 1 / student) * estimator.by_observation *
                       estimator.noise_px2.asDiagonal() * estimator.by_observation.transpose();
  const Eigen::VectorXd residuals = step.Residuals();
  estimate->trends = TrendsOf(observations, residuals);
  // The covariance holds those that heights and film explain, not those of what remains as noise.
  const auto unexplained = TrendsOf(
      observations, estimate->noise_factor *
                        model.noise.diagonal().cwiseProduct(step.covariance.solve(residuals)));
  covariances.honest =
      covariances.known + CovarianceOfUnseenErrors(estimator, observations, fade_m);
  if (!unexplained.empty())
    covariances.honest += CovarianceOfTrends(estimator, observations,
                                             std::pow(unexplained.front().rms_px, 2), fade_m);
  return covariances;
}

}  // namespace

std::optional<CorrelatedPose> EstimateCorrelatedPose(
    const PhotoView& view, const PosePrior& prior, const std::vector<PatchObservation>& all,
    const CommonErrors& common, const std::optional<PrincipalDistancePrior>& unknown) {
  if (all.size() < kMinObservations) return std::nullopt;
  const GroupedMatches matches = Group(all);
  const Model model{matches,
                    common,
                    prior,
                    unknown,
                    NoiseVariances(matches.means).asDiagonal(),
                    HeightCorrelation(matches.means, common.height_correlation_m),
                    FilmCovariance(matches.means, common),
                    PriorInformation(prior, unknown)};
  const Variances of_matches = VariancesOf(all);
  CorrelatedPose estimate;
  PhotoView now = view;
  Covariances covariances;
  const int iterations = unknown ? kIterationsWithDistance : kIterations;
  for (int i = 0; i < iterations; ++i) {
    const auto step = StepFrom(now, model, estimate);
    if (!step) return std::nullopt;
    Move(step->step, &now);
    const double redundancy =
        UpdateComponents(step->covariance.solve(step->Residuals()), step->Left(), model.noise,
                         step->heights, of_matches.stated, &estimate);
    if (i + 1 == iterations)
      covariances = CovariancesOf(*step, model, of_matches, redundancy, &estimate);
  }
  if (!covariances.honest.allFinite() || !(now.camera.principal_distance_mm > 0))
    return std::nullopt;
  estimate.pose = now.pose;
  estimate.covariance = covariances.known.topLeftCorner<6, 6>();
  estimate.honest_covariance = covariances.honest.topLeftCorner<6, 6>();
  estimate.principal_distance_mm = now.camera.principal_distance_mm;
  if (unknown) estimate.principal_distance_sigma_mm = std::sqrt(covariances.honest(6, 6));
  return estimate;
}

}  // namespace orient::exterior
