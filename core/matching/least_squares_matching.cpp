#include "core/matching/least_squares_matching.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>
#include <vector>

#include "core/geometry/principal_axes.h"
#include "core/matching/lsm_template.h"
#include "core/raster/spline_image.h"

namespace orient {
namespace {

constexpr double kConvergence_px = 1e-3;  // of the reference point and of the template's corners
// Share of template pixels that must meet valid image pixels.
constexpr double kMinValidShare = 0.6;
constexpr int kMaxParameters = 8;
using Parameters = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxParameters, 1>;
using Normals =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxParameters, kMaxParameters>;

// No step moves a corner of the template farther than this: beyond, the linearisation is not valid.
constexpr double kMaxStepPx = 2;
// Least share of the position's information common to both images. Noise produces gradients, too,
// in every direction, but different ones in the two images: along an edge and in flat areas little
// is common.
constexpr double kMinCommonInformation = 0.2;
// Ratio of weaker to stronger direction, of the position's information and of the template's
// smoothed gradients: below, it is an edge, with a sigma along it ten times the one across.
constexpr double kMinDirectionRatio = 0.01;
// Correlation times the square root of the number of pixels. Chance gives 1; with eight parameters
// to adjust, 4 is not rare.
constexpr double kMinSignificance = 6;
struct State {
  Eigen::Vector2d position;
  Eigen::Matrix2d A;
  double offset = 0, gain = 1;  // to the normalised template
};

// Sums over the pixels of one iteration. The residuals are projected on the template's gradients
// only: the image's own gradients share its noise, and (because interpolation smooths noise between
// pixel centres more than at them) that pulls a match towards half pixels, measured at 0.1 px for
// noise of a third of the contrast. The template is not interpolated.
struct System {
  Normals templ;   // template's gradients squared
  Normals common;  // template's times image's, symmetrised: free of the noise's share
  Parameters right;
  double squares = 0;
  int count = 0;
  double sum = 0, sum_of_squares = 0, t = 0, tt = 0, product = 0;  // for the correlation
};

using Direction = std::optional<Eigen::Vector2d>;

class Matcher {
 public:
  // `along`: direction of an edge, in which the position remains undetermined.
  Matcher(const LsmTemplate& templ, const SplineImage& image, const LsmOptions& options,
          const Direction& along)
      : templ_(templ), image_(image), options_(options), along_(along) {
    geometric_ = options.geometry == LsmGeometry::kShift        ? 2
                 : options.geometry == LsmGeometry::kSimilarity ? 4
                                                                : 6;
    parameters_ = geometric_ + (options.radiometric ? 2 : 0);
  }

  // Offset and gain that give the template the image's mean and contrast. False: too few pixels
  // or flat.
  bool StartRadiometry(State* state) const {
    state->offset = templ_.mean;
    state->gain = templ_.deviation;
    const System s = SumUp(*state);
    if (!Enough(s)) return false;
    const double variance = s.sum_of_squares / s.count - (s.sum / s.count) * (s.sum / s.count);
    if (!(variance > 0)) return false;
    if (!options_.radiometric) return true;
    state->offset = s.sum / s.count;
    state->gain = std::sqrt(variance);
    return true;
  }

  System SumUp(const State& state) const;
  bool Enough(const System& s) const {
    return s.count > parameters_ && s.count >= kMinValidShare * templ_.known.sum();
  }
  // One Gauss-Newton step; the movement of the farthest of reference point and corners, px. Empty:
  // singular.
  std::optional<double> Step(const System& s, State* state) const;
  std::optional<Eigen::Matrix2d> PositionCovariance(const System& s) const;
  double Sigma0(const System& s) const {
    return std::sqrt(s.squares / static_cast<double>(s.count - parameters_));
  }

 private:
  // One row per pixel, one column per parameter.
  using Design =
      Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, Eigen::Dynamic, kMaxParameters>;
  SplineSamples ImageAt(const State& state) const;
  void LeaveOpen(System* s) const;
  Design DesignOf(const Eigen::ArrayXd& by_col, const Eigen::ArrayXd& by_row,
                  const Eigen::ArrayXd& known, const Eigen::Matrix2d& A) const;

