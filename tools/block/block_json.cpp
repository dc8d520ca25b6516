#include "tools/block/block_json.h"

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "core/files/atomic_write.h"

namespace orient {
namespace {
using Json = nlohmann::ordered_json;

Json Number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

template <typename Vector>
Json VectorJson(const Vector& v) {
  Json json = Json::array();
  for (Eigen::Index i = 0; i < v.size(); ++i) json.push_back(Number(v[i]));
  return json;
}

Json SightingJson(const AdjustedBlock& adjusted, std::size_t i) {
  const ImageObservation& observation = adjusted.block.observations[i];
  const ObservationResult& result = adjusted.result.observations[i];
  return {{"photo", adjusted.block.photos[observation.photo].name},
          {"pixel", VectorJson(observation.pixel)},
          {"state", Name(result.state)},
          {"residual_px", VectorJson(result.residual_px)},
          {"w", Number(result.w)},
          {"redundancy", Number(result.redundancy)}};
}

Json PointJson(const AdjustedBlock& adjusted, std::size_t point,
               const std::vector<std::size_t>& observations) {
  const AdjustedPoint& result = adjusted.result.points[point];
  const BlockPoint& given = adjusted.block.points[point];
  Json json = {{"id", given.id}};
  if (given.control) {
    json["state"] = given.held_out ? "check" : result.control_rejected ? "rejected" : "used";
    json["given"] = VectorJson(given.control->ground_m);
    json["residual_m"] = VectorJson(result.control_residual_m);
    json["w"] = Number(result.control_w);
  }
  json["ground"] = result.adjusted ? VectorJson(result.ground_m) : Json(nullptr);
  if (result.adjusted) {
    const Eigen::Vector3d sigma = result.covariance_m2.diagonal().cwiseMax(0).cwiseSqrt();
    json["sigma_m"] = VectorJson(sigma);
  }
  json["rays"] = result.rays;
  Json seen = Json::array();
  for (const std::size_t i : observations) seen.push_back(SightingJson(adjusted, i));
  json["seen"] = std::move(seen);
  return json;
}

Json ComponentsJson(const BlockResult& result) {
  Json components = Json::array();
  for (const VarianceComponent& component : result.components)
    components.push_back({{"group", component.group},
                          {"factor", Number(component.factor)},
                          {"sigma_factor", Number(std::sqrt(component.factor))},
                          {"redundancy", Number(component.redundancy)},
                          {"sigma0_px", Number(component.sigma0_px)},
                          {"estimated", component.estimated}});
  return components;
}

Json PartsJson(const AdjustedBlock& adjusted) {
  Json parts = Json::array();
  for (const BlockPart& part : adjusted.result.parts) {
    Json photos = Json::array();
    for (const std::size_t i : part.photos) photos.push_back(adjusted.block.photos[i].name);
    parts.push_back({{"photos", std::move(photos)},
                     {"control_points", part.control_points},
                     {"by_control", part.by_control},
                     {"message", part.message}});
  }
  return parts;
}

Json CalibrationJson(const AdjustedBlock& adjusted) {
  Json calibration = Json::array();
  for (const CalibrationParameter& parameter : adjusted.result.calibration)
    calibration.push_back({{"parameter", parameter.name},
                           {"correction", Number(parameter.value)},
                           {"sigma", Number(parameter.sigma)},
                           {"t", Number(parameter.t)},
                           {"state", Name(parameter.state)}});
  return calibration;
}

Json ChecksJson(const AdjustedBlock& adjusted) {
  Json checks = Json::array();
  for (const CheckPatch& check : adjusted.result.checks) {
    Json residuals = Json::array();
    for (const Eigen::Vector2d& residual : check.image_residuals_px)
      residuals.push_back(VectorJson(residual));
    checks.push_back(
        {{"id", adjusted.block.points[check.point].id},
         {"rays", check.rays},
         {"ground_residual_m",
          check.ground_residual_m ? VectorJson(*check.ground_residual_m) : Json(nullptr)},
         {"image_residuals_px", std::move(residuals)}});
  }
  const auto rms = CheckRmsPx(adjusted.result);
  return {{"rms_px", rms ? Json(*rms) : Json(nullptr)},
          {"rejected_alone", adjusted.checks_rejected_alone},
          {"patches", std::move(checks)}};
}

}  // namespace

std::optional<double> CheckRmsPx(const BlockResult& result) {
  double sum = 0;
  int count = 0;
  for (const CheckPatch& check : result.checks)
    for (const Eigen::Vector2d& residual : check.image_residuals_px) {
      sum += residual.squaredNorm();
      ++count;
    }
  if (count == 0) return std::nullopt;
  return std::sqrt(sum / count);
}

std::string WriteBlockJson(const std::string& directory, const AdjustedBlock& adjusted,
                           const std::vector<std::string>& messages) {
  std::vector<std::vector<std::size_t>> seen(adjusted.block.points.size());
  for (std::size_t i = 0; i < adjusted.block.observations.size(); ++i)
    seen[adjusted.block.observations[i].point].push_back(i);
  Json ties = Json::array(), control = Json::array();
  for (std::size_t point = 0; point < adjusted.block.points.size(); ++point)
    (point < adjusted.ties ? ties : control).push_back(PointJson(adjusted, point, seen[point]));
  const BlockResult& result = adjusted.result;
  const Json json = {{"converged", result.converged},
                     {"sigma0", Number(result.sigma0)},
                     {"redundancy", Number(result.redundancy)},
                     {"variance_components", ComponentsJson(result)},
                     {"parts", PartsJson(adjusted)},
                     {"calibration", CalibrationJson(adjusted)},
                     {"checks", ChecksJson(adjusted)},
                     {"messages", messages},
                     {"ties", std::move(ties)},
                     {"control", std::move(control)}};
  const std::string path = (std::filesystem::path(directory) / "block.json").string();
  WriteFileAtomically(path, json.dump(1) + "\n");
  return path;
}

}  // namespace orient
