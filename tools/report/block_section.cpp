#include "tools/report/block_section.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "tools/report/figures/adjustment_figures.h"
#include "tools/report/html_text.h"

namespace orient {
namespace {

// "1 photo", "3 photos".
std::string Counted(std::size_t count, const char* one, const char* many) {
  return fmt::format("{} {}", count, count == 1 ? one : many);
}

std::string Facts(const AdjustmentResult& adjusted) {
  return fmt::format(
      "{} ({} in three photos or more) · {} · residuals {} times what was stated (standard "
      "deviation of unit weight), {} degrees of freedom",
      Counted(adjusted.ties.size(), "tie point", "tie points"), TiesInThreePhotosOrMore(adjusted),
      Counted(adjusted.control.size(), "control patch", "control patches"),
      Decimal(adjusted.sigma0, 2), Decimal(adjusted.redundancy, 0));
}

Markup Groups(const AdjustmentResult& adjusted) {
  Markup rows;
  for (const ComponentResult& component : adjusted.components) {
    rows += Fill("adjustment.html#group",
                 {{"group", component.group},
                  {"sigma0", Decimal(ImageSigmaPx(component), 2)},
                  {"factor", Decimal(SigmaOverStated(component), 2)},
                  {"redundancy", Decimal(component.redundancy, 0)},
                  {"origin", component.estimated ? "estimated" : "as stated"}});
  }
  return Fill("adjustment.html#groups", {{"rows", rows}});
}

// More rows than anybody reads; report.json has them all.
constexpr std::size_t kMostRows = 1000;

Markup PhotoRow(const std::string& name, const PhotoSightings& photo) {
  return Fill("adjustment.html#photo",
              {{"photo", name},
               {"ties_used", photo.ties_used},
               {"ties", photo.ties},
               {"control_used", photo.control_used},
               {"control", photo.control},
               {"rms", Decimal(photo.RmsPx(), 2)},
               {"redundancy", Decimal(photo.MeanRedundancy(), 2)},
               {"largest_w", photo.Used() > 0 ? Decimal(photo.largest_w, 1) : kNoValue}});
}

// By name; of too many, those with nothing used and those with the largest residuals.
Markup Photos(const AdjustmentResult& adjusted) {
  const auto sightings = SightingsOf(adjusted);
  std::vector<std::pair<std::string, PhotoSightings>> photos(sightings.begin(), sightings.end());
  const std::size_t more = photos.size() - std::min(photos.size(), kMostRows);
  if (more > 0) {
    std::stable_sort(photos.begin(), photos.end(), [](const auto& a, const auto& b) {
      return a.second.RmsPx().value_or(INFINITY) > b.second.RmsPx().value_or(INFINITY);
    });
    photos.resize(kMostRows);
  }
  Markup rows;
  for (const auto& [name, photo] : photos) rows += PhotoRow(name, photo);
  if (more > 0) rows += Fill("adjustment.html#more_photos", {{"count", more}});
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

Markup Gnss(const AdjustmentResult& adjusted) {
  if (adjusted.gnss.empty()) return {};
  const GroundResiduals residuals = ResidualsOfGnss(adjusted);
  const std::string text = residuals.Count() > 0 ? fmt::format("; residuals {} m (X / Y / Z, RMS)",
                                                               Decimals(residuals.Rms_m(), 2))
                                                 : "";
  return Fill("adjustment.html#gnss", {{"used", residuals.Count()},
                                       {"count", adjusted.gnss.size()},
                                       {"residuals", text},
                                       {"strips", GnssStrips(adjusted)}});
}

// "0.30 / 0.40 / 0.80 m (X / Y / Z, RMS of 2 ...; CE90 0.75 m, LE90 1.32 m)".
std::string OnTheGround(const GroundResiduals& residuals, const char* which) {
  return fmt::format("{} m (X / Y / Z, RMS of {}{}; CE90 {} m, LE90 {} m)",
                     Decimals(residuals.Rms_m(), 2), residuals.Count(), which,
                     Decimal(residuals.Ce90_m(), 2), Decimal(residuals.Le90_m(), 2));
}

Markup Checks(const AdjustmentResult& adjusted) {
  if (adjusted.checks.empty()) return Fill("adjustment.html#no_checks");
  const GroundResiduals residuals = ResidualsOfChecks(adjusted);
  const CheckSightings sightings = SightingsOfChecks(adjusted);
  std::string on_the_ground;
  if (residuals.Count() > 0)
    on_the_ground = "; on the ground " + OnTheGround(residuals, " seen in two photos or more");
  return Fill("adjustment.html#checks", {{"count", adjusted.checks.size()},
                                         {"rms", Decimal(adjusted.CheckRmsPx(), 2)},
                                         {"sightings", sightings.count},
                                         {"median", Decimal(sightings.median_px, 2)},
                                         {"on_the_ground", on_the_ground}});
}

Markup Control(const AdjustmentResult& adjusted) {
  const GroundResiduals residuals = ResidualsOfControl(adjusted);
  if (residuals.Count() == 0) return {};
  return Fill("adjustment.html#control", {{"residuals", OnTheGround(residuals, " used")}});
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
               {"control", Control(adjusted)},
               {"photos", Photos(adjusted)},
               {"groups", Groups(adjusted)},
               {"gnss", Gnss(adjusted)},
               {"parts", Parts(adjusted)},
               {"calibration", Calibration(adjusted)}});
}

}  // namespace orient
