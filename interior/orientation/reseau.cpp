#include "interior/orientation/reseau.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/base/chi_square.h"
#include "core/base/median.h"
#include "core/geometry/dense_solvers.h"
#include "core/geometry/principal_axes.h"

namespace orient::interior {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::VectorXd;

const double kContradicted = ChiSquareLimit(2, 4.53999297624849e-5);  // 20: one good cross in 22026
constexpr double kTakenBack = 12;  // chi-square of a cross rejected too early
constexpr double kLeastUsed = 0.6;
constexpr double kThinnest = 0.1;
// A larger noise is not that of crosses: the collocation then explains nothing.
constexpr double kMostNoise_um = 40;
constexpr int kTrend = 3;  // 1, x, y

// One cross: its place by the affine transform, and the residual there. In mm, photo system.
struct Cross {
  Vector2d place;
  Vector2d left;
};

// How smooth the signal is: the two cases of the Matern family that occur on film.
enum class Smoothness { kTwice, kEndless };

// Covariance of unit variance: Matern's of smoothness 5/2, or Gauss's.
double Correlation(double distance, double length, Smoothness smoothness) {
  const double s = distance / length;
  if (smoothness == Smoothness::kEndless) return std::exp(-0.5 * s * s);
  const double t = std::sqrt(5.0) * s;
  return (1 + t + t * t / 3) * std::exp(-t);
}

MatrixXd Correlations(const std::vector<Cross>& crosses, double length, Smoothness smoothness) {
  const auto n = static_cast<Eigen::Index>(crosses.size());
  MatrixXd r(n, n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j <= i; ++j)
      r(i, j) = r(j, i) =
          Correlation((crosses[i].place - crosses[j].place).norm(), length, smoothness);
  return r;
}

MatrixXd Trend(const std::vector<Cross>& crosses, double extent) {
  MatrixXd f(static_cast<Eigen::Index>(crosses.size()), kTrend);
  for (size_t i = 0; i < crosses.size(); ++i)
    f.row(static_cast<Eigen::Index>(i)) << 1, crosses[i].place.x() / extent,
        crosses[i].place.y() / extent;
  return f;
}

// The collocation's parameters and what follows from them at the crosses.
struct Collocation {
  Smoothness smoothness = Smoothness::kTwice;
  double length = 0;    // mm
  double ratio = 0;     // noise variance / signal variance
  double variance = 0;  // of the signal, mm^2
  double log_likelihood = -std::numeric_limits<double>::infinity();
  MatrixXd weights;    // V^-1 (y - F beta), unit signal; two columns
  MatrixXd trend;      // beta, two columns
  VectorXd precision;  // P_ii, unit signal
  double extent = 1;
};

// Restricted likelihood over the ratio for one length; in the trend's null space everything is
// diagonal.
class OfLength {
 public:
  OfLength(const std::vector<Cross>& crosses, Smoothness smoothness, double length, double extent)
      : smoothness_(smoothness), length_(length), extent_(extent), f_(Trend(crosses, extent)) {
    const auto n = static_cast<Eigen::Index>(crosses.size());
    y_.resize(n, 2);
    for (Eigen::Index i = 0; i < n; ++i) y_.row(i) = crosses[i].left.transpose();
    null_ = OrthogonalComplement(f_);
    r_ = Correlations(crosses, length, smoothness);
    eigen_ = EigenOfSymmetric(null_.transpose() * r_ * null_);
    z_ = eigen_.vectors.transpose() * null_.transpose() * y_;
  }

  void Improve(double ratio, Collocation* best) const {
    const VectorXd d = eigen_.values.cwiseMax(0.0).array() + ratio;
    const auto m = static_cast<double>(z_.rows());
    const double variance =
        (d.cwiseInverse().asDiagonal() * z_.cwiseAbs2()).sum() / (2 * m) + 1e-16;
    const double likelihood = -d.array().log().sum() - m * std::log(variance);
    if (likelihood <= best->log_likelihood) return;
    best->log_likelihood = likelihood;
    best->smoothness = smoothness_;
    best->length = length_;
    best->ratio = ratio;
    best->variance = variance;
    best->extent = extent_;
  }

  void Solve(Collocation* best) const {
    const VectorXd d = eigen_.values.cwiseMax(0.0).array() + best->ratio;
    const MatrixXd basis = null_ * eigen_.vectors;
    best->weights = basis * d.cwiseInverse().asDiagonal() * z_;
    best->precision = (basis.cwiseAbs2() * d.cwiseInverse());
    const MatrixXd signal = r_ * best->weights + best->ratio * best->weights;
    best->trend = LeastSquares(f_, y_ - signal);
  }

