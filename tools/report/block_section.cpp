#include "tools/report/block_section.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "core/base/median.h"
#include "tools/report/html_text.h"

namespace orient {
namespace {

// Sightings of one photo: how many there are and what they are worth.
struct PhotoSightings {
  int ties = 0, ties_used = 0, control = 0, control_used = 0;
  double squares_px2 = 0;  // of used ones' residuals
  double redundancy = 0;   // of used ones, of both coordinates
  double largest_w = 0;

  int Used() const { return ties_used + control_used; }
  std::optional<double> RmsPx() const {
    if (Used() == 0) return std::nullopt;
    return std::sqrt(squares_px2 / Used());
  }
  std::optional<double> MeanRedundancy() const {
    if (Used() == 0) return std::nullopt;
    return 0.5 * redundancy / Used();
  }
};

using SightingsByPhoto = std::map<std::string, PhotoSightings>;

void Count(const std::vector<PointResult>& points, bool ties, SightingsByPhoto* photos) {
  for (const PointResult& point : points)
    for (const SightingResult& sighting : point.seen) {
      PhotoSightings& photo = (*photos)[sighting.photo];
      const bool used = sighting.state == "used";
      ++(ties ? photo.ties : photo.control);
      if (!used) continue;
      ++(ties ? photo.ties_used : photo.control_used);
      if (sighting.residual_px) photo.squares_px2 += sighting.residual_px->squaredNorm();
      photo.redundancy += sighting.redundancy.value_or(0);
      photo.largest_w = std::max(photo.largest_w, sighting.w.value_or(0));
    }
}

std::string Facts(const AdjustmentResult& adjusted) {
  const auto n = adjusted.ties.size();
  const auto manifold = std::count_if(adjusted.ties.begin(), adjusted.ties.end(),
                                      [](const PointResult& tie) { return tie.rays >= 3; });
  return fmt::format(
      "{} tie {} ({} in three photos or more) · {} control patches · residuals {} times what was "
      "stated (standard deviation of unit weight), {} degrees of freedom",
      n, n == 1 ? "point" : "points", manifold, adjusted.control.size(),
      Decimal(adjusted.sigma0, 2), Decimal(adjusted.redundancy, 0));
}

Markup Groups(const AdjustmentResult& adjusted) {
  Markup rows;
  for (const ComponentResult& component : adjusted.components) {
    std::optional<double> factor;
    if (component.factor) factor = std::sqrt(*component.factor);
    const bool image = component.sigma0_px.value_or(0) > 0;
    rows += Fill("adjustment.html#group",
                 {{"group", component.group},
                  {"sigma0", image ? Decimal(component.sigma0_px, 2) : kNoValue},
                  {"factor", Decimal(factor, 2)},
                  {"redundancy", Decimal(component.redundancy, 0)},
                  {"origin", component.estimated ? "estimated" : "as stated"}});
  }
  return Fill("adjustment.html#groups", {{"rows", rows}});
}

Markup Photos(const AdjustmentResult& adjusted) {
  SightingsByPhoto photos;
  Count(adjusted.ties, true, &photos);
  Count(adjusted.control, false, &photos);
  Markup rows;
  for (const auto& [name, photo] : photos)
    rows += Fill("adjustment.html#photo",
                 {{"photo", name},
                  {"ties_used", photo.ties_used},
                  {"ties", photo.ties},
                  {"control_used", photo.control_used},
                  {"control", photo.control},
                  {"rms", Decimal(photo.RmsPx(), 2)},
                  {"redundancy", Decimal(photo.MeanRedundancy(), 2)},
                  {"largest_w", photo.Used() > 0 ? Decimal(photo.largest_w, 1) : kNoValue}});
  return Fill("adjustment.html#photos", {{"rows", rows}});
}

std::string ThreeMetres(const std::optional<Eigen::Vector3d>& value,
                        const std::optional<Eigen::Vector3d>& sigma) {
  if (!value || !sigma) return kNoValue;
  std::vector<std::string> metres;
  for (int i = 0; i < 3; ++i)
    metres.push_back(Decimal((*value)[i], 2) + " ± " + Decimal((*sigma)[i], 2));
  return Joined(metres, " / ");
}

Markup GnssStrips(const AdjustmentResult& adjusted) {
  if (adjusted.gnss_strips.empty()) return {};
  Markup rows;
  for (const GnssStripResult& strip : adjusted.gnss_strips)
    rows += Fill("adjustment.html#gnss_strip",
                 {{"strip", strip.strip.empty() ? kNoValue : strip.strip},
                  {"shift", ThreeMetres(strip.shift_m, strip.shift_sigma_m)},
                  {"drift", ThreeMetres(strip.drift_m, strip.drift_sigma_m)}});
  return Fill("adjustment.html#gnss_strips", {{"rows", rows}});
}

// Root mean square by component, where there is anything.
class Rms {
 public:
  void Add(const Eigen::Vector3d& residual) {
    squares_ += residual.cwiseAbs2();
    ++count_;
  }
  int Count() const { return count_; }
  std::string Text() const { return Decimals((squares_ / count_).cwiseSqrt(), 2); }

