#include "exterior/steps/correlated_pose.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/median.h"
#include "core/geometry/collinearity.h"
#include "exterior/steps/error_model.h"
#include "exterior/steps/linearised_matches.h"
#include "exterior/steps/shared_errors.h"
#include "exterior/steps/unseen_errors.h"

namespace orient::exterior {
namespace {

constexpr std::size_t kMinObservations = 4;
constexpr int kIterations = 4, kIterationsWithDistance = 6;
// Tiny residuals (with hardly any redundancy, and what did not fit removed) do not prove that the
// uncertainty is tiny.
constexpr double kLeastNoiseFactor = 0.1;
// Height errors that hardly show in the residuals keep their stated variance.
constexpr double kLeastHeightRedundancy = 0.5;
// Log likelihood by which residuals must prefer a long correlation of height errors.
constexpr double kClearlyBetter = 3;
// Largest spacing of matches, in short correlation lengths, at which they show a short correlation.
constexpr double kCloseEnough = 0.5;

// A variance estimated with this many degrees of freedom is itself uncertain: errors follow
// Student's t-distribution, whose variance is larger by this factor.
double Student(double redundancy) {
  constexpr double kLeast = 3;
  return std::max(redundancy, kLeast) / (std::max(redundancy, kLeast) - 2);
}

// One component's estimate: v' W C W v / tr(P C), with W the inverse of the whole covariance and P
// what remains of W once the pose has followed the observations (restricted maximum likelihood,
// Patterson & Thompson 1971).
double Component(const Eigen::VectorXd& weighted, const Eigen::MatrixXd& left,
                 const Eigen::MatrixXd& component) {
  const double expected = left.cwiseProduct(component).sum();
  return expected > 0 ? weighted.dot(component * weighted) / expected : 1.0;
}

using UnknownDistance = std::optional<PrincipalDistancePrior>;

// The prior's information on the pose's six unknowns, and on the principal distance if unknown.
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

// How many observations the stated precision of surveyed points is worth if all of an observation's
// variance comes from them: unlike that of matching it is known, whereas twelve points determine it
// only to a fifth.
constexpr double kTrustInSurvey = 30;

// Factors on the stated variances.
struct Components {
  double noise = 1;
  OfHeights<double> heights = {1, 1};
};

// After a step. `left`: what remains of the residuals' weights once the unknowns have been fitted.
// `stated`: redundancy that the stated variances are worth. Returns the noise's redundancy.
double UpdateComponents(const Eigen::VectorXd& weighted, const Eigen::MatrixXd& left,
                        const Eigen::MatrixXd& noise, const OfHeights<Eigen::MatrixXd>& heights,
                        double stated, Components* components) {
  const Eigen::MatrixXd of_noise = components->noise * noise;
  const double redundancy = left.cwiseProduct(of_noise).sum();
  const double by_residuals = components->noise * Component(weighted, left, of_noise);
  for (std::size_t kind = 0; kind < kHeightKinds; ++kind) {
    double& factor = components->heights[kind];
    const Eigen::MatrixXd of_heights = factor * heights[kind];
    if (left.cwiseProduct(of_heights).sum() > kLeastHeightRedundancy)
      factor = std::clamp(factor * Component(weighted, left, of_heights), 0.01, 10.0);
  }
  components->noise =
      std::max((redundancy * by_residuals + stated) / (redundancy + stated), kLeastNoiseFactor);
  return redundancy + stated;
}

// Parts of the matches' variances.
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

// Edges are left out: along an edge there is no residual.
std::vector<ResidualTrend> TrendsOf(const std::vector<PatchObservation>& observations,
                                    const Eigen::VectorXd& residuals) {
  TrendInput input;
  for (Eigen::Index i = 0; i < std::ssize(observations); ++i) {
    const PatchObservation& observation = observations[static_cast<std::size_t>(i)];
    if (IsOfEdge(observation.covariance_px2)) continue;
    input.pixels.push_back(observation.pixel);
    input.residuals_px.emplace_back(residuals.segment<2>(2 * i));
    input.sources.push_back(observation.source);
  }
  return FindTrends(input);
}

double LogDeterminant(const Eigen::LLT<Eigen::MatrixXd>& matrix) {
  return 2 * matrix.matrixLLT().diagonal().array().log().sum();
}

// What does not change from step to step.
struct Model {
  const GroupedMatches& matches;
  const CommonErrors& common;
  const PosePrior& prior;
  const UnknownDistance& unknown;
  Eigen::MatrixXd noise;  // covariance of the measurements, with a variance component
  Eigen::MatrixXd fixed;  // the same of film deformation and what edges leave open: without one
  Eigen::MatrixXd prior_information;
  OfHeights<Eigen::MatrixXd> correlation;
};

// One step of Gauss-Newton with the variance components as they are.
struct Step {
  Linearised system;
  OfHeights<Eigen::MatrixXd> heights;      // covariances, px^2
  Eigen::LLT<Eigen::MatrixXd> covariance;  // of all observations
  Eigen::MatrixXd weighted_design, known;  // the latter: covariance of the unknowns
  double log_determinant = 0;              // of the normals
  Eigen::VectorXd step, prior_minus_now;

