#include "exterior/search/point_resection.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>

#include "core/base/chi_square.h"
#include "core/terrain/pixel_derivatives.h"
#include "exterior/search/point_checks.h"

namespace orient::exterior {
namespace {

constexpr int kLeastPoints = 4, kLeastWithPrior = 3;
// Of sets with equally many points, the best by this much in chi-square is beyond doubt.
constexpr double kBeyondDoubt = 20;
// Sets that lose a further point, and which points each may lose: any if there are few; if many,
// those with the largest residuals, or a dozen wrong ones would take an hour.
constexpr std::size_t kBeam = 12, kMany = 12;
constexpr std::size_t kBeamOfMany = 3, kLosersOfMany = 6;
constexpr std::size_t kMostTriples = 200;  // that first poses are made from
constexpr std::size_t kStarts = 8;

using Set = std::vector<std::size_t>;  // indices of points, ascending

struct Fit {
  Set points;
  ResectionResult result;
  double chi2 = 0;
  int freedom = 0;
  std::vector<PointCheck> checks = {};  // of each point
  bool passes = false;
};

// The t-th of all triples of n points, in lexical order.
std::array<std::size_t, 3> TripleOf(std::size_t t, std::size_t n) {
  std::size_t a = 0, b = 1;
  const auto pairs = [](std::size_t of) { return of * (of - 1) / 2; };
  for (; t >= pairs(n - 1 - a); ++a) t -= pairs(n - 1 - a);
  for (b = a + 1; t >= n - 1 - b; ++b) t -= n - 1 - b;
  return {a, b, b + 1 + t};
}

// Adjusts poses for one film position.
class PointAdjuster {
 public:
  PointAdjuster(const Camera& camera, const FilmPosition& position,
                const std::vector<MeasuredPoint>& points, const std::optional<PosePrior>& prior)
      : view_{camera, position.photo_from_pixel, {}, position.film_correction},
        points_(points),
        prior_(prior) {
    for (const MeasuredPoint& point : points)
      observations_.push_back({point.ground_m, view_.PhotoFromPixel(point.pixel)});
    FindStarts();
  }

  // Empty if no start converges, or too few points are left.
  std::optional<Fit> Adjust(const Set& set) const {
    const int least = prior_ ? kLeastWithPrior : kLeastPoints;
    if (std::ssize(set) < least) return std::nullopt;
    std::optional<Fit> best;
    for (const Pose& start : StartsOf(set)) {
      const auto fit = AdjustFrom(set, start);
      if (fit && (!best || fit->chi2 < best->chi2)) best = fit;
    }
    // Once more with the weights of the pose found, instead of the start's.
    if (!best) return best;
    if (auto again = AdjustFrom(set, best->result.pose)) best = std::move(again);
    Check(&*best);
    return best;
  }

  // For a set that does not converge: its points in front of the camera under the best start.
  Set Visible(const Set& set) const {
    Set visible;
    const std::vector<Pose> starts = StartsOf(set);
    for (const std::size_t i : set)
      if (!starts.empty() && PhotoFromGround(view_.camera, starts[0], points_[i].ground_m))
        visible.push_back(i);
    return visible;
  }

  PhotoView View(const Pose& pose) const {
    PhotoView view = view_;
    view.pose = pose;
    return view;
  }

 private:
  // Covariance of measurement and ground point together, photo system; empty behind the camera.
  std::optional<Eigen::Matrix2d> Covariance(std::size_t i, const Pose& pose) const {
    const auto d = PixelFromGroundWithDerivatives(View(pose), points_[i].ground_m);
    if (!d) return std::nullopt;
    const Eigen::Matrix2d& A = view_.photo_from_pixel.A;
    return Eigen::Matrix2d(A * ObservedCovariance(points_[i], *d) * A.transpose());
  }

  void FindStarts() {
    if (prior_) starts_.push_back(prior_->pose);
    const std::size_t n = points_.size(), triples = n < 3 ? 0 : n * (n - 1) / 2 * (n - 2) / 3;
    const std::size_t step = 1 + triples / kMostTriples;
    for (std::size_t t = 0; t < triples; t += step) {
      const auto [a, b, c] = TripleOf(t, n);
      for (const Pose& pose :
           ResectThreePoints(view_.camera, {observations_[a], observations_[b], observations_[c]}))
        if (pose.position_m.z() > points_[a].ground_m.z()) starts_.push_back(pose);
    }
  }

