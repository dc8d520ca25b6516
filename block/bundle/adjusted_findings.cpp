#include "block/bundle/adjusted_findings.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "block/bundle/connected_parts.h"
#include "core/base/chi_square.h"
#include "core/base/median.h"

namespace orient::block {
namespace {

// Of standard deviations.
constexpr double kTooMuchWorse = 3;

// Of each photo, of the points that it shows, in the block's coordinates.
std::vector<double> MeanGroundHeights(const BlockSystem& system) {
  std::vector<double> heights(system.block.photos.size(), 0);
  std::vector<int> counts(heights.size(), 0);
  for (std::size_t i = 0; i < system.block.observations.size(); ++i) {
    const ImageObservation& o = system.block.observations[i];
    if (!system.IsActive(i)) continue;
    heights[o.photo] += system.GroundOf(o.point).z();
    ++counts[o.photo];
  }
  for (std::size_t i = 0; i < heights.size(); ++i)
    if (counts[i] > 0) heights[i] /= counts[i];
  return heights;
}

// What the photos' GNSS positions have in common: measured - computed.
struct CommonShift {
  Eigen::Vector3d shift_m = Eigen::Vector3d::Zero();
  std::size_t photos = 0;  // whose positions fit with it, and do not without
};

class FindingsAbout {
 public:
  FindingsAbout(const BlockSystem& system, const BlockResult& result)
      : system_(system), result_(result) {}

  Findings All() {
    for (const BlockPart& part : result_.parts)
      if (part.finding) findings_.push_back(*part.finding);
    SayGnss();
    SayApproximations();
    SayOf(PhotosThat(
              [](const AdjustedPhoto& photo) { return photo.state == PhotoState::kUndetermined; }),
          Reason::kPhotosUndetermined);
    if (result_.converged) SayDistancesLeftOpen();
    return std::move(findings_);
  }

 private:
  template <typename Condition>
  std::vector<std::size_t> PhotosThat(const Condition& condition) const {
    std::vector<std::size_t> photos;
    for (std::size_t i = 0; i < result_.photos.size(); ++i)
      if (condition(result_.photos[i])) photos.push_back(i);
    return photos;
  }

  void Say(Reason reason, std::optional<double> value, std::optional<double> limit = {}) {
    findings_.push_back({.reason = reason, .value = value, .limit = limit});
  }
  void SayOf(const std::vector<std::size_t>& photos, Reason reason);
  void SayWorseThanStated(RowKind kind, Reason reason);
  CommonShift ShiftOfGnss(const std::vector<std::size_t>& photos) const;
  void SayShiftOfGnss(const std::vector<std::size_t>& photos);
  void SayGnss();
  void SayApproximations();
  void SayDistancesLeftOpen();

