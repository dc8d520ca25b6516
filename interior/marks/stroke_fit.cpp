#include "interior/marks/stroke_fit.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/base/median.h"

namespace orient::interior {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

// Relative error of the correction for a stroke's unlike sides.
constexpr double kSideUnsure = 0.1;
constexpr double kOutlierSigmas = 3.0;
// A profile whose top lies farther from the line, in units of its smoothing, does not fit it,
// however large the scatter: the outliers' limit grows with the scatter.
constexpr double kFarthestTop = 0.5;
constexpr double kLeastSeen = 0.5;  // of a stroke's profiles
constexpr int kPasses = 12;
constexpr double kConverged = 1e-3;  // px
constexpr int kFarthestLag = 6;

// Variance of the sum of a zero-mean series over that of independent values of the same variance.
double VarianceInflation(const std::vector<double>& series) {
  double squares = 0;
  for (const double value : series) squares += value * value;
  double inflation = 1;
  for (size_t lag = 1; lag <= kFarthestLag && lag < series.size(); ++lag) {
    double products = 0;
    for (size_t i = lag; i < series.size(); ++i) products += series[i] * series[i - lag];
    const double taper = 1 - static_cast<double>(lag) / (kFarthestLag + 1);
    inflation += 2 * taper * products / std::max(squares, 1e-12);
  }
  return std::max(inflation, 1.0);
}

}  // namespace

StrokeFit::StrokeFit(const Plane& plane, const Vector2d& centre, const Stroke& stroke)
    : plane_(plane), centre_(centre), line_(stroke) {
  for (int x = static_cast<int>(std::floor(centre.x() - stroke.to_px));
       x <= static_cast<int>(std::floor(centre.x() + stroke.to_px)); ++x)
    columns_.push_back(x);
}

bool StrokeFit::Fit(double max_shift_px) {
  for (int pass = 0; pass < kPasses; ++pass) {
    TakeProfiles();
    if (!WithoutOutliers() || !Improve(max_shift_px)) return false;
    if (step_ < kConverged) return true;
  }
  return step_ < 0.05;
}

double StrokeFit::VarianceAt(double x) const {
  const Vector2d at(1, x);
  const Vector2d weights = Response().transpose().inverse() * at;
  Matrix2d spread = SpreadAtLag(0);
  const double independent = weights.dot(spread * weights);
  for (int lag = 1; lag <= kFarthestLag; ++lag) spread += SpreadAtLag(lag);
  // Neighbours are positively correlated or independent; a negative correlation is chance.
  double variance = std::max(independent, weights.dot(spread * weights));
  // The sides' effect is known only up to a share of it, which is the same everywhere.
  Vector2d sides = Vector2d::Zero();
  for (size_t i = 0; i < profiles_.size(); ++i)
    if (use_[i]) sides += RowOf(i) * profiles_[i].weight * kSideUnsure * profiles_[i].side_effect;
  const double wrong = weights.dot(sides);
  const double aliased = weights.dot(Aliasing());
  variance += wrong * wrong + aliased * aliased;
  return variance * static_cast<double>(used_) / std::max(1.0, static_cast<double>(used_) - 2);
}

StrokeEvidence StrokeFit::Evidence() const {
  StrokeEvidence evidence;
  size_t fitting = 0;
  for (size_t i = 0; i < profiles_.size(); ++i)
    if (use_[i] && std::abs(OffLine(i)) <= kFarthestTop * line_.smoothing_px) ++fitting;
  evidence.share = static_cast<double>(fitting) / std::max(1.0, static_cast<double>(possible_));
  evidence.nats = std::min(ArmNats(false), ArmNats(true));
  return evidence;
}

double StrokeFit::ArmNats(bool right) const {
  std::vector<double> contrasts;
  double sum = 0;
  for (size_t i = 0; i < profiles_.size(); ++i) {
    if ((FromCentre(i) > 0) != right || !IsOnArm(i) || !profiles_[i].seen) continue;
    contrasts.push_back(-profiles_[i].g2);
    sum += contrasts.back();
  }
  if (contrasts.size() < 4 || sum <= 0) return 0;
  const auto count = static_cast<double>(contrasts.size());
  const double mean = sum / count;
  double squares = 0;
  for (double& contrast : contrasts) {
    contrast -= mean;
    squares += contrast * contrast;
  }
  const double effective = count / VarianceInflation(contrasts);
  return 0.5 * effective * std::log1p(mean * mean * count / std::max(squares, 1e-12));
}

// Change of the normal equations' right-hand side when the line is shifted or rotated.
// Their matrix alone would be a third too large: the correction for the sides moves along.
Matrix2d StrokeFit::Response() const {
  constexpr double kBy_px = 0.2;
  const Vector2d by(kBy_px, kBy_px / line_.to_px);
  Matrix2d response = Matrix2d::Zero();
  for (const int k : {0, 1}) {
    for (const int way : {-1, 1}) {
      const double offset = line_.offset + (k == 0 ? way * by[k] : 0);
      const double slope = line_.slope + (k == 1 ? way * by[k] : 0);
      for (size_t i = 0; i < profiles_.size(); ++i) {
        if (!use_[i]) continue;
        const double y = centre_.y() + offset + slope * FromCentre(i);
        const Profile moved = ProfileAt(plane_, columns_[i], y, line_);
        if (moved.seen)
          response.col(k) += way * profiles_[i].weight * moved.g1 * RowOf(i) / (2 * by[k]);
      }
    }
  }
  return response;
}

