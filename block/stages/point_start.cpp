#include "block/stages/point_start.h"

#include <fmt/ranges.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "block/inputs/measurement_inputs.h"
#include "core/base/median.h"
#include "exterior/judge.h"
#include "exterior/search/point_checks.h"
#include "exterior/search/whole_photo_search.h"
#include "exterior/steps/resect.h"

namespace orient::block {
namespace {

PosePrior PriorOf(const exterior::PointPose& points) { return {points.pose, points.covariance}; }

// A finding if the points' pose lies outside the accuracy of the approximation.
std::optional<Finding> AgainstApproximation(const PointStart& start) {
  if (!start.approximation || !start.approximation_is_stated) return std::nullopt;
  const double chi2 = exterior::Apart(PriorOf(*start.by_points), *start.approximation);
  if (!(chi2 > exterior::kMostApart)) return std::nullopt;
  return Finding{.reason = Reason::kContradictsApproximation,
                 .at_best = Status::kWeak,
                 .value = std::sqrt(chi2),
                 .where = "the points' coordinates are"};
}

// The combination of both; empty if they contradict one another.
std::optional<PosePrior> Together(const PosePrior& points, const PosePrior& approximation) {
  const auto stated = StatedElements(approximation);
  if (stated.empty() || !(exterior::Apart(points, approximation) <= exterior::kMostApart))
    return std::nullopt;
  const Vector6d off = PoseDifference(points.pose, approximation.pose);
  Matrix6d information = Matrix6d::Zero();
  const Eigen::MatrixXd known = approximation.covariance(stated, stated);
  const Eigen::MatrixXd inverse = known.inverse();
  information(stated, stated) = inverse;
  const Matrix6d covariance = (points.covariance.inverse() + information).inverse();
  const Vector6d move = -covariance * (information * off);
  Pose pose{points.pose.position_m + move.head<3>(), points.pose.opk_rad + move.tail<3>()};
  for (double& angle : pose.opk_rad) angle = NormalizeAngle(angle);
  return PosePrior{pose, 0.5 * (covariance + covariance.transpose())};
}

// A finding if the points' heights and the DEM's differ systematically.
std::optional<Finding> AgainstDem(const ExteriorSetting& setting, const PointStart& start,
                                  double pixel_m) {
  constexpr double kTolerance_px = 4, kSigmas = 3;
  std::vector<double> dem_above_m, sigma_m;
  for (std::size_t i = 0; i < start.points.size(); ++i) {
    const exterior::MeasuredPoint& point = start.points[i];
    const auto dem_m = setting.surface.HeightAt(point.ground_m.x(), point.ground_m.y());
    if (!point.control || !start.by_points->used[i] || !dem_m) continue;
    dem_above_m.push_back(*dem_m - point.ground_m.z());
    sigma_m.push_back(point.sigma_m.z());
  }
  if (dem_above_m.size() < 3) return std::nullopt;
  std::vector<double> spread_m;
  const double median_m = UpperMedian(dem_above_m);
  for (const double one : dem_above_m) spread_m.push_back(std::abs(one - median_m));
  const double allowed_m =
      std::max(kTolerance_px * pixel_m,
               kSigmas * std::hypot(UpperMedian(sigma_m), 1.5 * UpperMedian(spread_m)));
  if (std::abs(median_m) <= allowed_m) return std::nullopt;
  return Finding{.reason = Reason::kPointsOffDem,
                 .at_best = Status::kWeak,
                 .value = std::abs(median_m),
                 .where = median_m > 0 ? "above" : "below"};
}

// Judges the pose found by the measured points, with or without check points; points named as wrong
// are left out.
std::optional<Finding> PointsUnder(const ExteriorSetting& setting,
                                   const exterior::PhotoToOrient& photo, const PointStart& start,
                                   const ExteriorResult& found, bool checks) {
  const exterior::FilmPosition& position = PositionAs(photo.positions, found.orientation);
  auto points = PointsOf(setting.options.measurements, photo.name, position);
  for (std::size_t i = points.size(); i-- > 0;)
    if (points[i].control ? start.by_points && !start.by_points->used[i] : !checks)
      points.erase(points.begin() + static_cast<std::ptrdiff_t>(i));
  if (points.empty()) return std::nullopt;
  const PhotoView view{photo.camera, position.photo_from_pixel, *found.pose,
                       position.film_correction};
  return exterior::JudgePointsUnder(view, *found.covariance, points);
}

// Number of control points that are not used in the points' pose.
int Wrong(const PointStart& start) {
  int control = 0;
  for (const exterior::MeasuredPoint& point : start.points) control += point.control ? 1 : 0;
  return control - start.by_points->Used();
}

// Whether the film may lie on its scan in several ways and the points were measured in the photo
// system: these give the same pose whichever it is.
bool LeavesPositionOpen(std::size_t positions, const std::vector<exterior::MeasuredPoint>& points) {
  return positions > 1 && std::any_of(points.begin(), points.end(),
                                      [](const auto& point) { return point.in_photo_system; });
}

std::optional<Finding> PositionOpen(const std::vector<exterior::FilmPosition>& positions) {
  std::vector<std::string_view> names;
  for (const exterior::FilmPosition& position : positions)
    if (position.orientation) names.push_back(Name(*position.orientation));
  if (names.size() < 2) return std::nullopt;
  return Finding{.reason = Reason::kOrientationOpen,
                 .at_best = Status::kWeak,
                 .where = fmt::format("{}", fmt::join(names, ", "))};
}

// A finding about patches that were searched for in vain; few prove nothing.
std::optional<Finding> WithoutPatches(const ExteriorResult& tried) {
  constexpr std::size_t kTelling = 20;
  if (tried.patches.size() < kTelling || tried.findings.empty()) return std::nullopt;
  return Finding{.reason = Reason::kPatchesNotThere,
                 .value = static_cast<double>(tried.patches.size()),
                 .where = Sentence(tried.findings.front())};
}

}  // namespace

const exterior::FilmPosition& PositionAs(const std::vector<exterior::FilmPosition>& positions,
                                         const std::optional<ScanOrientation>& orientation) {
  const auto found = std::find_if(
      positions.begin(), positions.end(),
      [&](const exterior::FilmPosition& one) { return one.orientation == orientation; });
  return found != positions.end() ? *found : positions.front();
}

PointStart StartOf(const ExteriorSetting& setting, const std::string& name,
                   const std::optional<PosePrior>& approximation, bool stated,
                   ScanInterior* interior) {
  PointStart start{.prior = approximation,
                   .approximation = approximation,
                   .positions = interior->positions,
                   .stated = stated,
                   .approximation_is_stated = stated};
  start.points = PointsOf(setting.options.measurements, name, interior->positions.front());
  const bool open = LeavesPositionOpen(interior->positions.size(), start.points);
  const auto is_control = [](const exterior::MeasuredPoint& point) { return point.control; };
  if (std::none_of(start.points.begin(), start.points.end(), is_control)) return start;
  std::vector<exterior::FilmPosition> positions = interior->positions;
  if (open) positions.resize(1);
  exterior::PointResection resection =
      exterior::ResectByPoints(setting.camera.camera, positions, start.prior, start.points);
  start.findings = std::move(resection.findings);
  if (!resection.found) return start;
  start.by_points = std::move(resection.found);
  if (approximation && !open)
    exterior::LetPriorDecidePosition(interior->positions, *approximation,
                                     &start.by_points->position, &start.by_points->pose);
  if (!open) interior->positions = {start.by_points->position};
  start.by_points_began = true;
  start.prior = PriorOf(*start.by_points);
  const auto together = approximation && !resection.with_prior
                            ? Together(*start.prior, *approximation)
                            : std::nullopt;
  if (together) start.prior = together;
  // Combining it with points does not turn an unstated accuracy into a stated one.
  if (!together && !resection.with_prior) start.stated = true;
  return start;
}

void DropPoints(PointStart* start, ScanInterior* interior) {
  start->by_points.reset();
  start->by_points_began = false;
  start->prior = start->approximation;
  start->stated = start->approximation_is_stated;
  interior->positions = start->positions;
}

void OrientByPoints(const ExteriorSetting& setting, const exterior::PhotoToOrient& photo,
                    const PointStart& start, ExteriorResult* result) {
  const exterior::PointPose& by_points = *start.by_points;
  const PhotoView view{photo.camera, by_points.position.photo_from_pixel, by_points.pose,
                       by_points.position.film_correction};
  const double height_m = setting.surface.MeanHeight();
  const double pixel_m = view.GroundPixel(height_m);
  const auto in_vain = WithoutPatches(*result);
  result->pose = by_points.pose;
  result->covariance = by_points.covariance;
  result->orientation = by_points.position.orientation;
  result->target_m = setting.options.target_m.value_or(pixel_m);
  const double worst_px = exterior::WorstProjectionSigma(view, by_points.covariance, height_m);
  result->projection_sigma = exterior::ProjectionSigmaOf(worst_px, pixel_m);
  const double hidden_px = exterior::HiddenDisplacement(by_points, view, height_m);
  result->findings = {exterior::JudgePointsAlone(by_points.Used(), Wrong(start), worst_px,
                                                 hidden_px, *result->target_m / pixel_m)};
  for (const auto& finding : {in_vain, PositionOpen(photo.positions), AgainstApproximation(start),
                              AgainstDem(setting, start, pixel_m)})
    if (finding) result->findings.push_back(*finding);
  result->status = StatusOf(result->findings);
}

void CompareWithPoints(const ExteriorSetting& setting, const exterior::PhotoToOrient& photo,
                       const PointStart& start, ExteriorResult* result) {
  if (start.by_points_began && result->pose && !Has(result->findings, Reason::kByPointsAlone))
    exterior::Add(
        {.reason = Reason::kStartedByPoints, .value = static_cast<double>(start.by_points->Used())},
        result);
  for (Finding finding : start.findings) {
    if (result->pose) finding.at_best = Status::kOk;  // found by other means
    exterior::Add(finding, result);
  }
  if (!result->pose) return;
  if (const auto off = PointsUnder(setting, photo, start, *result, true))
    exterior::Add(*off, result);
}

bool PointsContradict(const ExteriorSetting& setting, const exterior::PhotoToOrient& photo,
                      const PointStart& start, const ExteriorResult& found) {
  const auto off = PointsUnder(setting, photo, start, found, false);
  return off && off->at_best != Status::kOk;
}

std::vector<OverviewItem> ClickedPoints(const PointStart& start) {
  std::vector<OverviewItem> items;
  for (std::size_t i = 0; i < start.points.size(); ++i) {
    if (!start.points[i].control) continue;
    if (LeavesPositionOpen(start.positions.size(), start.points)) continue;  // no place in the scan
    const bool used = start.by_points && start.by_points->used[i];
    const auto state = used ? OverviewState::kUsed : OverviewState::kRejected;
    items.push_back(
        {start.points[i].name, state, std::nullopt, std::nullopt, start.points[i].pixel});
  }
  return items;
}

}  // namespace orient::block
