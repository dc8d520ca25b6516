#include "exterior/steps/residual_trends.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "core/base/chi_square.h"

namespace orient::exterior {
namespace {

constexpr std::size_t kFewest = 30;
constexpr double kLeast_px = 0.05;
constexpr double kFalseAlarms = 1e-3;  // per photo

constexpr std::array kOfAll = {TrendKind::kShift, TrendKind::kScale, TrendKind::kRotation,
                               TrendKind::kRadial, TrendKind::kQuadrants};
constexpr std::array kOfSource = {TrendKind::kShift, TrendKind::kScale, TrendKind::kRotation};

struct Residuals {
  std::vector<Eigen::Vector2d> places;  // from their centroid, in units of their RMS distance
  Eigen::VectorXd values;               // col, row, col, ...
};

Residuals ResidualsOf(const TrendInput& input, const std::vector<std::size_t>& which) {
  Residuals residuals;
  residuals.values.resize(2 * std::ssize(which));
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  for (const std::size_t i : which) middle += input.pixels[i] / static_cast<double>(which.size());
  double squares = 0;
  for (const std::size_t i : which) {
    residuals.places.push_back(input.pixels[i] - middle);
    squares += residuals.places.back().squaredNorm();
    residuals.values.segment<2>(2 * (std::ssize(residuals.places) - 1)) = input.residuals_px[i];
  }
  const double unit = std::sqrt(std::max(squares, 1e-12) / static_cast<double>(which.size()));
  for (Eigen::Vector2d& place : residuals.places) place /= unit;
  return residuals;
}

// Design matrix of a trend at the places, one column per parameter.
Eigen::MatrixXd Design(TrendKind kind, const std::vector<Eigen::Vector2d>& places) {
  const auto parameters = [&]() -> Eigen::Index {
    if (kind == TrendKind::kShift) return 2;
    return kind == TrendKind::kQuadrants ? 8 : 1;
  }();
  Eigen::MatrixXd design = Eigen::MatrixXd::Zero(2 * std::ssize(places), parameters);
  for (Eigen::Index i = 0; i < std::ssize(places); ++i) {
    const Eigen::Vector2d& place = places[static_cast<std::size_t>(i)];
    auto rows = design.middleRows<2>(2 * i);
    switch (kind) {
      case TrendKind::kShift:
        rows = Eigen::Matrix2d::Identity();
        break;
      case TrendKind::kScale:
        rows = place;
        break;
      case TrendKind::kRotation:
        rows = Eigen::Vector2d(-place.y(), place.x());
        break;
      case TrendKind::kRadial:
        rows = place * place.squaredNorm();
        break;
      case TrendKind::kQuadrants: {
        const Eigen::Index quadrant = (place.x() < 0 ? 0 : 1) + (place.y() < 0 ? 0 : 2);
        rows.middleCols<2>(2 * quadrant) = Eigen::Matrix2d::Identity();
      }
    }
  }
  return design;
}

// The fitted trend's RMS if it is significant, else empty. `alarms`: the significance level.
std::optional<double> RmsOf(TrendKind kind, const Residuals& residuals, double alarms) {
  const Eigen::MatrixXd design = Design(kind, residuals.places);
  const Eigen::MatrixXd normal = design.transpose() * design;
  const Eigen::LDLT<Eigen::MatrixXd> solver(normal);
  if (solver.info() != Eigen::Success || !(solver.rcond() > 1e-9)) return std::nullopt;
  const Eigen::VectorXd fitted =
      design * solver.solve(design.transpose() * residuals.values).eval();
  const auto count = static_cast<double>(residuals.values.size());
  const auto parameters = static_cast<double>(design.cols());
  const double left = (residuals.values - fitted).squaredNorm() / (count - parameters);
  const double chi2 = fitted.squaredNorm() / std::max(left, 1e-12);
  const double rms_px = std::sqrt(fitted.squaredNorm() / count);
  const double limit = ChiSquareLimit(static_cast<int>(design.cols()), alarms);
  if (!(chi2 > limit) || rms_px < kLeast_px) return std::nullopt;
  return rms_px;
}

}  // namespace

std::vector<ResidualTrend> FindTrends(const TrendInput& input) {
  std::vector<std::size_t> all;
  std::map<std::int64_t, std::vector<std::size_t>> of_source;
  for (std::size_t i = 0; i < input.pixels.size(); ++i) {
    all.push_back(i);
    of_source[input.sources[i]].push_back(i);
  }
  if (of_source.size() < 2) of_source.clear();  // its residuals are all there are
  std::erase_if(of_source, [](const auto& source) { return source.second.size() < kFewest; });
  if (all.size() < kFewest) return {};
  const auto tests = static_cast<double>(kOfAll.size() + kOfSource.size() * of_source.size());
  std::vector<ResidualTrend> trends;
  const Residuals residuals = ResidualsOf(input, all);
  for (const TrendKind kind : kOfAll)
    if (const auto rms_px = RmsOf(kind, residuals, kFalseAlarms / tests))
      trends.push_back({kind, std::nullopt, *rms_px});
  for (const auto& [source, which] : of_source) {
    const Residuals own = ResidualsOf(input, which);
    for (const TrendKind kind : kOfSource)
      if (const auto rms_px = RmsOf(kind, own, kFalseAlarms / tests))
        trends.push_back({kind, source, *rms_px});
  }
  std::stable_sort(
      trends.begin(), trends.end(),
      [](const ResidualTrend& a, const ResidualTrend& b) { return a.rms_px > b.rms_px; });
  return trends;
}

}  // namespace orient::exterior