 private:
  Smoothness smoothness_;
  double length_, extent_;
  MatrixXd f_, y_, null_, r_, z_;
  SymmetricEigen eigen_;
};

double ExtentOf(const std::vector<Cross>& crosses) {
  double extent = 0;
  for (const Cross& cross : crosses) extent = std::max(extent, cross.place.norm());
  return std::max(extent, 1e-6);
}

Collocation Estimate(const std::vector<Cross>& crosses) {
  constexpr std::array kLengths = {0.15, 0.25, 0.4, 0.65, 1.0, 1.6, 2.5};  // of the half extent
  constexpr double kLeastRatio = 1e-4, kMostRatio = 1e4, kRatioStep = 1.6;
  const double extent = ExtentOf(crosses);
  Collocation best;
  std::optional<OfLength> of_best;
  for (const Smoothness smoothness : {Smoothness::kTwice, Smoothness::kEndless})
    for (const double length : kLengths) {
      OfLength of_length(crosses, smoothness, length * extent, extent);
      const double before = best.log_likelihood;
      for (double ratio = kLeastRatio; ratio < kMostRatio; ratio *= kRatioStep)
        of_length.Improve(ratio, &best);
      if (best.log_likelihood > before) of_best.emplace(std::move(of_length));
    }
  of_best->Solve(&best);
  return best;
}

Vector2d Predict(const Collocation& c, const std::vector<Cross>& crosses, const Vector2d& place) {
  Vector2d value =
      c.trend.transpose() * Eigen::Vector3d(1, place.x() / c.extent, place.y() / c.extent);
  for (size_t i = 0; i < crosses.size(); ++i)
    value += Correlation((place - crosses[i].place).norm(), c.length, c.smoothness) *
             c.weights.row(static_cast<Eigen::Index>(i)).transpose();
  return value;
}

// Gross errors must go before variances are estimated from the crosses, or they hide one another.
// A polynomial fitted by least absolute deviations (iteratively reweighted) is robust to them.
std::vector<bool> WithoutGrossErrors(const std::vector<Cross>& crosses) {
  constexpr int kRounds = 30;
  constexpr double kGross = 7, kSmallest_mm = 0.002;
  const double extent = ExtentOf(crosses);
  const auto n = static_cast<Eigen::Index>(crosses.size());
  const int terms = n >= 40 ? 10 : 6;
  MatrixXd f(n, terms), y(n, 2);
  for (Eigen::Index i = 0; i < n; ++i) {
    const double u = crosses[i].place.x() / extent, v = crosses[i].place.y() / extent;
    Eigen::Matrix<double, 10, 1> row;
    row << 1, u, v, u * u, u * v, v * v, u * u * u, u * u * v, u * v * v, v * v * v;
    f.row(i) = row.head(terms).transpose();
    y.row(i) = crosses[i].left.transpose();
  }
  VectorXd size = VectorXd::Ones(n);
  for (int round = 0; round < kRounds; ++round) {
    const VectorXd root = size.cwiseMax(kSmallest_mm).cwiseSqrt().cwiseInverse();
    const MatrixXd weighted = root.asDiagonal() * f;
    const MatrixXd p = weighted.householderQr().solve(root.asDiagonal() * y);
    size = (y - f * p).rowwise().norm();
  }
  // The median of a Rayleigh distribution is 1.18 sigma.
  const double sigma = std::max(UpperMedian({size.data(), size.data() + n}) / 1.18, kSmallest_mm);
  std::vector<bool> used;
  for (Eigen::Index i = 0; i < n; ++i) used.push_back(size[i] < kGross * sigma);
  return used;
}

// The crosses in use, and the collocation through them.
struct State {
  std::vector<bool> used;
  std::vector<size_t> index;  // of the crosses in use
  std::vector<Cross> in_use;
  Collocation fit;