 private:
  Eigen::Vector3d squares_ = Eigen::Vector3d::Zero();
  int count_ = 0;
};

Markup Gnss(const AdjustmentResult& adjusted) {
  if (adjusted.gnss.empty()) return {};
  Rms rms;
  for (const PoseObservationResult& position : adjusted.gnss)
    if (position.state == "used" && position.residual_m) rms.Add(*position.residual_m);
  const std::string residuals =
      rms.Count() > 0 ? fmt::format("; residuals {} m (X / Y / Z, RMS)", rms.Text()) : "";
  return Fill("adjustment.html#gnss", {{"used", rms.Count()},
                                       {"count", adjusted.gnss.size()},
                                       {"residuals", residuals},
                                       {"strips", GnssStrips(adjusted)}});
}

Markup Checks(const AdjustmentResult& adjusted) {
  if (adjusted.checks.empty()) return Fill("adjustment.html#no_checks");
  std::vector<double> lengths;
  Rms rms;
  for (const CheckResult& check : adjusted.checks) {
    for (const Eigen::Vector2d& residual : check.image_residuals_px)
      lengths.push_back(residual.norm());
    if (check.ground_residual_m) rms.Add(*check.ground_residual_m);
  }
  std::string on_the_ground;
  if (rms.Count() > 0)
    on_the_ground =
        fmt::format("; on the ground {} m (X / Y / Z, RMS of {} seen in two photos or more)",
                    rms.Text(), rms.Count());
  return Fill("adjustment.html#checks",
              {{"count", adjusted.checks.size()},
               {"rms", Decimal(adjusted.CheckRmsPx(), 2)},
               {"sightings", lengths.size()},
               {"median", lengths.empty() ? kNoValue : Decimal(Median(lengths), 2)},
               {"on_the_ground", on_the_ground}});
}

Markup Parts(const AdjustmentResult& adjusted) {
  const bool all_said = std::all_of(adjusted.parts.begin(), adjusted.parts.end(),
                                    [](const PartResult& part) { return !part.finding; });
  if (adjusted.parts.size() < 2 && all_said) return {};
  Markup rows;
  for (const PartResult& part : adjusted.parts) {
    constexpr std::size_t kMostNames = 6;
    std::vector<std::string> names = part.photos;
    if (names.size() > kMostNames) {
      names.resize(kMostNames);
      names.push_back("…");
    }
    rows +=
        Fill("adjustment.html#part", {{"names", Joined(names, ", ")},
                                      {"photos", part.photos.size()},
                                      {"control", part.control_points},
                                      {"message", part.finding ? Sentence(*part.finding) : ""}});
  }
  return Fill("adjustment.html#parts", {{"rows", rows}});
}

Markup Calibration(const AdjustmentResult& adjusted) {
  if (adjusted.calibration.empty()) return {};
  const auto number = [](const std::optional<double>& value) {
    return value ? fmt::format("{:.3g}", *value) : kNoValue;
  };
  Markup rows;
  for (const CalibrationResult& parameter : adjusted.calibration)
    rows += Fill("adjustment.html#parameter", {{"parameter", parameter.parameter},
                                               {"correction", number(parameter.correction)},
                                               {"sigma", number(parameter.sigma)},
                                               {"t", Decimal(parameter.t, 1)},
                                               {"state", parameter.state}});
  return Fill("adjustment.html#calibration", {{"rows", rows}});
}

}  // namespace

Markup AdjustmentSection(const BlockRecord& block) {
  if (!block.adjusted) return {};
  const AdjustmentResult& adjusted = *block.adjusted;
  return Fill("adjustment.html",
              {{"warning", adjusted.converged ? Markup() : Fill("adjustment.html#not_converged")},
               {"facts", Facts(adjusted)},
               {"checks", Checks(adjusted)},
               {"photos", Photos(adjusted)},
               {"groups", Groups(adjusted)},
               {"gnss", Gnss(adjusted)},
               {"parts", Parts(adjusted)},
               {"calibration", Calibration(adjusted)}});
}

}  // namespace orient
