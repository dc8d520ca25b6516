#include "block/verdict/adjustment_summary.h"

namespace orient::block {
namespace {

SightingResult Sighting(const AdjustedBlock& adjusted, std::size_t i) {
  const ImageObservation& observation = adjusted.block.observations[i];
  const ObservationResult& result = adjusted.result.observations[i];
  return {adjusted.block.photos[observation.photo].name,
          observation.pixel,
          Name(result.state),
          result.residual_px,
          result.w,
          result.redundancy};
}

PointResult Point(const AdjustedBlock& adjusted, std::size_t point,
                  const std::vector<std::size_t>& observations) {
  const AdjustedPoint& result = adjusted.result.points[point];
  const BlockPoint& given = adjusted.block.points[point];
  PointResult record;
  record.id = given.id;
  if (given.control)
    record.control =
        ControlResult{given.held_out            ? "check"
                      : result.control_rejected ? "rejected"
                                                : "used",
                      given.control->ground_m, result.control_residual_m, result.control_w};
  if (result.adjusted) {
    record.ground_m = result.ground_m;
    record.sigma_m = result.covariance_m2.diagonal().cwiseMax(0).cwiseSqrt();
  }
  record.rays = result.rays;
  for (const std::size_t i : observations) record.seen.push_back(Sighting(adjusted, i));
  return record;
}

void AddPoints(const AdjustedBlock& adjusted, AdjustmentResult* summary) {
  std::vector<std::vector<std::size_t>> seen(adjusted.block.points.size());
  for (std::size_t i = 0; i < adjusted.block.observations.size(); ++i)
    seen[adjusted.block.observations[i].point].push_back(i);
  for (std::size_t point = 0; point < seen.size(); ++point)
    (point < adjusted.ties ? summary->ties : summary->control)
        .push_back(Point(adjusted, point, seen[point]));
}

PartResult Part(const AdjustedBlock& adjusted, const BlockPart& part) {
  PartResult record{{}, part.control_points, part.by_control, part.finding};
  for (const std::size_t i : part.photos) record.photos.push_back(adjusted.block.photos[i].name);
  return record;
}

void AddPoseObservations(const AdjustedBlock& adjusted, AdjustmentResult* summary) {
  const auto state = [](bool rejected) { return rejected ? "rejected" : "used"; };
  for (std::size_t i = 0; i < adjusted.block.photos.size(); ++i) {
    const BlockPhoto& given = adjusted.block.photos[i];
    const AdjustedPhoto& photo = adjusted.result.photos[i];
    if (photo.state != PhotoState::kAdjusted) continue;
    if (given.prior)
      summary->approximations.push_back(
          {given.name, state(photo.prior_rejected), std::nullopt, photo.prior_w});
    if (given.gnss)
      summary->gnss.push_back(
          {given.name, state(photo.gnss_rejected), photo.gnss_residual_m, photo.gnss_w});
  }
  for (const StripGnss& strip : adjusted.result.strips)
    summary->gnss_strips.push_back(
        {strip.strip, strip.shift_m, strip.shift_sigma_m, strip.drift_m, strip.drift_sigma_m});
}

}  // namespace

AdjustmentResult SummaryOf(const AdjustedBlock& adjusted, const Findings& findings) {
  const BlockResult& result = adjusted.result;
  AdjustmentResult summary;
  summary.converged = result.converged;
  summary.sigma0 = result.sigma0;
  summary.redundancy = result.redundancy;
  for (const VarianceComponent& component : result.components)
    summary.components.push_back({component.group, component.factor, component.redundancy,
                                  component.sigma0_px, component.estimated});
  for (const BlockPart& part : result.parts) summary.parts.push_back(Part(adjusted, part));
  for (const CalibrationParameter& parameter : result.calibration)
    summary.calibration.push_back(
        {parameter.name, parameter.value, parameter.sigma, parameter.t, Name(parameter.state)});
  for (const CheckPatch& check : result.checks)
    summary.checks.push_back({adjusted.block.points[check.point].id, check.rays,
                              check.ground_residual_m, check.image_residuals_px});
  summary.checks_rejected_alone = adjusted.checks_rejected_alone;
  summary.findings = findings;
  AddPoints(adjusted, &summary);
  AddPoseObservations(adjusted, &summary);
  return summary;
}

}  // namespace orient::block
