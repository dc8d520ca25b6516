#include "core/files/adjustment_result.h"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <string_view>

#include "core/base/new_file.h"
#include "core/files/result_fields.h"

namespace orient {
namespace {

Json SightingJson(const SightingResult& sighting) {
  return {{"photo", sighting.photo}, {"pixel", {sighting.pixel.x(), sighting.pixel.y()}},
          {"state", sighting.state}, {"residual_px", ToJson(sighting.residual_px)},
          {"w", ToJson(sighting.w)}, {"redundancy", ToJson(sighting.redundancy)}};
}

Json PointJson(const PointResult& point) {
  Json json = {{"id", point.id}};
  if (point.control) {
    json["state"] = point.control->state;
    json["given"] = ToJson(point.control->given_m);
    json["residual_m"] = ToJson(point.control->residual_m);
    json["w"] = ToJson(point.control->w);
  }
  json["ground"] = ToJson(point.ground_m);
  if (point.ground_m) json["sigma_m"] = ToJson(point.sigma_m);
  json["rays"] = point.rays;
  json["seen"] = Json::array();
  for (const SightingResult& sighting : point.seen) json["seen"].push_back(SightingJson(sighting));
  return json;
}

Json ComponentJson(const ComponentResult& component) {
  std::optional<double> sigma_factor;
  if (component.factor) sigma_factor = std::sqrt(*component.factor);
  return {{"group", component.group},
          {"factor", ToJson(component.factor)},
          {"sigma_factor", ToJson(sigma_factor)},
          {"redundancy", ToJson(component.redundancy)},
          {"sigma0_px", ToJson(component.sigma0_px)},
          {"estimated", component.estimated}};
}

Json PartJson(const PartResult& part) {
  return {{"photos", part.photos},
          {"control_points", part.control_points},
          {"by_control", part.by_control},
          {"message", part.finding ? Sentence(*part.finding) : ""},
          {"finding", part.finding ? FindingJson(*part.finding) : Json(nullptr)}};
}

Json CalibrationJson(const CalibrationResult& parameter) {
  return {{"parameter", parameter.parameter},
          {"correction", ToJson(parameter.correction)},
          {"sigma", ToJson(parameter.sigma)},
          {"t", ToJson(parameter.t)},
          {"state", parameter.state}};
}

Json CheckJson(const CheckResult& check) {
  Json residuals = Json::array();
  for (const Eigen::Vector2d& residual : check.image_residuals_px)
    residuals.push_back({residual.x(), residual.y()});
  return {{"id", check.id},
          {"rays", check.rays},
          {"ground_residual_m", ToJson(check.ground_residual_m)},
          {"image_residuals_px", std::move(residuals)}};
}

Json PoseObservationJson(const PoseObservationResult& observation) {
  return {{"photo", observation.photo},
          {"state", observation.state},
          {"residual_m", ToJson(observation.residual_m)},
          {"w", ToJson(observation.w)}};
}

Json GnssStripJson(const GnssStripResult& strip) {
  return {{"strip", strip.strip},
          {"shift_m", ToJson(strip.shift_m)},
          {"shift_sigma_m", ToJson(strip.shift_sigma_m)},
          {"drift_m", ToJson(strip.drift_m)},
          {"drift_sigma_m", ToJson(strip.drift_sigma_m)}};
}

template <typename Record>
Json ListJson(const std::vector<Record>& records, Json (*make)(const Record&)) {
  Json list = Json::array();
  for (const Record& record : records) list.push_back(make(record));
  return list;
}

// Appends a member to the document written by dump(1), point by point: large blocks have millions
// of them.
void WritePoints(const char* key, const std::vector<PointResult>& points, NewFile* file) {
  constexpr std::size_t kPiece = 1 << 20;
  std::string text = fmt::format(",\n \"{}\": [", key);
  for (const PointResult& point : points) {
    text += &point == &points.front() ? "\n  " : ",\n  ";
    for (const char c : PointJson(point).dump(1)) {
      text += c;
      if (c == '\n') text += "  ";
    }
    if (text.size() < kPiece) continue;
    file->Write(text);
    text.clear();
  }
  file->Write(text + (points.empty() ? "]" : "\n ]"));
}

SightingResult Sighting(const JsonField& field) {
  return {field.At("photo").AsString(), field.At("pixel").AsVector2(),
          field.At("state").AsString(), field.FindVector2("residual_px"),
          field.FindNumber("w"),        field.FindNumber("redundancy")};
}

template <typename Record>
std::vector<Record> List(const JsonField& field, Record (*read)(const JsonField&)) {
  std::vector<Record> records;
  for (const JsonField& element : field.Elements()) records.push_back(read(element));
  return records;
}

PointResult Point(const JsonField& field) {
  PointResult point;
  point.id = field.At("id").AsInteger();
  if (const auto state = field.Find("state"))
    point.control = ControlResult{state->AsString(), field.FindVector3("given"),
                                  field.FindVector3("residual_m"), field.FindNumber("w")};
  point.ground_m = field.FindVector3("ground");
  point.sigma_m = field.FindVector3("sigma_m");
  point.rays = field.At("rays").AsInt();
  point.seen = List(field.At("seen"), &Sighting);
  return point;
}

ComponentResult Component(const JsonField& field) {
  return {field.At("group").AsString(), field.FindNumber("factor"), field.FindNumber("redundancy"),
          field.FindNumber("sigma0_px"), field.At("estimated").AsFlag()};
}

PartResult Part(const JsonField& field) {
  PartResult part{field.At("photos").AsStrings(),
                  field.At("control_points").AsInt(),
                  field.At("by_control").AsFlag(),
                  {}};
  if (const auto finding = field.Find("finding"))
    part.finding = ReadFinding(*finding);
  else if (std::string message = field.At("message").AsString(); !message.empty())
    part.finding = Stated(std::move(message));  // of an earlier version
  return part;
}

CalibrationResult Calibration(const JsonField& field) {
  return {field.At("parameter").AsString(), field.FindNumber("correction"),
          field.FindNumber("sigma"), field.FindNumber("t"), field.At("state").AsString()};
}

PoseObservationResult PoseObservation(const JsonField& field) {
  return {field.At("photo").AsString(), field.At("state").AsString(),
          field.FindVector3("residual_m"), field.FindNumber("w")};
}

GnssStripResult GnssStrip(const JsonField& field) {
  return {field.At("strip").AsString(), field.FindVector3("shift_m"),
          field.FindVector3("shift_sigma_m"), field.FindVector3("drift_m"),
          field.FindVector3("drift_sigma_m")};
}

CheckResult Check(const JsonField& field) {
  CheckResult check;
  check.id = field.At("id").AsInteger();
  check.rays = field.At("rays").AsInt();
  check.ground_residual_m = field.FindVector3("ground_residual_m");
  for (const JsonField& residual : field.At("image_residuals_px").Elements())
    check.image_residuals_px.push_back(residual.AsVector2());
  return check;
}

}  // namespace

std::optional<double> AdjustmentResult::CheckRmsPx() const {
  double sum = 0;
  int count = 0;
  for (const CheckResult& check : checks)
    for (const Eigen::Vector2d& residual : check.image_residuals_px) {
      sum += residual.squaredNorm();
      ++count;
    }
  if (count == 0) return std::nullopt;
  return std::sqrt(sum / count);
}

std::string AdjustmentResultPath(const std::string& directory) {
  return (std::filesystem::path(directory) / "block.json").string();
}

void WriteAdjustmentResult(const std::string& directory, const AdjustmentResult& result) {
  Json json = {{"converged", result.converged},
               {"sigma0", ToJson(result.sigma0)},
               {"redundancy", ToJson(result.redundancy)},
               {"variance_components", ListJson(result.components, &ComponentJson)},
               {"parts", ListJson(result.parts, &PartJson)},
               {"calibration", ListJson(result.calibration, &CalibrationJson)},
               {"checks",
                {{"rms_px", ToJson(result.CheckRmsPx())},
                 {"rejected_alone", result.checks_rejected_alone},
                 {"patches", ListJson(result.checks, &CheckJson)}}}};
  WriteFindings(result.findings, &json);
  json["approximations"] = ListJson(result.approximations, &PoseObservationJson);
  json["gnss"] = {{"positions", ListJson(result.gnss, &PoseObservationJson)},
                  {"strips", ListJson(result.gnss_strips, &GnssStripJson)}};
  std::string text = json.dump(1);
  text.resize(text.size() - std::string_view("\n}").size());
  NewFile file(AdjustmentResultPath(directory));
  file.Write(text);
  WritePoints("ties", result.ties, &file);
  WritePoints("control", result.control, &file);
  file.Write("\n}\n");
  file.Keep();
}

AdjustmentResult ReadAdjustmentResult(const std::string& path) {
  AdjustmentResult result;
  const Json document = ParseJsonFile(
      path, {{"ties", [&](const JsonField& tie) { result.ties.push_back(Point(tie)); }},
             {"control", [&](const JsonField& point) { result.control.push_back(Point(point)); }}});
  const JsonField field(document, path);
  result.converged = field.At("converged").AsFlag();
  result.sigma0 = field.FindNumber("sigma0");
  result.redundancy = field.FindNumber("redundancy");
  result.components = List(field.At("variance_components"), &Component);
  result.parts = List(field.At("parts"), &Part);
  result.calibration = List(field.At("calibration"), &Calibration);
  result.checks_rejected_alone = static_cast<int>(
      field.At("checks").FindNumber("rejected_alone").value_or(0));  // added in a later version
  result.checks = List(field.At("checks").At("patches"), &Check);
  result.findings = ReadFindings(field);
  if (const auto known = field.Find("approximations"))  // added in a later version, like GNSS
    result.approximations = List(*known, &PoseObservation);
  if (const auto gnss = field.Find("gnss")) {
    result.gnss = List(gnss->At("positions"), &PoseObservation);
    result.gnss_strips = List(gnss->At("strips"), &GnssStrip);
  }
  for (const char* list : {"ties", "control"}) field.At(list).Elements();  // they must be there
  return result;
}

}  // namespace orient
