#include "exterior/steps/resect.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

#include "core/base/chi_square.h"
#include "core/base/median.h"
#include "core/terrain/pixel_derivatives.h"
#include "core/terrain/view_over_ground.h"
#include "exterior/steps/linearised_matches.h"

namespace orient::exterior {
namespace {

const double kChi2Limit = ChiSquareLimit(2, 2.73944481876837e-3);  // 11.8
constexpr std::size_t kMinObservations = 4;
constexpr double kCauchyScale = 2.0;
constexpr double kNearlyAsBad = 0.7;  // share of the worst value
constexpr int kMaxPasses = 4;
// Largest factor on the heights' stated variance: beyond, houses and trees would pass for terrain.
constexpr double kMaxDoubt = 9;
constexpr double kWorseHeights = 1.2;  // variance component beyond which heights are doubted

// Covariance of one observation including its height error, as needed to test for gross errors.
// Residuals smaller than expected mean that heights are better than stated, not the match: its own
// variance grows with the factor, but does not shrink with it.
Eigen::Matrix2d Covariance(const PhotoView& view, const PatchObservation& o,
                           double variance_factor) {
  const Eigen::Matrix2d covariance = std::max(variance_factor, 1.0) * o.covariance_px2;
  const auto d = PixelFromGroundWithDerivatives(view, o.ground_m);
  if (!d) return covariance;
  const Eigen::Vector2d by_height = d->by_ground * o.height_effect * o.height_sigma_m;
  const Eigen::Vector2d by_surface = d->by_ground.col(2) * o.surface_sigma_m;
  return covariance + variance_factor *
                          (by_height * by_height.transpose() + by_surface * by_surface.transpose());
}

std::vector<ControlObservation> Control(const PhotoView& view,
                                        const std::vector<PatchObservation>& observations,
                                        const std::vector<std::size_t>& used,
                                        double variance_factor) {
  const Eigen::Matrix2d& A = view.photo_from_pixel.A;
  std::vector<ControlObservation> control;
  for (const std::size_t i : used)
    control.push_back({observations[i].ground_m, view.PhotoFromPixel(observations[i].pixel),
                       A * Covariance(view, observations[i], variance_factor) * A.transpose()});
  return control;
}

// v' P v of one observation with the a-priori weights of `control`.
double Chi2(const ControlObservation& control, const Eigen::Vector2d& residual_mm) {
  return residual_mm.dot(control.covariance_mm2.inverse() * residual_mm);
}

// Robust: half of the residuals may be gross errors. The median of chi-square with two degrees of
// freedom is 2 ln 2; edges have only one and are left out.
double MedianVarianceFactor(const std::vector<ControlObservation>& control,
                            const std::vector<Eigen::Vector2d>& residuals) {
  std::vector<double> chi2;
  for (std::size_t i = 0; i < control.size(); ++i)
    if (!IsOfEdge(control[i].covariance_mm2)) chi2.push_back(Chi2(control[i], residuals[i]));
  if (chi2.empty()) return 1;
  return UpperMedian(std::move(chi2)) / (2 * std::log(2.0));
}

// Squared residuals of two dimensions, normalised with their covariance and redundancy.
std::vector<double> NormalisedChi2(const std::vector<ControlObservation>& control,
                                   const ResectionResult& fit) {
  std::vector<double> chi2;
  for (std::size_t i = 0; i < control.size(); ++i)
    chi2.push_back(Chi2(control[i], fit.residuals_mm[i]) / std::max(fit.redundancy[i] / 2, 0.05));
  return chi2;
}

// Removes the worst from `used`, and those nearly as bad: one at a time, as in textbooks, would
// take as many adjustments as there are gross errors. False: none is bad.
bool RemoveWorst(const std::vector<double>& chi2, std::vector<std::size_t>* used) {
  const double worst = *std::max_element(chi2.begin(), chi2.end());
  if (worst <= kChi2Limit) return false;
  const double limit = std::max(kChi2Limit, kNearlyAsBad * worst);
  std::vector<std::size_t> kept;
  for (std::size_t i = 0; i < chi2.size(); ++i)
    if (chi2[i] < limit && chi2[i] < worst) kept.push_back((*used)[i]);
  *used = std::move(kept);
  return true;
}

double MeanSigmaPx(const std::vector<PatchObservation>& observations,
                   const std::vector<std::size_t>& used) {
  double sum = 0;
  for (const std::size_t i : used) sum += OwnVariance(observations[i]);
  return std::sqrt(sum / static_cast<double>(used.size()));
}

// Areas of the ellipses in which the observations' squared residuals stay below the limit.
std::vector<double> PassingAreas(const PhotoView& view,
                                 const std::vector<PatchObservation>& observations,
                                 double variance_factor) {
  std::vector<double> areas_px2;
  for (const PatchObservation& o : observations)
    areas_px2.push_back(std::numbers::pi * kChi2Limit *
                        std::sqrt(Covariance(view, o, variance_factor).determinant()));
  return areas_px2;
}

void FillResiduals(const PhotoView& view, const std::vector<PatchObservation>& observations,
                   PoseEstimate* estimate) {
  PhotoView solved = view;
  solved.pose = estimate->pose;
  for (const PatchObservation& o : observations) {
    const auto pixel = solved.PixelFromGround(o.ground_m);
    estimate->residuals_px.push_back(pixel ? Eigen::Vector2d(o.pixel - *pixel)
                                           : Eigen::Vector2d::Constant(std::nan("")));
  }
}

constexpr int kAddedNoisePasses = 3;
constexpr double kMostAdded_px = 2;  // of the resolution at which was matched
// Log likelihood by which a common factor must explain the residuals better than an added variance:
// few residuals hardly decide, and only the latter keeps gross errors from hiding in poor textures.
constexpr double kClearlyBetter = 5;

// Variance, px^2, that must be added to all for the median residual to be as expected.
double AddedVariance(const PhotoView& view, const std::vector<ControlObservation>& control,
                     const std::vector<Eigen::Vector2d>& residuals_mm, double already_px2,
                     double most_px2) {
  const Eigen::Matrix2d pixel_mm2 = view.photo_from_pixel.A * view.photo_from_pixel.A.transpose();
  const auto factor = [&](double added_px2) {
    std::vector<ControlObservation> with = control;
    for (ControlObservation& c : with) c.covariance_mm2 += (added_px2 - already_px2) * pixel_mm2;
    return MedianVarianceFactor(with, residuals_mm);
  };
  if (factor(0) <= 1) return 0;
  double low = 0, high = most_px2;
  for (int i = 0; i < 40; ++i) {
    const double middle = (low + high) / 2;
    (factor(middle) > 1 ? low : high) = middle;
  }
  return high;
}

// Log likelihood of the residuals if covariances are the control's times a factor; all gross errors
// count the same.
double LogLikelihood(const std::vector<ControlObservation>& control,
                     const std::vector<Eigen::Vector2d>& residuals_mm, double factor) {
  double sum = 0;
  for (std::size_t i = 0; i < control.size(); ++i)
    sum -= std::min(Chi2(control[i], residuals_mm[i]) / factor, kChi2Limit) / 2 +
           std::log(factor * factor * control[i].covariance_mm2.determinant()) / 2;
  return sum;
}

std::vector<PatchObservation> Added(std::vector<PatchObservation> observations,
                                    double variance_px2) {
  for (PatchObservation& o : observations) {
    o.covariance_px2 += variance_px2 * Eigen::Matrix2d::Identity();
    // Each surveyed point was measured independently in its image.
    if (o.height_sigma_m == 0) o.ground_px2 += variance_px2;
  }
  return observations;
}

// Variance to add, px^2. Least-squares matching knows its images' noise, but neither changes on the
// ground nor relief too small for the chip's heights. Unless residuals clearly favour a factor, a
// variance common to all is added: otherwise the best textures, displaced least by noise, would get
// most weight, and gross errors would go unnoticed beside their residuals.
double VarianceToAdd(const PhotoView& view, const PosePrior& prior,
                     const std::vector<PatchObservation>& matched, int reduction) {
  const double most_px2 = std::pow(kMostAdded_px * reduction, 2);
  std::vector<std::size_t> all(matched.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  ResectionOptions robust;
  robust.prior = prior;
  robust.robust_scale = kCauchyScale;
  std::vector<PatchObservation> with = matched;
  double added_px2 = 0, of_factor = 0, of_sum = -std::numeric_limits<double>::infinity();
  for (int i = 0; i <= kAddedNoisePasses; ++i) {
    const auto control = Control(view, with, all, 1);
    const auto fit = Resect(view.camera, control, view.pose, robust);
    if (!fit) return 0;
    const double factor = MedianVarianceFactor(control, fit->residuals_mm);
    (i == 0 ? of_factor : of_sum) =
        LogLikelihood(control, fit->residuals_mm, std::max(factor, 1.0));
    const double now_px2 = AddedVariance(view, control, fit->residuals_mm, added_px2, most_px2);
    if (now_px2 == 0) return 0;
    with = Added(matched, now_px2);
    added_px2 = now_px2;
  }
  return of_sum > of_factor - kClearlyBetter ? added_px2 : 0;
}

struct Snooped {
  ResectionResult fit;
  std::vector<std::size_t> used;
  double variance_factor = 1;
};

// Removes gross errors, the worst first.
std::optional<Snooped> Snoop(const PhotoView& view, const PosePrior& prior,
                             const std::vector<PatchObservation>& observations) {
  Snooped state;
  for (std::size_t i = 0; i < observations.size(); ++i) state.used.push_back(i);
  ResectionOptions robust;
  robust.prior = prior;
  robust.robust_scale = kCauchyScale;
  const auto start_control = Control(view, observations, state.used, 1);
  auto fit = Resect(view.camera, start_control, view.pose, robust);
  if (!fit) return std::nullopt;
  state.variance_factor = std::max(MedianVarianceFactor(start_control, fit->residuals_mm), 1e-4);

  ResectionOptions plain;
  plain.prior = prior;
  while (state.used.size() >= kMinObservations) {
    const auto control = Control(view, observations, state.used, state.variance_factor);
    // The robust fit judges while many gross errors may remain, the plain one at the end.
    fit = Resect(view.camera, control, fit->pose, robust);
    if (!fit) return std::nullopt;
    if (RemoveWorst(NormalisedChi2(control, *fit), &state.used)) continue;
    const auto final_fit = Resect(view.camera, control, fit->pose, plain);
    if (!final_fit) return std::nullopt;
    if (RemoveWorst(NormalisedChi2(control, *final_fit), &state.used)) continue;
    state.fit = *final_fit;
    return state;
  }
  return std::nullopt;
}

// The fit without gross errors, then the one that accounts for errors shared by the observations.
struct Fit {
  Snooped snooped;
  CorrelatedPose correlated;
};

std::optional<Fit> SnoopAndFit(const PhotoView& view, const PosePrior& prior,
                               const std::vector<PatchObservation>& observations,
                               const CommonErrors& common) {
  auto snooped = Snoop(view, prior, observations);
  if (!snooped) return std::nullopt;
  std::vector<PatchObservation> kept;
  for (const std::size_t i : snooped->used) kept.push_back(observations[i]);
  PhotoView near_view = view;
  near_view.pose = snooped->fit.pose;
  const auto correlated = EstimateCorrelatedPose(near_view, prior, kept, common);
  if (!correlated) return std::nullopt;
  return Fit{std::move(*snooped), *correlated};
}

}  // namespace

std::optional<PoseEstimate> EstimatePose(const PhotoView& view, const PosePrior& prior,
                                         const std::vector<PatchObservation>& matched,
                                         const CommonErrors& common) {
  if (matched.size() < kMinObservations) return std::nullopt;
  const double added_px2 = VarianceToAdd(view, prior, matched, common.reduction);
  const std::vector<PatchObservation> observations = Added(matched, added_px2);
  auto fit = SnoopAndFit(view, prior, observations, common);
  if (!fit) return std::nullopt;
  // Heights worse than stated made good observations look like gross errors: repeat with the
  // variance that the residuals imply for them.
  std::vector<PatchObservation> doubted = observations;
  double doubt = 1;
  for (int i = 1; i < kMaxPasses && fit->correlated.height_factor > kWorseHeights; ++i) {
    const double more = std::min(fit->correlated.height_factor, kMaxDoubt / doubt);
    if (more < kWorseHeights) break;
    doubt *= more;
    for (PatchObservation& o : doubted) o.height_sigma_m *= std::sqrt(more);
    auto again = SnoopAndFit(view, prior, doubted, common);
    if (!again) break;
    fit = std::move(again);
  }
  const Snooped& snooped = fit->snooped;
  const CorrelatedPose& correlated = fit->correlated;

  PoseEstimate estimate;
  estimate.added_px2 = added_px2;
  estimate.pose = correlated.pose;
  estimate.covariance = correlated.covariance;
  estimate.honest_covariance = correlated.honest_covariance;
  estimate.common_height_covariance = correlated.common_height_covariance;
  estimate.sigma0_px = std::sqrt(correlated.noise_factor) * MeanSigmaPx(observations, snooped.used);
  const Vector6d shift = PoseDifference(correlated.pose, prior.pose);
  estimate.prior_chi2 = shift.dot(prior.covariance.ldlt().solve(shift));
  estimate.rejected.assign(observations.size(), true);
  for (const std::size_t i : snooped.used) estimate.rejected[i] = false;
  estimate.used = static_cast<int>(snooped.used.size());
  estimate.trends = correlated.trends;
  FillResiduals(view, observations, &estimate);
  estimate.passing_px2 = PassingAreas(view, doubted, snooped.variance_factor);
  return estimate;
}

const double kMostApart = ChiSquareLimit(6, 1e-4);

double Apart(const PosePrior& one, const PosePrior& other) {
  const Vector6d off = PoseDifference(one.pose, other.pose);
  const Matrix6d sum = other.covariance + one.covariance;
  return off.dot(sum.ldlt().solve(off));
}

namespace {

// `unknowns_of`: the derivatives by the unknowns that the covariance is of.
template <typename Covariance, typename UnknownsOf>
double WorstSigma(const PhotoView& view, const Covariance& covariance, double height_m,
                  const UnknownsOf& unknowns_of) {
  constexpr double kUnknown = std::numeric_limits<double>::infinity();
  double worst = -1;  // no point of the frame shows the ground yet
  for (const SeenPlace& place : OutermostInFrame(view.camera, view.pose, height_m)) {
    const auto d = PixelFromGroundWithDerivatives(view, place.ground_m);
    if (!d) continue;
    const auto by_unknowns = unknowns_of(*d);
    const Eigen::Matrix2d pixel_covariance = by_unknowns * covariance * by_unknowns.transpose();
    const double variance = pixel_covariance.diagonal().maxCoeff();
    if (!(variance >= 0)) return kUnknown;
    worst = std::max(worst, std::sqrt(variance));
  }
  return worst < 0 ? kUnknown : worst;
}

}  // namespace

double WorstProjectionSigma(const PhotoView& view, const Matrix6d& covariance, double height_m) {
  return WorstSigma(view, covariance, height_m,
                    [](const PixelDerivatives& d) { return d.by_pose; });
}

double WorstSigmaWithDistance(const PhotoView& view, const Matrix7d& covariance, double height_m) {
  return WorstSigma(view, covariance, height_m, [](const PixelDerivatives& d) {
    Eigen::Matrix<double, 2, 7> by_unknowns;
    by_unknowns << d.by_pose, d.by_principal_distance;
    return by_unknowns;
  });
}

}  // namespace orient::exterior
