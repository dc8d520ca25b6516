#include "core/matching/least_squares_matching.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "core/geometry/principal_axes.h"
#include "core/raster/resample.h"
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

// No step moves a corner of the template farther than this: beyond, the linearisation is a guess.
constexpr double kMaxStepPx = 2;
// Least share of the position's information that both images agree upon. Noise gives gradients too,
// in every direction, but not the same ones on both sides: along an edge and in flat ground little
// is common.
constexpr double kMinCommonInformation = 0.2;
// Of the weaker to the stronger direction, of the position's information and of the template's
// smoothed gradients: below, it is an edge, ten times worse known along than across.
constexpr double kMinDirectionRatio = 0.01;
// Correlation times the square root of the number of pixels. Chance gives 1; with eight parameters
// to play with, 4 is not rare.
constexpr double kMinSignificance = 6;
// Below this standard deviation relative to the mean a template is flat.
constexpr double kFlat = 1e-6;

struct TemplatePixel {
  Eigen::Vector2d u;         // from the reference point, in units of the template's half size
  double value = 0;          // normalised: mean 0, deviation 1
  Eigen::Vector2d gradient;  // of that value, per template pixel
};

struct Template {
  std::vector<TemplatePixel> pixels;
  double mean = 0, deviation = 0;
  double half_size = 1;
  std::vector<Eigen::Vector2d> corners;  // from the reference point, template pixels
};

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

// Gradients in one direction only. A sharp edge's pixel stairs look like information along it: the
// smoothed template has none.
bool IsEdge(const Image& templ) {
  constexpr double kSigma = 1;
  // The blur is one-sided at the border; a small template has to live with that.
  const int margin = std::min(templ.width, templ.height) > 12 ? 3 : 1;
  const Image smooth = GaussianBlur(templ, kSigma);
  Eigen::Matrix2d sum = Eigen::Matrix2d::Zero();
  for (int r = margin; r + margin < templ.height; ++r) {
    for (int c = margin; c + margin < templ.width; ++c) {
      const Eigen::Vector2d gradient(double(smooth.At(c + 1, r)) - double(smooth.At(c - 1, r)),
                                     double(smooth.At(c, r + 1)) - double(smooth.At(c, r - 1)));
      if (gradient.allFinite()) sum += gradient * gradient.transpose();
    }
  }
  const PrincipalAxes axes = AxesOf(sum);
  return !(axes.values[0] > kMinDirectionRatio * axes.values[1]);
}

std::optional<Template> Prepare(const Image& image, const Eigen::Vector2d& reference) {
  Template t;
  double sum = 0, squares = 0;
  for (const float value : image.values)
    if (std::isfinite(value)) sum += double(value), t.mean += 1;
  if (t.mean < 2) return std::nullopt;
  const double count = t.mean;
  t.mean = sum / count;
  for (const float value : image.values)
    if (std::isfinite(value)) squares += (double(value) - t.mean) * (double(value) - t.mean);
  t.deviation = std::sqrt(squares / count);
  if (!(t.deviation > kFlat * std::abs(t.mean))) return std::nullopt;
  if (IsEdge(image)) return std::nullopt;
  t.half_size = std::max(image.width, image.height) / 2.0;
  const SplineImage spline(image, {0, 0, image.width, image.height});
  // The outer ring has no neighbours on one side, hence no gradient.
  for (int r = 1; r + 1 < image.height; ++r) {
    for (int c = 1; c + 1 < image.width; ++c) {
      if (!std::isfinite(image.At(c, r))) continue;
      TemplatePixel pixel;
      const Eigen::Vector2d centre(c + 0.5, r + 0.5);
      pixel.u = (centre - reference) / t.half_size;
      pixel.value = (double(image.At(c, r)) - t.mean) / t.deviation;
      double unused = 0;
      if (!spline.Sample(centre, &unused, &pixel.gradient)) continue;
      pixel.gradient /= t.deviation;
      t.pixels.push_back(pixel);
    }
  }
  for (const double x : {0.0, double(image.width)})
    for (const double y : {0.0, double(image.height)})
      t.corners.push_back(Eigen::Vector2d(x, y) - reference);
  return t;
}

class Matcher {
 public:
  Matcher(const Template& templ, const SplineImage& image, const LsmOptions& options)
      : templ_(templ), image_(image), options_(options) {
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
    return s.count > parameters_ &&
           s.count >= kMinValidShare * static_cast<double>(templ_.pixels.size());
  }
  // One Gauss-Newton step; the movement of the farthest of reference point and corners, px. Empty:
  // singular.
  std::optional<double> Step(const System& s, State* state) const;
  std::optional<Eigen::Matrix2d> PositionCovariance(const System& s) const;
  double Sigma0(const System& s) const {
    return std::sqrt(s.squares / static_cast<double>(s.count - parameters_));
  }