  // Sum of the lengths of the set's residuals in the photo system, each counted as at most
  // kLarge_mm.
  double Misfit(const Set& set, const Pose& pose) const {
    constexpr double kLarge_mm = 5;
    double sum = 0;
    for (const std::size_t i : set) {
      const auto seen = PhotoFromGround(view_.camera, pose, points_[i].ground_m);
      const double off = seen ? (*seen - observations_[i].photo_mm).norm() : kLarge_mm;
      sum += std::min(off, kLarge_mm);
    }
    return sum;
  }

  std::vector<Pose> StartsOf(const Set& set) const {
    std::vector<std::pair<double, std::size_t>> order;
    for (std::size_t s = 0; s < starts_.size(); ++s) order.emplace_back(Misfit(set, starts_[s]), s);
    std::sort(order.begin(), order.end());
    std::vector<Pose> best;
    for (std::size_t k = 0; k < std::min(kStarts, order.size()); ++k)
      best.push_back(starts_[order[k].second]);
    return best;
  }

  std::optional<Fit> AdjustFrom(const Set& set, const Pose& start) const {
    std::vector<ControlObservation> observations;
    for (const std::size_t i : set) {
      const auto covariance = Covariance(i, start);
      if (!covariance) return std::nullopt;
      observations.push_back(observations_[i]);
      observations.back().covariance_mm2 = *covariance;
    }
    ResectionOptions options;
    options.prior = prior_;
    auto result = Resect(view_.camera, observations, start, options);
    if (!result || !result->converged) return std::nullopt;
    Fit fit{set, std::move(*result)};
    fit.freedom = fit.result.degrees_of_freedom;
    fit.chi2 = fit.result.sigma0 * fit.result.sigma0 * fit.freedom;
    return fit;
  }

  void Check(Fit* fit) const {
    double most = 0;
    for (const std::size_t i : fit->points) {
      fit->checks.push_back(CheckPoint(View(fit->result.pose), fit->result.covariance, points_[i],
                                       fit->points.size()));
      most = std::max(most, fit->checks.back().chi2);
    }
    fit->passes = fit->freedom > 0 &&
                  fit->chi2 <= ChiSquareLimit(fit->freedom, kPointSignificance) &&
                  most <= PointChiSquareLimit(fit->points.size());
  }

