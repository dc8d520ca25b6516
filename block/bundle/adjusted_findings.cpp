#include "block/bundle/adjusted_findings.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "block/bundle/connected_parts.h"

namespace orient::block {
namespace {

// Ratio of actual to stated standard deviation from which a finding is added.
constexpr double kTooMuchWorse = 3;

// For each photo, the mean height of the points observed in it.
std::vector<double> MeanGroundHeights(const BlockToAdjust& block, const BlockResult& result) {
  std::vector<double> heights(block.photos.size(), 0);
  std::vector<int> counts(heights.size(), 0);
  for (std::size_t i = 0; i < block.observations.size(); ++i) {
    const ImageObservation& o = block.observations[i];
    if (result.observations[i].state != ObservationState::kUsed) continue;
    heights[o.photo] += result.points[o.point].ground_m.z();
    ++counts[o.photo];
  }
  for (std::size_t i = 0; i < heights.size(); ++i)
    if (counts[i] > 0) heights[i] /= counts[i];
  return heights;
}

class FindingsAbout {
 public:
  FindingsAbout(const BlockToAdjust& block, GnssModel gnss, const BlockResult& result)
      : block_(block), gnss_(gnss), result_(result) {}

  Findings All() {
    for (const BlockPart& part : result_.parts)
      if (part.finding && !IsSaid(*part.finding)) findings_.push_back(*part.finding);
    ReportControl();
    ReportGnss();
    ReportApproximations();
    ReportPhotos(PhotosThat([](const AdjustedPhoto& photo) {
                   return photo.state == PhotoState::kUndetermined;
                 }),
                 Reason::kPhotosUndetermined);
    if (result_.converged) ReportDistancesLeftOpen();
    return std::move(findings_);
  }

 private:
  // Parts of a block that was adjusted in sub-blocks may share a finding.
  bool IsSaid(const Finding& finding) const {
    return std::any_of(findings_.begin(), findings_.end(), [&](const Finding& said) {
      return said.reason == finding.reason && said.where == finding.where;
    });
  }
  template <typename Condition>
  std::vector<std::size_t> PhotosThat(const Condition& condition) const {
    std::vector<std::size_t> photos;
    for (std::size_t i = 0; i < result_.photos.size(); ++i)
      if (condition(result_.photos[i])) photos.push_back(i);
    return photos;
  }

  void Report(Reason reason, std::optional<double> value, std::optional<double> limit = {}) {
    findings_.push_back({.reason = reason, .value = value, .limit = limit});
  }
  void ReportPhotos(const std::vector<std::size_t>& photos, Reason reason);
  void ReportWorseThanStated(double variance_factor, Reason reason, std::string where = {});
  void ReportShiftOfGnss();
  void ReportControl();
  void ReportGnss();
  void ReportApproximations();
  void ReportDistancesLeftOpen();

  const BlockToAdjust& block_;
  GnssModel gnss_;
  const BlockResult& result_;
  Findings findings_;
};

// Adds a finding that names the photos, if there are any.
void FindingsAbout::ReportPhotos(const std::vector<std::size_t>& photos, Reason reason) {
  if (photos.empty()) return;
  findings_.push_back({.reason = reason,
                       .value = static_cast<double>(photos.size()),
                       .where = NamesOf(block_, photos)});
}

// Adds a finding with the ratio of actual to stated standard deviation, if it is too large.
void FindingsAbout::ReportWorseThanStated(double variance_factor, Reason reason,
                                          std::string where) {
  const double factor = std::sqrt(variance_factor);
  if (factor < kTooMuchWorse) return;
  Report(reason, factor, kTooMuchWorse);
  findings_.back().where = std::move(where);
}

// Adds a finding if control contradicts a shift common to all GNSS positions.
void FindingsAbout::ReportShiftOfGnss() {
  if (!result_.converged) return;
  for (const StripGnss& strip : result_.strips) {
    if (!strip.of_all) continue;
    Report(Reason::kGnssPerhapsOfAnotherDatum, strip.used, strip.observed);
    findings_.back().where = fmt::format("dx {:.2f} dy {:.2f} dz {:.2f} m", strip.shift_m[0],
                                         strip.shift_m[1], strip.shift_m[2]);
  }
}

void FindingsAbout::ReportControl() {
  ReportWorseThanStated(result_.factors.control, Reason::kControlWorseThanStated);
}

void FindingsAbout::ReportGnss() {
  const bool plain = gnss_ == GnssModel::kPlain;
  const auto observed =
      PhotosThat([](const AdjustedPhoto& photo) { return photo.gnss_residual_m.has_value(); });
  const auto rejected = PhotosThat([](const AdjustedPhoto& photo) { return photo.gnss_rejected; });
  if (plain && observed.size() > 1 && rejected.size() == observed.size())
    Report(Reason::kGnssDisagreesEverywhere, static_cast<double>(observed.size()));
  else
    ReportPhotos(rejected, Reason::kGnssRejected);
  if (rejected.size() < observed.size())
    ReportWorseThanStated(result_.factors.gnss, Reason::kGnssWorseThanStated);
  ReportShiftOfGnss();
}

void FindingsAbout::ReportApproximations() {
  const auto rejected = PhotosThat([](const AdjustedPhoto& photo) { return photo.prior_rejected; });
  ReportPhotos(rejected, Reason::kApproximationsRejected);
  const auto observed = std::count_if(
      block_.photos.begin(), block_.photos.end(),
      [](const BlockPhoto& photo) { return photo.prior && !StatedElements(*photo.prior).empty(); });
  if (std::ssize(rejected) < observed)
    ReportWorseThanStated(result_.factors.approximations, Reason::kApproximationsWorseThanStated,
                          ", and their weight as observations is reduced accordingly.");
}

// An error of the principal distance that the block cannot detect goes into its flying heights.
// If GNSS fixes these, both are determined about equally well.
void FindingsAbout::ReportDistancesLeftOpen() {
  if (result_.calibration.empty()) return;
  constexpr double kMuchMore = 3;
  const std::vector<double> ground_m = MeanGroundHeights(block_, result_);
  for (const CalibrationParameter& parameter : result_.calibration) {
    if (parameter.name != kPrincipalDistanceName || parameter.state == CalibrationState::kEstimated)
      continue;
    const double share = parameter.sigma / block_.cameras[parameter.camera].principal_distance_mm;
    for (std::size_t i = 0; i < result_.photos.size(); ++i) {
      const AdjustedPhoto& photo = result_.photos[i];
      if (photo.state != PhotoState::kAdjusted || block_.photos[i].camera != parameter.camera)
        continue;
      const double height_m = photo.pose.position_m.z() - ground_m[i];
      if (share * height_m <= kMuchMore * std::sqrt(photo.covariance(2, 2))) continue;
      Report(Reason::kDistanceLeftOpen, parameter.sigma);
      break;
    }
  }
}

}  // namespace

Findings FindingsOfAdjusted(const BlockToAdjust& block, const BlockOptions& options,
                            const BlockResult& result) {
  return FindingsAbout(block, options.gnss, result).All();
}

}  // namespace orient::block