  const BlockSystem& system_;
  const BlockResult& result_;
  Findings findings_;
};

// Of photos, if there are any.
void FindingsAbout::SayOf(const std::vector<std::size_t>& photos, Reason reason) {
  if (photos.empty()) return;
  findings_.push_back({.reason = reason,
                       .value = static_cast<double>(photos.size()),
                       .where = NamesOf(system_.block, photos)});
}

// How much worse than stated, where that is too much to pass over in silence.
void FindingsAbout::SayWorseThanStated(RowKind kind, Reason reason) {
  const double factor = std::sqrt(system_.Factor(kind));
  if (!(factor < kTooMuchWorse)) Say(reason, factor, kTooMuchWorse);
}

CommonShift FindingsAbout::ShiftOfGnss(const std::vector<std::size_t>& photos) const {
  CommonShift common;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> residuals;
    for (const std::size_t i : photos)
      residuals.push_back((*result_.photos[i].gnss_residual_m)[axis]);
    common.shift_m[axis] = Median(std::move(residuals));
  }
  const double limit = ChiSquareLimit(3, system_.options.significance);
  for (const std::size_t i : photos) {
    const Eigen::Vector3d& residual_m = *result_.photos[i].gnss_residual_m;
    const Eigen::LDLT<Eigen::Matrix3d> covariance(
        system_.block.photos[i].gnss->covariance_m2 +
        result_.photos[i].covariance.topLeftCorner<3, 3>());
    const auto fits = [&](const Eigen::Vector3d& off) {
      return off.dot(covariance.solve(off)) <= limit;
    };
    if (fits(residual_m - common.shift_m) && !fits(residual_m)) ++common.photos;
  }
  return common;
}

// Two that agree may do so by chance.
void FindingsAbout::SayShiftOfGnss(const std::vector<std::size_t>& photos) {
  constexpr std::size_t kLeastThatAgree = 3;
  if (photos.size() < kLeastThatAgree) return;
  const auto [shift_m, agree] = ShiftOfGnss(photos);
  if (agree < kLeastThatAgree || 2 * agree <= photos.size()) return;
  Say(Reason::kGnssPerhapsOfAnotherDatum, static_cast<double>(agree),
      static_cast<double>(photos.size()));
  findings_.back().where =
      fmt::format("dx {:.2f} dy {:.2f} dz {:.2f} m", shift_m.x(), shift_m.y(), shift_m.z());
}

void FindingsAbout::SayGnss() {
  const bool plain = system_.options.gnss == GnssModel::kPlain;
  const auto observed =
      PhotosThat([](const AdjustedPhoto& photo) { return photo.gnss_residual_m.has_value(); });
  const auto rejected = PhotosThat([](const AdjustedPhoto& photo) { return photo.gnss_rejected; });
  if (plain && observed.size() > 1 && rejected.size() == observed.size())
    Say(Reason::kGnssDisagreesEverywhere, static_cast<double>(observed.size()));
  else
    SayOf(rejected, Reason::kGnssRejected);
  if (rejected.size() < observed.size())
    SayWorseThanStated(RowKind::kGnss, Reason::kGnssWorseThanStated);
  if (plain) SayShiftOfGnss(observed);
}

void FindingsAbout::SayApproximations() {
  const auto rejected = PhotosThat([](const AdjustedPhoto& photo) { return photo.prior_rejected; });
  SayOf(rejected, Reason::kApproximationsRejected);
  const auto observed = std::count_if(system_.prior_row.begin(), system_.prior_row.end(),
                                      [](int row) { return row >= 0; });
  if (std::ssize(rejected) < observed)
    SayWorseThanStated(RowKind::kPosePrior, Reason::kApproximationsWorseThanStated);
}

// An error of the principal distance that the block does not see goes into its flying heights.
// Where GNSS holds these, both are known about equally well.
void FindingsAbout::SayDistancesLeftOpen() {
  if (result_.calibration.empty()) return;
  constexpr double kMuchMore = 3;
  const std::vector<double> ground_m = MeanGroundHeights(system_);
  for (const CalibrationParameter& parameter : result_.calibration) {
    if (parameter.name != kPrincipalDistanceName || parameter.state == CalibrationState::kEstimated)
      continue;
    const double share =
        parameter.sigma / system_.block.cameras[parameter.camera].principal_distance_mm;
    for (std::size_t i = 0; i < result_.photos.size(); ++i) {
      const AdjustedPhoto& photo = result_.photos[i];
      if (photo.state != PhotoState::kAdjusted ||
          system_.block.photos[i].camera != parameter.camera)
        continue;
      const double height_m = photo.pose.position_m.z() - ground_m[i];
      if (share * height_m <= kMuchMore * std::sqrt(photo.covariance(2, 2))) continue;
      Say(Reason::kDistanceLeftOpen, parameter.sigma);
      break;
    }
  }
}

}  // namespace

Findings FindingsOfAdjusted(const BlockSystem& system, const BlockResult& result) {
  return FindingsAbout(system, result).All();
}

}  // namespace orient::block