  Eigen::VectorXd Residuals() const { return system.residuals - system.by_unknowns * step; }
  // What remains of the residuals' weights once the unknowns have been fitted.
  Eigen::MatrixXd Left() const {
    const Eigen::Index rows = system.residuals.size();
    return covariance.solve(Eigen::MatrixXd::Identity(rows, rows)) -
           weighted_design * known * weighted_design.transpose();
  }
  // Restricted log likelihood, up to a constant.
  double LogLikelihood(const Eigen::MatrixXd& prior_information) const {
    const Eigen::VectorXd residuals = Residuals(), off = prior_minus_now - step;
    return -(residuals.dot(covariance.solve(residuals)) + off.dot(prior_information * off) +
             LogDeterminant(covariance) + log_determinant) /
           2;
  }
};

std::optional<Step> StepFrom(const PhotoView& now, const Model& model,
                             const Components& components) {
  const Eigen::Index unknowns = model.prior_information.rows();
  const auto system = Linearise(now, model.matches, unknowns);
  if (!system) return std::nullopt;
  Step step{*system, {}, {}, {}, {}, 0, {}, PriorMinusNow(model.prior, model.unknown, now)};
  Eigen::MatrixXd covariance =
      components.noise * model.noise + model.fixed +
      system->by_interior * model.common.interior * system->by_interior.transpose();
  for (std::size_t kind = 0; kind < kHeightKinds; ++kind) {
    const auto by_height = system->by_height[kind].asDiagonal();
    step.heights[kind] = by_height * model.correlation[kind] * by_height;
    covariance += components.heights[kind] * step.heights[kind];
  }
  step.covariance.compute(covariance);
  if (step.covariance.info() != Eigen::Success) return std::nullopt;
  step.weighted_design = step.covariance.solve(system->by_unknowns);
  const Eigen::LLT<Eigen::MatrixXd> normals(system->by_unknowns.transpose() * step.weighted_design +
                                            model.prior_information);
  if (normals.info() != Eigen::Success) return std::nullopt;
  step.log_determinant = LogDeterminant(normals);
  step.step = normals.solve(step.weighted_design.transpose() * system->residuals +
                            model.prior_information * step.prior_minus_now);
  step.known = normals.solve(Eigen::MatrixXd::Identity(unknowns, unknowns));
  return step;
}

// The unknowns' covariances; `known`: only with what the residuals show.
struct Covariances {
  Eigen::MatrixXd known, honest, common_height_covariance;
};

// Result of the adjustment.
struct Adjusted {
  PhotoView view;
  Components components;
  double redundancy = 0;  // of the noise
  Step last;
  double log_likelihood = 0;
};

std::optional<Adjusted> Adjust(const PhotoView& view, const Model& model, double stated) {
  Adjusted adjusted{view, {}, 0, {Linearised(0, 0), {}, {}, {}, {}, 0, {}, {}}, 0};
  const int iterations = model.unknown ? kIterationsWithDistance : kIterations;
  for (int i = 0; i < iterations; ++i) {
    auto step = StepFrom(adjusted.view, model, adjusted.components);
    if (!step) return std::nullopt;
    Move(step->step, &adjusted.view);
    adjusted.log_likelihood = step->LogLikelihood(model.prior_information);
    adjusted.redundancy =
        UpdateComponents(step->covariance.solve(step->Residuals()), step->Left(), model.noise,
                         step->heights, stated, &adjusted.components);
    adjusted.last = *std::move(step);
  }
  return adjusted;
}

// The median distance from each match to its nearest neighbour.
double MedianSpacing_m(const std::vector<PatchObservation>& observations) {
  std::vector<double> nearest_m(observations.size(), std::numeric_limits<double>::infinity());
  for (std::size_t i = 0; i < observations.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) {
      const double distance_m =
          (observations[i].ground_m - observations[j].ground_m).head<2>().norm();
      nearest_m[i] = std::min(nearest_m[i], distance_m);
      nearest_m[j] = std::min(nearest_m[j], distance_m);
    }
  return UpperMedian(std::move(nearest_m));
}

// If matches lie close enough to show it, height errors are taken to decorrelate over a short
// distance, like those of a DEM too coarse for its terrain, unless the residuals clearly favour a
// long one; otherwise over the long one, which is less optimistic. Errors of the surface under an
// orthophoto, which does not show heights, always decorrelate over the short one.
std::optional<Adjusted> AdjustAsResidualsSay(const PhotoView& view, Model* model, double stated) {
  const double length_m = model->common.height_correlation_m;
  const auto correlation = [&](HeightFading fading) {
    return HeightCorrelation(model->matches.means, fading, length_m);
  };
  model->correlation = {correlation(HeightFading::kLong), correlation(HeightFading::kShort)};
  auto as_long = Adjust(view, *model, stated);
  if (MedianSpacing_m(model->matches.means) > kCloseEnough * kShortHeightCorrelation * length_m)
    return as_long;
  model->correlation[0] = model->correlation[1];
  auto as_short = Adjust(view, *model, stated);
  if (!as_short) return as_long;
  if (!as_long || as_long->log_likelihood < as_short->log_likelihood + kClearlyBetter)
    return as_short;
  return as_long;
}

// Stores the trends in `estimate`.
Covariances CovariancesOf(const Adjusted& adjusted, const Model& model, const Variances& of_matches,
                          CorrelatedPose* estimate) {
  const Step& step = adjusted.last;
  const std::vector<PatchObservation>& observations = model.matches.means;
  const double fade_m = model.common.height_correlation_m;
  const double student = Student(adjusted.redundancy);
  const double factor = student * adjusted.components.noise;
  const LinearEstimator estimator{step.known * step.weighted_design.transpose(),
                                  factor * of_matches.own_px2, step.system.by_height,
                                  adjusted.components.heights};
  Covariances covariances{step.known, {}, CovarianceOfCommonHeights(estimator)};
  covariances.known += (factor - factor / student) * estimator.by_observation * model.noise *
                       estimator.by_observation.transpose();
  const Eigen::VectorXd residuals = step.Residuals();
  estimate->trends = TrendsOf(observations, residuals);
  // The covariance includes trends that heights and film explain, not those that remain as noise.
  const auto unexplained = TrendsOf(
      observations, adjusted.components.noise * model.noise * step.covariance.solve(residuals));
  covariances.honest = covariances.known +
                       CovarianceOfUnseenErrors(estimator, observations, fade_m) +
                       CovarianceOfSources(estimator, observations, model.common.half_frame_px);
  if (!unexplained.empty())
    covariances.honest += CovarianceOfTrends(estimator, observations,
                                             std::pow(unexplained.front().rms_px, 2), fade_m);
  return covariances;
}

// The estimate errs by at most the prior's error plus its offset from the prior. What residuals do
// not show is propagated without this limit: they, not the prior, weighted the observations.
void BoundDistance(double off_mm, const PrincipalDistancePrior& prior,
                   Eigen::MatrixXd* covariance) {
  const double variance = (*covariance)(6, 6);
  const double most = off_mm * off_mm + prior.sigma_mm * prior.sigma_mm;
  if (variance <= most) return;
  const Eigen::VectorXd with_distance = covariance->col(6);
  *covariance -= (1 - most / variance) / variance * with_distance * with_distance.transpose();
}

}  // namespace

std::optional<CorrelatedPose> EstimateCorrelatedPose(
    const PhotoView& view, const PosePrior& prior, const std::vector<PatchObservation>& all,
    const CommonErrors& common, const std::optional<PrincipalDistancePrior>& unknown) {
  if (all.size() < kMinObservations) return std::nullopt;
  const GroupedMatches matches = Group(all);
  const OwnCovariances own = OwnCovariancesOf(matches.means);
  Model model{matches,
              common,
              prior,
              unknown,
              own.measured,
              FilmCovariance(matches.means, common) + own.open,
              PriorInformation(prior, unknown),
              {}};
  const Variances of_matches = VariancesOf(all);
  const auto adjusted = AdjustAsResidualsSay(view, &model, of_matches.stated);
  if (!adjusted) return std::nullopt;
  CorrelatedPose estimate;
  Covariances covariances = CovariancesOf(*adjusted, model, of_matches, &estimate);
  const double distance_mm = adjusted->view.camera.principal_distance_mm;
  if (unknown) BoundDistance(distance_mm - unknown->value_mm, *unknown, &covariances.honest);
  if (!covariances.honest.allFinite() || !(distance_mm > 0)) return std::nullopt;
  estimate.pose = adjusted->view.pose;
  estimate.noise_factor = adjusted->components.noise;
  estimate.height_factor = adjusted->components.heights[0];
  estimate.covariance = covariances.known.topLeftCorner<6, 6>();
  estimate.honest_covariance = covariances.honest.topLeftCorner<6, 6>();
  estimate.common_height_covariance = covariances.common_height_covariance.topLeftCorner<6, 6>();
  estimate.principal_distance_mm = distance_mm;
  if (!unknown) return estimate;
  estimate.principal_distance_sigma_mm = std::sqrt(covariances.honest(6, 6));
  estimate.with_distance = covariances.honest;
  return estimate;
}

}  // namespace orient::exterior