  void Update(const std::vector<Cross>& crosses) {
    index.clear();
    in_use.clear();
    for (size_t i = 0; i < crosses.size(); ++i)
      if (used[i]) {
        index.push_back(i);
        in_use.push_back(crosses[i]);
      }
    if (in_use.size() >= kLeastReseauMarks) fit = Estimate(in_use);
  }
  bool Enough(size_t all) const {
    return in_use.size() >= static_cast<size_t>(kLeastReseauMarks) &&
           static_cast<double>(in_use.size()) >= kLeastUsed * static_cast<double>(all);
  }
  Vector2d LeftOut(size_t k) const {
    return fit.weights.row(static_cast<Eigen::Index>(k)).transpose() /
           fit.precision[static_cast<Eigen::Index>(k)];
  }
  double LeftOutVariance(size_t k) const {
    return fit.variance / fit.precision[static_cast<Eigen::Index>(k)];
  }
  // The most contradicted cross; empty if none is contradicted.
  std::optional<size_t> Worst() const {
    std::optional<size_t> worst;
    double most = kContradicted;
    for (size_t k = 0; k < in_use.size(); ++k) {
      const double chi_square = LeftOut(k).squaredNorm() / LeftOutVariance(k);
      if (chi_square <= most) continue;
      most = chi_square;
      worst = index[k];
    }
    return worst;
  }
};

// Takes back unused crosses that agree with those in use. The uncertainty of their prediction is
// about that of a neighbour that is left out.
bool TakeBack(const std::vector<Cross>& crosses, State* state) {
  double variance = 0;
  for (size_t k = 0; k < state->in_use.size(); ++k)
    variance += state->LeftOutVariance(k) / static_cast<double>(state->in_use.size());
  bool any = false;
  for (size_t i = 0; i < crosses.size(); ++i) {
    if (state->used[i]) continue;
    const Vector2d off = crosses[i].left - Predict(state->fit, state->in_use, crosses[i].place);
    if (off.squaredNorm() > kTakenBack * variance) continue;
    state->used[i] = true;
    any = true;
  }
  return any;
}

State UseWhatAgrees(const std::vector<Cross>& crosses) {
  State state;
  state.used = WithoutGrossErrors(crosses);
  state.Update(crosses);
  if (!state.Enough(crosses.size())) return state;
  if (TakeBack(crosses, &state)) state.Update(crosses);
  while (state.Enough(crosses.size())) {
    const auto worst = state.Worst();
    if (!worst) break;
    state.used[*worst] = false;
    state.Update(crosses);
  }
  return state;
}

FilmCorrection GridOf(const State& state, const std::vector<MeasuredMark>& marks,
                      const Affine2d& photo_from_pixel) {
  constexpr double kNodesPerLength = 5;
  constexpr int kLeastNodes = 9, kMostNodes = 41;
  Vector2d low = marks[state.index.front()].pixel, high = low;
  for (const size_t i : state.index) {
    low = low.cwiseMin(marks[i].pixel);
    high = high.cwiseMax(marks[i].pixel);
  }
  const double pixel_mm = std::sqrt(std::abs(photo_from_pixel.A.determinant()));
  const auto nodes = [&](double size_px) {
    const double count = size_px * pixel_mm * kNodesPerLength / state.fit.length;
    return std::clamp(static_cast<int>(std::ceil(count)) + 1, kLeastNodes, kMostNodes);
  };
  FilmCorrection grid;
  grid.origin_px = low;
  grid.columns = nodes(high.x() - low.x());
  grid.rows = nodes(high.y() - low.y());
  grid.step_px = (high - low).cwiseQuotient(Vector2d(grid.columns - 1, grid.rows - 1));
  for (int row = 0; row < grid.rows; ++row)
    for (int col = 0; col < grid.columns; ++col) {
      const Vector2d pixel = low + grid.step_px.cwiseProduct(Vector2d(col, row));
      grid.correction_mm.push_back(Predict(state.fit, state.in_use, photo_from_pixel * pixel));
    }
  return grid;
}

}  // namespace

std::optional<ReseauFit> FitReseau(const std::vector<MeasuredMark>& marks,
                                   const Affine2d& photo_from_pixel) {
  if (marks.size() < static_cast<size_t>(kLeastReseauMarks)) return std::nullopt;
  std::vector<Cross> crosses;
  std::vector<Vector2d> places;
  for (const MeasuredMark& mark : marks) {
    const Vector2d place = photo_from_pixel * mark.pixel;
    crosses.push_back({place, mark.photo_mm - place});
    places.push_back(place);
  }
  if (Thickness(places) <= kThinnest) return std::nullopt;  // a row of crosses

  const State state = UseWhatAgrees(crosses);
  if (!state.Enough(crosses.size())) return std::nullopt;
  ReseauFit fit;
  fit.noise_um = 1e3 * std::sqrt(state.fit.ratio * state.fit.variance);
  if (fit.noise_um > kMostNoise_um) return std::nullopt;
  fit.correction = GridOf(state, marks, photo_from_pixel);
  fit.signal_um = 1e3 * std::sqrt(state.fit.variance);
  fit.correlation_mm = state.fit.length;
  fit.used = state.used;
  fit.left_out_um.resize(marks.size(), Vector2d::Zero());
  fit.left_out_sigma_um.resize(marks.size(), 0);
  for (size_t i = 0; i < marks.size(); ++i)
    if (!state.used[i])
      fit.left_out_um[i] =
          1e3 * (crosses[i].left - Predict(state.fit, state.in_use, crosses[i].place));
  double squares = 0;
  for (size_t k = 0; k < state.index.size(); ++k) {
    fit.left_out_um[state.index[k]] = 1e3 * state.LeftOut(k);
    fit.left_out_sigma_um[state.index[k]] = 1e3 * std::sqrt(state.LeftOutVariance(k));
    squares += 1e6 * state.LeftOut(k).squaredNorm();
  }
  fit.left_out_rms_um = std::sqrt(squares / static_cast<double>(state.index.size()));
  return fit;
}

}  // namespace orient::interior
