#include "block/bundle/adjusted_findings.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "block/bundle/connected_parts.h"

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

class FindingsAbout {
 public:
  FindingsAbout(const BlockSystem& system, const BlockResult& result)
      : system_(system), result_(result) {}

  Findings All() {
    for (const BlockPart& part : result_.parts)
      if (part.finding) findings_.push_back(*part.finding);
    SayControl();
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
  void SayWorseThanStated(double variance_factor, Reason reason, std::string where = {});
  void SayShiftOfGnss(std::size_t used, std::size_t observed);
  void SayControl();
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
void FindingsAbout::SayWorseThanStated(double variance_factor, Reason reason, std::string where) {
  const double factor = std::sqrt(variance_factor);
  if (factor < kTooMuchWorse) return;
  Say(reason, factor, kTooMuchWorse);
  findings_.back().where = std::move(where);
}

// Where control contradicts what GNSS positions have in common.
void FindingsAbout::SayShiftOfGnss(std::size_t used, std::size_t observed) {
  if (!result_.converged || !system_.EstimatesCommonGnssShift()) return;
  const Vector6d& shift_m =
      system_.groups[static_cast<std::size_t>(system_.common_gnss_shift.group)];
  Say(Reason::kGnssPerhapsOfAnotherDatum, static_cast<double>(used), static_cast<double>(observed));
  findings_.back().where =
      fmt::format("dx {:.2f} dy {:.2f} dz {:.2f} m", shift_m[0], shift_m[1], shift_m[2]);
}

// Image and ground of control that one photo sees can hardly be told apart.
void FindingsAbout::SayControl() {
  SayWorseThanStated(
      std::max(system_.Factor(RowKind::kControlImage), system_.Factor(RowKind::kControlGround)),
      Reason::kControlWorseThanStated);
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
    SayWorseThanStated(system_.Factor(RowKind::kGnss), Reason::kGnssWorseThanStated);
  SayShiftOfGnss(observed.size() - rejected.size(), observed.size());
}

void FindingsAbout::SayApproximations() {
  const auto rejected = PhotosThat([](const AdjustedPhoto& photo) { return photo.prior_rejected; });
  SayOf(rejected, Reason::kApproximationsRejected);
  const auto observed = std::count_if(system_.prior_row.begin(), system_.prior_row.end(),
                                      [](int row) { return row >= 0; });
  if (std::ssize(rejected) < observed)
    SayWorseThanStated(system_.Factor(RowKind::kPosePrior), Reason::kApproximationsWorseThanStated,
                       ", and their weight as observations is reduced accordingly.");
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