bool StrokeFit::IsOnArm(size_t i) const {
  const double x = std::abs(FromCentre(i));
  return x >= line_.from_px && x <= line_.to_px;
}

void StrokeFit::TakeProfiles() {
  profiles_.assign(columns_.size(), {});
  for (size_t i = 0; i < columns_.size(); ++i) {
    if (!IsOnArm(i)) continue;
    const double y = centre_.y() + line_.offset + line_.slope * FromCentre(i);
    profiles_[i] = ProfileAt(plane_, columns_[i], y, line_);
  }
}

// Reduces the weights of profiles between unlike sides, depending on the (robust) grey value noise.
void StrokeFit::Weigh(double noise) {
  for (Profile& profile : profiles_) {
    const double unsure = kSideUnsure * profile.side_effect / std::max(noise, 1e-9);
    profile.weight = 1 / std::sqrt(1 + unsure * unsure);
  }
}

Vector2d StrokeFit::RowOf(size_t i) const {
  return 2 * profiles_[i].g2 * profiles_[i].weight * Vector2d(1, FromCentre(i));
}

// Residual of a profile if the line is shifted and rotated by `move`, grey values per pixel.
double StrokeFit::Left(size_t i, const Vector2d& move) const {
  return profiles_[i].weight * profiles_[i].g1 + RowOf(i).dot(move);
}

// Distance of a profile's maximum from the line, px.
double StrokeFit::OffLine(size_t i) const {
  return Left(i, move_) / (2 * profiles_[i].g2 * profiles_[i].weight);
}

bool StrokeFit::Solve(const std::vector<bool>& used, Vector2d* move) {
  normal_.setZero();
  Vector2d right = Vector2d::Zero();
  used_ = 0;
  for (size_t i = 0; i < profiles_.size(); ++i) {
    if (!used[i]) continue;
    const Vector2d row = RowOf(i);
    normal_ += row * row.transpose();
    right -= row * profiles_[i].weight * profiles_[i].g1;
    ++used_;
  }
  const Eigen::LLT<Matrix2d> solver(normal_);
  if (solver.info() != Eigen::Success) return false;
  *move = solver.solve(right);
  return move->allFinite();
}

// Profiles with a stroke, without those that the others contradict.
bool StrokeFit::WithoutOutliers() {
  use_.assign(profiles_.size(), false);
  size_t seen = 0;
  possible_ = 0;
  for (size_t i = 0; i < profiles_.size(); ++i) {
    if (IsOnArm(i)) ++possible_;
    use_[i] = profiles_[i].seen && profiles_[i].g2 < 0;
    if (use_[i]) ++seen;
  }
  const auto least =
      static_cast<size_t>(std::max(6.0, kLeastSeen * static_cast<double>(possible_)));
  for (int round = 0; round < 5; ++round) {
    if (seen < least || !Solve(use_, &move_)) return false;
    std::vector<double> sizes;
    for (size_t i = 0; i < profiles_.size(); ++i)
      if (use_[i]) sizes.push_back(std::abs(Left(i, move_)));
    const double noise = kSigmaOfMedianDeviation * UpperMedian(std::move(sizes));
    const double limit = kOutlierSigmas * noise;
    if (round == 0) Weigh(noise);
    size_t kept = 0;
    for (size_t i = 0; i < profiles_.size(); ++i) {
      use_[i] = profiles_[i].seen && profiles_[i].g2 < 0 && std::abs(Left(i, move_)) <= limit;
      if (use_[i]) ++kept;
    }
    if (kept == seen) break;
    seen = kept;
  }
  return seen >= least && Solve(use_, &move_);
}

bool StrokeFit::Improve(double max_shift_px) {
  const double most = line_.smoothing_px;
  const double x = 0.5 * (line_.from_px + line_.to_px);
  step_ = std::max(std::abs(move_[0]), std::abs(move_[1] * x));
  if (step_ > most) move_ *= most / step_;
  line_.offset += move_[0];
  line_.slope += move_[1];
  return std::abs(line_.offset) <= max_shift_px && std::abs(line_.slope) < 1.5;
}

// Effect of undersampling on the line: it averages out if the stroke crosses rows of pixels.
Vector2d StrokeFit::Aliasing() const {
  const double amplitude = AliasingOf(line_);
  Vector2d sum = Vector2d::Zero();
  for (size_t i = 0; i < profiles_.size(); ++i) {
    if (!use_[i]) continue;
    const double y = centre_.y() + line_.offset + line_.slope * FromCentre(i);
    const Vector2d row = RowOf(i);
    sum += row * row[0] * amplitude * std::sin(2 * std::numbers::pi * y);
  }
  return sum;
}

Matrix2d StrokeFit::SpreadAtLag(int lag) const {
  double products = 0, pairs = 0;
  Matrix2d rows = Matrix2d::Zero();
  for (size_t i = 0; i + static_cast<size_t>(lag) < profiles_.size(); ++i) {
    const size_t j = i + static_cast<size_t>(lag);
    if (!use_[i] || !use_[j]) continue;
    products += Left(i, move_) * Left(j, move_);
    ++pairs;
    const Vector2d a = RowOf(i), b = RowOf(j);
    rows += a * b.transpose() + b * a.transpose();
  }
  if (pairs < 1) return Matrix2d::Zero();
  const double taper = lag == 0 ? 0.5 : 1 - static_cast<double>(lag) / (kFarthestLag + 1);
  return taper * products / pairs * rows;
}

}  // namespace orient::interior