  const LsmTemplate& templ_;
  const SplineImage& image_;
  const LsmOptions& options_;
  Direction along_;
  int geometric_ = 0, parameters_ = 0;
};

// The image at the template's transformed pixels; a mere shift keeps them on a grid.
SplineSamples Matcher::ImageAt(const State& state) const {
  if (state.A.isIdentity(0))
    return image_.SampleGrid(state.position + templ_.first, templ_.cols, templ_.rows);
  const Eigen::Index count = templ_.known.size();
  SplineSamples samples{Eigen::ArrayXd::Zero(count), Eigen::ArrayXd::Zero(count),
                        Eigen::ArrayXd::Zero(count), Eigen::ArrayXd::Zero(count)};
  Eigen::Vector2d gradient;
  for (Eigen::Index i = 0; i < count; ++i) {
    if (templ_.known[i] == 0) continue;
    const Eigen::Vector2d u(templ_.u[i], templ_.v[i]);
    if (!image_.Sample(state.position + templ_.half_size * (state.A * u), &samples.value[i],
                       &gradient))
      continue;
    samples.by_col[i] = gradient.x();
    samples.by_row[i] = gradient.y();
    samples.known[i] = 1;
  }
  return samples;
}

Matcher::Design Matcher::DesignOf(const Eigen::ArrayXd& by_col, const Eigen::ArrayXd& by_row,
                                  const Eigen::ArrayXd& known, const Eigen::Matrix2d& A) const {
  Design design(known.size(), parameters_);
  const Eigen::ArrayXd col = by_col * known, row = by_row * known;
  design.col(0) = col;
  design.col(1) = row;
  if (options_.geometry == LsmGeometry::kSimilarity) {
    const Eigen::ArrayXd x = A(0, 0) * templ_.u + A(0, 1) * templ_.v;
    const Eigen::ArrayXd y = A(1, 0) * templ_.u + A(1, 1) * templ_.v;
    design.col(2) = col * x + row * y;
    design.col(3) = row * x - col * y;
  } else if (options_.geometry == LsmGeometry::kAffine) {
    design.col(2) = col * templ_.u;
    design.col(3) = col * templ_.v;
    design.col(4) = row * templ_.u;
    design.col(5) = row * templ_.v;
  }
  if (options_.radiometric) {
    design.col(parameters_ - 2) = -known;
    design.col(parameters_ - 1) = -known * templ_.value;
  }
  return design;
}

System Matcher::SumUp(const State& state) const {
  const SplineSamples image = ImageAt(state);
  const Eigen::ArrayXd known = image.known * templ_.known;
  const Eigen::Matrix2d turn = state.gain * state.A.inverse().transpose();
  const Design from_image = DesignOf(image.by_col, image.by_row, known, state.A);
  const Design from_template =
      DesignOf(turn(0, 0) * templ_.by_col + turn(0, 1) * templ_.by_row,
               turn(1, 0) * templ_.by_col + turn(1, 1) * templ_.by_row, known, state.A);
  const Eigen::ArrayXd value = known * image.value, templ = known * templ_.value;
  const Eigen::VectorXd residuals = value - known * state.offset - state.gain * templ;
  System s;
  s.templ = from_template.transpose() * from_template;
  const Normals product = from_image.transpose() * from_template;
  s.common = 0.5 * (product + product.transpose());
  s.right = -from_template.transpose() * residuals;
  s.squares = residuals.squaredNorm();
  s.count = static_cast<int>(known.sum());
  s.sum = value.sum();
  s.sum_of_squares = value.square().sum();
  s.t = templ.sum();
  s.tt = templ.square().sum();
  s.product = (value * templ).sum();
  if (along_) LeaveOpen(&s);
  return s;
}

// Suppresses motion along the edge and leaves next to no information in that direction.
void Matcher::LeaveOpen(System* s) const {
  const Eigen::Matrix2d along = *along_ * along_->transpose();
  const Eigen::Matrix2d across = Eigen::Matrix2d::Identity() - along;
  const double information = std::pow(Sigma0(*s) / kOpenAlongEdge_px, 2);
  for (Normals* normals : {&s->templ, &s->common}) {
    normals->topRows<2>() = across * normals->topRows<2>().eval();
    normals->leftCols<2>() = normals->leftCols<2>().eval() * across;
    normals->topLeftCorner<2, 2>() += information * along;
  }
  s->right.head<2>() = across * s->right.head<2>().eval();
}

std::optional<double> Matcher::Step(const System& s, State* state) const {
  // Mean of both sides' gradients: converges faster than either (Malis 2004).
  const Eigen::LDLT<Normals> solver(0.5 * (s.templ + s.common));
  if (solver.info() != Eigen::Success || !(solver.rcond() > 1e-14)) return std::nullopt;
  const Parameters d = solver.solve(s.right);
  if (!d.allFinite()) return std::nullopt;
  Eigen::Matrix2d dA = Eigen::Matrix2d::Zero();
  if (options_.geometry == LsmGeometry::kSimilarity)
    dA = (Eigen::Matrix2d() << d[2], -d[3], d[3], d[2]).finished() * state->A;
  else if (options_.geometry == LsmGeometry::kAffine)
    dA << d[2], d[3], d[4], d[5];
  dA /= templ_.half_size;
  double movement = d.head<2>().norm();
  for (const Eigen::Vector2d& corner : templ_.corners)
    movement = std::max(movement, (d.head<2>() + dA * corner).norm());
  const double part = movement > kMaxStepPx ? kMaxStepPx / movement : 1;
  state->position += part * d.head<2>();
  state->A += part * dA;
  if (options_.radiometric) {
    state->offset += part * d[parameters_ - 2];
    state->gain += part * d[parameters_ - 1];
  }
  return movement;
}

// Information on the position after elimination of the other parameters (Schur complement).
std::optional<Eigen::Matrix2d> PositionInformation(const Normals& normals) {
  const Eigen::LLT<Normals> solver(normals);
  if (solver.info() != Eigen::Success) return std::nullopt;
  const Normals inverse = solver.solve(Normals::Identity(normals.rows(), normals.cols()));
  if (!inverse.allFinite()) return std::nullopt;
  return Eigen::Matrix2d(inverse.topLeftCorner<2, 2>()).inverse();
}

// Gauss-Newton with noisy gradients: the estimate's spread is that of the right-hand side, seen
// through the part of the normals that is signal. The noise of the template's gradients adds to
// that spread where it meets the image's noise, but not where it meets its own (antisymmetric
// derivative); both images being equally noisy, half of it counts.
std::optional<Eigen::Matrix2d> Matcher::PositionCovariance(const System& s) const {
  const auto templ = PositionInformation(s.templ), common = PositionInformation(s.common);
  if (!templ || !common) return std::nullopt;
  const PrincipalAxes of_templ = AxesOf(*templ), of_common = AxesOf(*common);
  const Eigen::Index weakest = along_ ? 1 : 0;
  if (!(of_common.values[weakest] > kMinCommonInformation * of_templ.values[weakest]) ||
      !(of_common.values[weakest] > kMinDirectionRatio * of_common.values[1]))
    return std::nullopt;
  const Eigen::LLT<Normals> solver(s.common);
  const Normals spread = 0.5 * (s.templ + s.common);
  const Normals left = solver.solve(spread);
  const Normals covariance = solver.solve(Normals(left.transpose()));
  const double sigma0 = Sigma0(s);
  return Eigen::Matrix2d(sigma0 * sigma0 * covariance.topLeftCorner<2, 2>());
}

// The part of the image that the template may cover.
PixelWindow Neighbourhood(const LsmTemplate& templ, const State& state, const LsmOptions& options) {
  double reach = 0;
  for (const Eigen::Vector2d& corner : templ.corners)
    reach = std::max(reach, (state.A * corner).norm() + options.max_deformation * corner.norm());
  constexpr double kMargin = 10;       // reach of the spline filter
  constexpr double kWholeImage = 1e6;  // farther than any image reaches
  reach = std::min(reach + options.max_shift_px + kMargin, kWholeImage);
  const Eigen::Vector2d first = state.position.array() - reach;
  const int size = static_cast<int>(std::ceil(2 * reach));
  return {static_cast<int>(std::floor(first.x())), static_cast<int>(std::floor(first.y())), size,
          size};
}

double Correlation(const System& s) {
  const double n = s.count;
  const double vi = s.sum_of_squares - s.sum * s.sum / n, vt = s.tt - s.t * s.t / n;
  if (!(vi > 0) || !(vt > 0)) return 0;
  return std::clamp((s.product - s.sum * s.t / n) / std::sqrt(vi * vt), -1.0, 1.0);
}

LsmResult ResultOf(const State& state, const LsmTemplate& templ, const Eigen::Vector2d& reference) {
  LsmResult result;
  result.image_from_template = {state.A, state.position - state.A * reference};
  result.position = state.position;
  result.gain = state.gain / templ.deviation;
  result.offset = state.offset - result.gain * templ.mean;
  return result;
}

std::optional<LsmResult> Iterate(const Matcher& matcher, const LsmTemplate& templ,
                                 const Eigen::Vector2d& reference, const Affine2d& start,
                                 const LsmOptions& options) {
  State state{start * reference, start.A};
  if (!matcher.StartRadiometry(&state)) return std::nullopt;
  for (int iteration = 1; iteration <= options.max_iterations; ++iteration) {
    const System system = matcher.SumUp(state);
    if (!matcher.Enough(system)) return std::nullopt;
    const std::optional<double> movement = matcher.Step(system, &state);
    if (!movement || (state.position - start * reference).norm() > options.max_shift_px ||
        (state.A - start.A).norm() > options.max_deformation)
      return std::nullopt;
    if (*movement >= kConvergence_px) continue;
    const System last = matcher.SumUp(state);
    if (!matcher.Enough(last)) return std::nullopt;
    const auto covariance = matcher.PositionCovariance(last);
    const double correlation = Correlation(last);
    if (!covariance || std::abs(correlation) * std::sqrt(last.count) < kMinSignificance)
      return std::nullopt;
    LsmResult result = ResultOf(state, templ, reference);
    result.covariance = *covariance;
    result.correlation = correlation;
    result.sigma0 = matcher.Sigma0(last);
    result.iterations = iteration;
    return result;
  }
  return std::nullopt;
}

}  // namespace

std::optional<LsmResult> MatchLeastSquares(const Image& templ, const Image& image,
                                           const Eigen::Vector2d& reference, const Affine2d& start,
                                           const LsmOptions& options) {
  const State state{start * reference, start.A};
  if (!state.position.allFinite() || !(std::abs(start.A.determinant()) > 1e-6))
    throw std::invalid_argument("MatchLeastSquares: the start is singular or not finite");
  const bool edges = options.edges && options.geometry == LsmGeometry::kShift;
  const PrincipalAxes gradients = GradientAxes(templ);
  const bool is_edge = !(gradients.values[0] > kMinDirectionRatio * gradients.values[1]);
  if (is_edge && !edges) return std::nullopt;
  const std::optional<LsmTemplate> prepared = PrepareTemplate(templ, reference);
  if (!prepared) return std::nullopt;
  const Eigen::Vector2d image_size(image.width, image.height);
  if ((state.position - image_size / 2).cwiseAbs().maxCoeff() > 1e6) return std::nullopt;
  const SplineImage spline(image, Neighbourhood(*prepared, state, options));
  if (!is_edge) {
    const Matcher matcher(*prepared, spline, options, std::nullopt);
    auto result = Iterate(matcher, *prepared, reference, start, options);
    if (result || !edges) return result;
  }
  const Eigen::Vector2d along = gradients.vectors.col(0);
  auto result =
      Iterate(Matcher(*prepared, spline, options, along), *prepared, reference, start, options);
  if (result) result->along = along;
  return result;
}

}  // namespace orient