 private:
  void Row(const Eigen::Vector2d& gradient, const TemplatePixel& pixel, const Eigen::Matrix2d& A,
           Parameters* row) const;

  const Template& templ_;
  const SplineImage& image_;
  const LsmOptions& options_;
  int geometric_ = 0, parameters_ = 0;
};

void Matcher::Row(const Eigen::Vector2d& g, const TemplatePixel& pixel, const Eigen::Matrix2d& A,
                  Parameters* row) const {
  row->head<2>() = g;
  if (options_.geometry == LsmGeometry::kSimilarity) {
    const Eigen::Vector2d w = A * pixel.u;
    row->segment<2>(2) << g.dot(w), g.y() * w.x() - g.x() * w.y();
  } else if (options_.geometry == LsmGeometry::kAffine) {
    row->segment<4>(2) << g.x() * pixel.u, g.y() * pixel.u;
  }
  if (options_.radiometric) row->tail<2>() << -1, -pixel.value;
}

System Matcher::SumUp(const State& state) const {
  System s;
  s.templ = s.common = Normals::Zero(parameters_, parameters_);
  s.right = Parameters::Zero(parameters_);
  Parameters from_image(parameters_), from_template(parameters_);
  const Eigen::Matrix2d turn = state.gain * state.A.inverse().transpose();
  for (const TemplatePixel& pixel : templ_.pixels) {
    double value = 0;
    Eigen::Vector2d gradient;
    const Eigen::Vector2d place = state.position + templ_.half_size * (state.A * pixel.u);
    if (!image_.Sample(place, &value, &gradient)) continue;
    Row(gradient, pixel, state.A, &from_image);
    Row(turn * pixel.gradient, pixel, state.A, &from_template);
    const double residual = value - state.offset - state.gain * pixel.value;
    s.templ.selfadjointView<Eigen::Lower>().rankUpdate(from_template);
    s.common.selfadjointView<Eigen::Lower>().rankUpdate(from_image, from_template, 0.5);
    s.right -= residual * from_template;
    s.squares += residual * residual;
    ++s.count;
    s.sum += value;
    s.sum_of_squares += value * value;
    s.t += pixel.value;
    s.tt += pixel.value * pixel.value;
    s.product += value * pixel.value;
  }
  s.templ = Normals(s.templ.selfadjointView<Eigen::Lower>());
  s.common = Normals(s.common.selfadjointView<Eigen::Lower>());
  return s;
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

// What the parameters other than the position leave over for it (Schur complement).
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
  const double weakest = of_common.values[0];
  if (!(weakest > kMinCommonInformation * of_templ.values[0]) ||
      !(weakest > kMinDirectionRatio * of_common.values[1]))
    return std::nullopt;
  const Eigen::LLT<Normals> solver(s.common);
  const Normals spread = 0.5 * (s.templ + s.common);
  const Normals left = solver.solve(spread);
  const Normals covariance = solver.solve(Normals(left.transpose()));
  const double sigma0 = Sigma0(s);
  return Eigen::Matrix2d(sigma0 * sigma0 * covariance.topLeftCorner<2, 2>());
}

// The part of the image that the template may come to see.
PixelWindow Neighbourhood(const Template& templ, const State& state, const LsmOptions& options) {
  double reach = 0;
  for (const Eigen::Vector2d& corner : templ.corners)
    reach = std::max(reach, (state.A * corner).norm() + options.max_deformation * corner.norm());
  constexpr double kMargin = 10;       // the spline's memory
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

LsmResult ResultOf(const State& state, const Template& templ, const Eigen::Vector2d& reference) {
  LsmResult result;
  result.image_from_template = {state.A, state.position - state.A * reference};
  result.position = state.position;
  result.gain = state.gain / templ.deviation;
  result.offset = state.offset - result.gain * templ.mean;
  return result;
}

}  // namespace

std::optional<LsmResult> MatchLeastSquares(const Image& templ, const Image& image,
                                           const Eigen::Vector2d& reference, const Affine2d& start,
                                           const LsmOptions& options) {
  State state{start * reference, start.A};
  if (!state.position.allFinite() || !(std::abs(start.A.determinant()) > 1e-6))
    throw std::invalid_argument("MatchLeastSquares: the start is singular or not finite");
  const std::optional<Template> prepared = Prepare(templ, reference);
  if (!prepared) return std::nullopt;
  const Eigen::Vector2d image_size(image.width, image.height);
  if ((state.position - image_size / 2).cwiseAbs().maxCoeff() > 1e6) return std::nullopt;
  const SplineImage spline(image, Neighbourhood(*prepared, state, options));
  const Matcher matcher(*prepared, spline, options);
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
    LsmResult result = ResultOf(state, *prepared, reference);
    result.covariance = *covariance;
    result.correlation = correlation;
    result.sigma0 = matcher.Sigma0(last);
    result.iterations = iteration;
    return result;
  }
  return std::nullopt;
}

}  // namespace orient
