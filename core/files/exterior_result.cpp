#include <array>
#include <cmath>
#include <limits>
#include <map>

#include "core/base/atomic_write.h"
#include "core/files/result_fields.h"

namespace orient {
namespace {

constexpr std::array kPatchStates = {PatchState::kMatched, PatchState::kNotFound,
                                     PatchState::kRejected, PatchState::kNotVisible};

Json PoseJson(const std::optional<Pose>& pose) {
  if (!pose) return nullptr;
  const auto degrees = [&](int i) { return DegFromRad(NormalizeAngle(pose->opk_rad[i])); };
  return {{"x", pose->position_m.x()}, {"y", pose->position_m.y()}, {"z", pose->position_m.z()},
          {"omega", degrees(0)},       {"phi", degrees(1)},         {"kappa", degrees(2)}};
}

Json StartJson(const StartingPose& start) {
  Json json = PoseJson(start.pose), sigma = Json::array();
  for (int i = 0; i < 6; ++i) sigma.push_back(i < 3 ? start.sigma[i] : DegFromRad(start.sigma[i]));
  json["sigma"] = std::move(sigma);
  return json;
}

Json VectorJson(const Eigen::Vector3d& v) { return Json::array({v.x(), v.y(), v.z()}); }

Json RoundJson(const LoopRound& round) {
  return {{"searched", round.searched},
          {"matched", round.matched},
          {"window_px", ToJson(std::optional(round.window_px))},
          {"rms_px", ToJson(std::optional(round.rms_px))},
          {"reduction", round.reduction}};
}

// Without Reason::kStated, which consists of a sentence only.
Json ReasonCodes(const Findings& findings) {
  Json codes = Json::array();
  for (const Finding& finding : findings)
    if (finding.reason != Reason::kStated) codes.push_back(Code(finding.reason));
  return codes;
}

Json PatchJson(const PatchResult& patch) {
  return {{"id", patch.id},
          {"source", patch.source ? Json(*patch.source) : Json(nullptr)},
          {"state", Name(patch.state)},
          {"ground", patch.ground_m ? VectorJson(*patch.ground_m) : Json(nullptr)},
          {"predicted", ToJson(patch.predicted)},
          {"pixel", ToJson(patch.pixel)},
          {"sigma_px", ToJson(patch.sigma_px)},
          {"residual_px", ToJson(patch.residual_px)},
          {"ncc", ToJson(patch.ncc)},
          {"reason", JoinedSentences(patch.findings)},
          {"reason_codes", ReasonCodes(patch.findings)}};
}

// How many patches were not searched for, for each reason.
Json NotVisibleJson(const std::vector<PatchResult>& patches) {
  std::map<std::string, int> counts;
  for (const PatchResult& patch : patches)
    if (patch.state == PatchState::kNotVisible) ++counts[JoinedSentences(patch.findings)];
  return counts;
}

Json AloneJson(const AloneResult& alone) {
  Json json = {{"status", Name(alone.status)},
               {"pose", PoseJson(alone.pose)},
               {"covariance", alone.covariance ? MatrixJson(*alone.covariance) : Json(nullptr)},
               {"sigma0_px", ToJson(alone.sigma0_px)}};
  WriteFindings(alone.findings, &json);
  return json;
}

Json ExteriorJson(const ExteriorResult& result) {
  if (result.pose) RequireFinite(result.pose->AsVector().allFinite(), result.photo, "pose");
  if (result.covariance) RequireFinite(result.covariance->allFinite(), result.photo, "covariance");
  Json iterations = Json::array(), patches = Json::array();
  Json footprint = Json::array();
  for (const Eigen::Vector3d& corner : result.footprint_m) footprint.push_back(VectorJson(corner));
  for (const LoopRound& round : result.iterations) iterations.push_back(RoundJson(round));
  for (const PatchResult& patch : result.patches) patches.push_back(PatchJson(patch));
  Json json = {{"photo", result.photo},
               {"status", Name(result.status)},
               {"scan",
                {{"width", result.width},
                 {"height", result.height},
                 {"orientation", NameOrNull(result.orientation)}}},
               {"pose", PoseJson(result.pose)},
               {"covariance", result.covariance ? MatrixJson(*result.covariance) : Json(nullptr)},
               {"sigma0_px", ToJson(result.sigma0_px)},
               {"footprint", std::move(footprint)},
               {"iterations", std::move(iterations)},
               {"patches", std::move(patches)},
               {"not_visible", NotVisibleJson(result.patches)}};
  WriteFindings(result.findings, &json);
  if (result.approximation) json["approximation"] = StartJson(*result.approximation);
  if (result.alone) json["alone"] = AloneJson(*result.alone);
  if (!result.made_from.empty()) json["made_from"] = result.made_from;
  if (result.target_m) json["target_m"] = *result.target_m;
  if (const auto& sigma = result.projection_sigma)
    json["projection_sigma"] = {{"px", sigma->px}, {"m", sigma->m}};
  if (result.earth_k1) json["earth_k1"] = *result.earth_k1;
  if (const auto& area = result.asked_of_neighbours)
    json["asked_of_neighbours"] = {{"x", {area->min_x, area->max_x}},
                                   {"y", {area->min_y, area->max_y}}};
  if (const auto& estimated = result.principal_distance)
    json["principal_distance_mm"] = {{"value", estimated->value_mm},
                                     {"sigma", estimated->sigma_mm},
                                     {"prior", estimated->prior_mm},
                                     {"prior_sigma", estimated->prior_sigma_mm}};
  if (const auto& ties = result.ties)
    json["ties"] = {
        {"measured", ties->measured}, {"used", ties->used}, {"rms_px", ToJson(ties->rms_px)}};
  return json;
}

Pose ReadPose(const JsonField& field) {
  const auto number = [&](const char* key) { return field.At(key).AsNumber(); };
  Pose pose;
  pose.position_m = {number("x"), number("y"), number("z")};
  pose.opk_rad = {RadFromDeg(number("omega")), RadFromDeg(number("phi")),
                  RadFromDeg(number("kappa"))};
  return pose;
}

StartingPose ReadStart(const JsonField& field) {
  StartingPose start{ReadPose(field)};
  const std::vector<JsonField> sigma = field.At("sigma").Elements();
  if (sigma.size() != 6) field.At("sigma").Fail("must have six numbers");
  for (int i = 0; i < 6; ++i) {
    const double value = sigma[static_cast<std::size_t>(i)].AsNumber();
    start.sigma[i] = i < 3 ? value : RadFromDeg(value);
  }
  return start;
}

LoopRound ReadRound(const JsonField& field) {
  constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  LoopRound round;
  round.searched = field.At("searched").AsInt();
  round.matched = field.At("matched").AsInt();
  round.window_px = field.FindNumber("window_px").value_or(kUnknown);
  round.rms_px = field.FindNumber("rms_px").value_or(kUnknown);
  if (const auto reduction = field.Find("reduction")) {
    round.reduction = reduction->AsInt();
    if (round.reduction < 1) reduction->Fail("must be at least 1");
  }
  return round;
}

// Why a patch was not matched, or is not used: from the codes; without codes from the sentence.
Findings ReadPatchFindings(const JsonField& patch) {
  Findings findings;
  if (const auto codes = patch.Find("reason_codes"))
    for (const JsonField& code : codes->Elements())
      findings.push_back({.reason = ReadReason(code)});
  const auto reason = patch.Find("reason");
  if (findings.empty() && reason && !reason->AsString().empty())
    findings.push_back(Stated(reason->AsString()));
  return findings;
}

PatchResult ReadPatch(const JsonField& field) {
  PatchResult patch;
  patch.id = field.At("id").AsInteger();
  if (const auto source = field.Find("source")) patch.source = source->AsInteger();
  patch.state = FromName(field.At("state"), kPatchStates);
  if (const auto ground = field.Find("ground")) patch.ground_m = ground->AsVector3();
  patch.predicted = field.FindVector2("predicted");
  patch.pixel = field.FindVector2("pixel");
  patch.sigma_px = field.FindVector2("sigma_px");
  patch.residual_px = field.FindVector2("residual_px");
  patch.ncc = field.FindNumber("ncc");
  patch.findings = ReadPatchFindings(field);
  return patch;
}

AloneResult ReadAlone(const JsonField& field) {
  AloneResult alone;
  alone.status = FromName(field.At("status"), kStatuses);
  if (const auto pose = field.Find("pose")) alone.pose = ReadPose(*pose);
  if (const auto covariance = field.Find("covariance"))
    alone.covariance = covariance->AsMatrix(6, 6);
  alone.sigma0_px = field.FindNumber("sigma0_px");
  alone.findings = ReadFindings(field);
  return alone;
}

}  // namespace

void WithdrawPose(ExteriorResult* result) {
  result->pose.reset();
  result->covariance.reset();
  result->projection_sigma.reset();
  result->footprint_m.clear();
}

void WriteExteriorResult(const std::string& directory, const ExteriorResult& result) {
  WriteFileAtomically(ExteriorResultPath(directory, result.photo), TextOf(ExteriorJson(result)));
}

ExteriorResult ReadExteriorResult(const std::string& path) {
  const Json json = ParseJsonFile(path);
  const JsonField root(json, path);
  ExteriorResult result;
  result.photo = ReadPhotoName(root, path, ".exterior.json");
  result.status = FromName(root.At("status"), kStatuses);
  if (const auto scan = root.Find("scan")) {
    result.width = scan->At("width").AsInt();
    result.height = scan->At("height").AsInt();
    if (const auto field = scan->Find("orientation"))
      result.orientation = FromName(*field, kAllScanOrientations);
  }
  if (const auto field = root.Find("pose")) result.pose = ReadPose(*field);
  if (const auto field = root.Find("covariance")) result.covariance = field->AsMatrix(6, 6);
  result.sigma0_px = root.FindNumber("sigma0_px");
  if (const auto footprint = root.Find("footprint"))
    for (const JsonField& corner : footprint->Elements())
      result.footprint_m.push_back(corner.AsVector3());
  for (const JsonField& field : root.At("iterations").Elements())
    result.iterations.push_back(ReadRound(field));
  for (const JsonField& field : root.At("patches").Elements())
    result.patches.push_back(ReadPatch(field));
  if (const auto start = root.Find("approximation")) result.approximation = ReadStart(*start);
  if (const auto alone = root.Find("alone")) result.alone = ReadAlone(*alone);
  result.made_from = root.FindTexts("made_from");
  result.target_m = root.FindNumber("target_m");
  if (const auto sigma = root.Find("projection_sigma"))
    result.projection_sigma =
        ProjectionSigma{sigma->At("px").AsNumber(), sigma->At("m").AsNumber()};
  result.earth_k1 = root.FindNumber("earth_k1");
  if (const auto area = root.Find("asked_of_neighbours")) {
    const Eigen::Vector2d x = area->At("x").AsVector2(), y = area->At("y").AsVector2();
    result.asked_of_neighbours = Bounds{x[0], y[0], x[1], y[1]};
  }
  if (const auto estimated = root.Find("principal_distance_mm"))
    result.principal_distance = EstimatedPrincipalDistance{
        estimated->At("value").AsNumber(), estimated->At("sigma").AsNumber(),
        estimated->At("prior").AsNumber(), estimated->At("prior_sigma").AsNumber()};
  if (const auto ties = root.Find("ties"))
    result.ties = TieCount{ties->At("measured").AsInt(), ties->At("used").AsInt(),
                           ties->FindNumber("rms_px")};
  result.findings = ReadFindings(root);
  return result;
}

}  // namespace orient