  PhotoView view_;  // without a pose
  const std::vector<MeasuredPoint>& points_;
  const std::optional<PosePrior>& prior_;
  std::vector<ControlObservation> observations_;
  std::vector<Pose> starts_;
};

// The points in the order of suspicion: all if there are few, the first ones if there are many.
std::vector<std::size_t> SuspectsOf(const Fit& fit) {
  std::vector<std::pair<double, std::size_t>> order;
  for (std::size_t k = 0; k < fit.points.size(); ++k) order.emplace_back(-fit.checks[k].chi2, k);
  std::sort(order.begin(), order.end());
  if (order.size() > kMany) order.resize(kLosersOfMany);
  std::vector<std::size_t> suspects;
  for (const auto& [by, k] : order) suspects.push_back(k);
  return suspects;
}

// The visible part of a set; if that is all of it, the set without its last point.
Set Shortened(Set visible, const Set& set) {
  if (visible.size() == set.size()) visible.pop_back();
  return visible;
}

// The largest sets that pass, the best first.
std::vector<Fit> LargestSets(const PointAdjuster& adjuster, const Set& all) {
  std::vector<Set> sets = {all};
  while (!sets.empty()) {
    std::vector<Fit> fits;
    for (const Set& set : sets)
      if (auto fit = adjuster.Adjust(set)) fits.push_back(std::move(*fit));
    std::sort(fits.begin(), fits.end(), [](const Fit& a, const Fit& b) { return a.chi2 < b.chi2; });
    std::vector<Fit> passing;
    std::copy_if(fits.begin(), fits.end(), std::back_inserter(passing),
                 [](const Fit& fit) { return fit.passes; });
    if (!passing.empty()) return passing;
    std::set<Set> fewer;
    const auto lose = [&](const Set& set, std::size_t k) {
      Set less = set;
      less.erase(less.begin() + static_cast<std::ptrdiff_t>(k));
      fewer.insert(std::move(less));
    };
    const std::size_t beam = sets.front().size() > kMany ? kBeamOfMany : kBeam;
    for (std::size_t f = 0; f < std::min(beam, fits.size()); ++f)
      for (const std::size_t k : SuspectsOf(fits[f])) lose(fits[f].points, k);
    for (std::size_t s = 0; s < sets.size() && fits.empty(); ++s)
      if (sets[s].size() > kMany)
        fewer.insert(Shortened(adjuster.Visible(sets[s]), sets[s]));
      else
        for (std::size_t k = 0; k < sets[s].size(); ++k) lose(sets[s], k);
    const bool any = !fewer.empty() && fewer.begin()->size() >= kLeastWithPrior;
    sets = any ? std::vector<Set>(fewer.begin(), fewer.end()) : std::vector<Set>();
  }
  return {};
}

std::string NamesOf(const std::vector<MeasuredPoint>& points, const Set& which) {
  std::string names;
  for (const std::size_t i : which) names += (names.empty() ? "" : ", ") + points[i].name;
  return names;
}

Set Missing(const Set& all, const Set& some) {
  Set missing;
  std::set_difference(all.begin(), all.end(), some.begin(), some.end(),
                      std::back_inserter(missing));
  return missing;
}

PointPose PoseOf(const FilmPosition& position, const PointAdjuster& adjuster, const Fit& fit,
                 const std::vector<MeasuredPoint>& points, const Set& control) {
  PointPose found{position, fit.result.pose, fit.result.covariance};
  found.covariance *= std::max(1.0, fit.result.sigma0 * fit.result.sigma0);
  found.used.assign(points.size(), false);
  for (const std::size_t i : fit.points) found.used[control[i]] = true;
  const PhotoView view = adjuster.View(found.pose);
  for (const MeasuredPoint& point : points) {
    const auto seen = view.PixelFromGround(point.ground_m);
    found.residuals_px.push_back(
        seen ? Eigen::Vector2d(point.pixel - *seen)
             : Eigen::Vector2d::Constant(std::numeric_limits<double>::quiet_NaN()));
  }
  for (const PointCheck& check : fit.checks) found.hidden.push_back(check.hidden);
  return found;
}

PointResection Failed(Reason reason, std::string where, double value = 0, double limit = 0) {
  return {std::nullopt, {{reason, Status::kFailed, value, limit, std::move(where)}}};
}

// Resection by the points alone, or with the prior, in all possible film positions.
PointResection Decide(const Camera& camera, const std::vector<FilmPosition>& positions,
                      const std::optional<PosePrior>& prior,
                      const std::vector<MeasuredPoint>& points, const Set& control) {
  std::vector<MeasuredPoint> given;
  for (const std::size_t i : control) given.push_back(points[i]);
  Set all(given.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  struct Way {
    Fit fit;
    PointPose pose;
  };
  std::vector<Way> ways;
  for (const FilmPosition& position : positions) {
    const PointAdjuster adjuster(camera, position, given, prior);
    for (const Fit& fit : LargestSets(adjuster, all))
      ways.push_back({fit, PoseOf(position, adjuster, fit, points, control)});
  }
  if (ways.empty()) return Failed(Reason::kPointsOnNoPose, NamesOf(given, all));
  std::stable_sort(ways.begin(), ways.end(), [](const Way& a, const Way& b) {
    if (a.fit.points.size() != b.fit.points.size())
      return a.fit.points.size() > b.fit.points.size();
    return a.fit.chi2 < b.fit.chi2;
  });
  Set doubtful;
  for (const Way& way : ways)
    if (way.fit.points.size() == ways[0].fit.points.size() &&
        way.fit.chi2 < ways[0].fit.chi2 + kBeyondDoubt && way.fit.points != ways[0].fit.points)
      for (const std::size_t i : Missing(all, way.fit.points)) doubtful.push_back(i);
  const Set wrong = Missing(all, ways[0].fit.points);
  if (!doubtful.empty()) {
    doubtful.insert(doubtful.end(), wrong.begin(), wrong.end());
    std::sort(doubtful.begin(), doubtful.end());
    doubtful.erase(std::unique(doubtful.begin(), doubtful.end()), doubtful.end());
    return Failed(Reason::kPointsContradictOneAnother, NamesOf(given, doubtful));
  }
  PointResection answer{ways[0].pose, {}};
  if (!wrong.empty())
    answer.findings.push_back({.reason = Reason::kPointsWrong,
                               .value = static_cast<double>(wrong.size()),
                               .where = NamesOf(given, wrong)});
  return answer;
}

}  // namespace

PointResection ResectByPoints(const Camera& camera, const std::vector<FilmPosition>& positions,
                              const std::optional<PosePrior>& prior,
                              const std::vector<MeasuredPoint>& points) {
  Set control;
  for (std::size_t i = 0; i < points.size(); ++i)
    if (points[i].control) control.push_back(i);
  const int count = static_cast<int>(control.size());
  if (count < (prior ? kLeastWithPrior : kLeastPoints))
    return Failed(Reason::kTooFewPoints, "", count, kLeastPoints);
  if (count >= kLeastPoints) {
    PointResection alone = Decide(camera, positions, std::nullopt, points, control);
    if (alone.found || !prior) return alone;
  }
  PointResection with_prior = Decide(camera, positions, prior, points, control);
  with_prior.with_prior = prior.has_value();
  return with_prior;
}

Finding JudgePointsAlone(int points, int wrong, double worst_sigma_px, double hidden_px,
                         double target_px) {
  // In targets. The cost and benefit of 3 and 7: docs/evidence/measurements.md.
  constexpr double kMostHidden = 5;
  const bool checked = hidden_px <= kMostHidden * target_px;
  const bool few_wrong = 4 * wrong <= points + wrong;
  const bool enough =
      points >= kLeastPointsAlone && few_wrong && checked && worst_sigma_px <= target_px;
  std::string how = fmt::format("one sigma up to {:.1f} px in the frame, {:.1f} px are wanted",
                                worst_sigma_px, target_px);
  if (!checked)
    how += fmt::format(
        "; one wrong point may displace it by {:.1f} px before it shows ({:.1f} px are allowed)",
        hidden_px, kMostHidden * target_px);
  if (!few_wrong) how += fmt::format("; {} of {} contradict the others", wrong, points + wrong);
  return {Reason::kByPointsAlone, enough ? Status::kOk : Status::kWeak, static_cast<double>(points),
          kLeastPointsAlone, std::move(how)};
}

std::optional<Finding> JudgePointsUnder(const PhotoView& view, const Matrix6d& covariance,
                                        const std::vector<MeasuredPoint>& points) {
  std::string names;
  int off = 0;
  for (const MeasuredPoint& point : points) {
    const auto seen = view.PixelFromGround(point.ground_m);
    const auto d = PixelFromGroundWithDerivatives(view, point.ground_m);
    double chi2 = std::numeric_limits<double>::infinity(), off_px = chi2;
    if (seen && d) {
      const Eigen::Matrix2d sum =
          ObservedCovariance(point, *d) + d->by_pose * covariance * d->by_pose.transpose();
      const Eigen::Vector2d residual = point.pixel - *seen;
      chi2 = residual.dot(sum.inverse() * residual);
      off_px = residual.norm();
    }
    if (chi2 <= PointChiSquareLimit(1)) continue;
    names += fmt::format("{}{} ({:.1f} px)", names.empty() ? "" : ", ", point.name, off_px);
    ++off;
  }
  if (off == 0) return std::nullopt;
  return Finding{.reason = Reason::kPointsOffPose,
                 .at_best = 2 * off > std::ssize(points) ? Status::kWeak : Status::kOk,
                 .value = off,
                 .where = names};
}

}  // namespace orient::exterior
