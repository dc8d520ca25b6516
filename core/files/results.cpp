#include "core/files/results.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>
#include <stdexcept>

#include "core/error.h"
#include "core/files/atomic_write.h"
#include "core/files/json_fields.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

constexpr const char* kInteriorSuffix = ".interior.json";

template <typename Enum, size_t n>
Enum FromName(const JsonField& field, const std::array<Enum, n>& values) {
  const std::string text = field.AsString();
  std::string known;
  for (const Enum value : values) {
    if (Name(value) == text) return value;
    known += (known.empty() ? "" : ", ") + std::string(Name(value));
  }
  field.Fail("is \"" + text + "\"; it must be one of " + known);
}

constexpr std::array kStatuses = {Status::kOk, Status::kWeak, Status::kFailed};
constexpr std::array kPolarities = {Polarity::kPositive, Polarity::kNegative};
constexpr std::array kMarkStates = {MarkState::kUsed, MarkState::kRejected, MarkState::kMissing};
constexpr std::array kPatchStates = {PatchState::kMatched, PatchState::kNotFound,
                                     PatchState::kRejected, PatchState::kNotVisible};

// A result with a NaN in a place that must hold a number is a programming error upstream: it would
// be read back as something else.
void RequireFinite(bool finite, const std::string& photo, const std::string& field) {
  if (!finite) throw std::invalid_argument("result of " + photo + ": " + field + " is not finite");
}

template <typename Enum>
Json NameOrNull(const std::optional<Enum>& value) {
  return value ? Json(Name(*value)) : Json(nullptr);
}

// ---- interior ----

Json MarkJson(const MarkResult& mark) {
  return {{"id", mark.id},
          {"state", Name(mark.state)},
          {"pixel", ToJson(mark.pixel)},
          {"sigma_px", ToJson(mark.sigma_px)},
          {"residual_um", ToJson(mark.residual_um)},
          {"score", ToJson(mark.score)}};
}

Json TransformJson(const std::optional<Affine2d>& photo_from_pixel) {
  if (!photo_from_pixel) return nullptr;
  return MatrixJson((Eigen::MatrixXd(2, 3) << photo_from_pixel->A, photo_from_pixel->t).finished());
}

Json Vector2Json(const Eigen::Vector2d& v) { return Json::array({v.x(), v.y()}); }

Json ReseauJson(const std::optional<ReseauResult>& reseau) {
  if (!reseau) return nullptr;
  const FilmCorrection& grid = reseau->correction;
  Json corrections = Json::array();
  for (const Eigen::Vector2d& mm : grid.correction_mm) {
    // A hundredth of a micrometre is more than any film holds.
    const Eigen::Vector2d um = (1e5 * mm).array().round() / 100;
    corrections.push_back(Vector2Json(um));
  }
  return {{"origin_px", Vector2Json(grid.origin_px)},
          {"step_px", Vector2Json(grid.step_px)},
          {"columns", grid.columns},
          {"rows", grid.rows},
          {"correction_um", std::move(corrections)},
          {"crosses", reseau->crosses},
          {"noise_um", ToJson(std::optional(reseau->noise_um))},
          {"left_out_rms_um", ToJson(std::optional(reseau->left_out_rms_um))}};
}

Json InteriorJson(const InteriorResult& result) {
  if (result.photo_from_pixel)
    RequireFinite(result.photo_from_pixel->A.allFinite() && result.photo_from_pixel->t.allFinite(),
                  result.photo, "photo_from_pixel");
  Json marks = Json::array();
  for (const MarkResult& mark : result.marks) marks.push_back(MarkJson(mark));
  Json possible = Json::array();
  for (const ScanOrientation o : result.possible_orientations) possible.push_back(Name(o));
  Json json = {{"photo", result.photo},
               {"status", Name(result.status)},
               {"status_alone", NameOrNull(result.status_alone)},
               {"scan",
                {{"width", result.width},
                 {"height", result.height},
                 {"pixel_size_um", ToJson(result.pixel_size_um)},
                 {"polarity", NameOrNull(result.polarity)},
                 {"orientation", NameOrNull(result.orientation)},
                 {"possible_orientations", std::move(possible)}}},
               {"photo_from_pixel", TransformJson(result.photo_from_pixel)},
               {"reseau", ReseauJson(result.reseau)},
               {"sigma0_um", ToJson(result.sigma0_um)},
               {"margin", ToJson(result.margin)},
               {"marks", std::move(marks)},
               {"messages", result.messages}};
  if (!result.cameras.empty()) json["camera"] = result.cameras;
  if (const auto& from = result.made_from)
    json["made_from"] = {
        {"camera", from->camera}, {"options", from->options}, {"scan", from->scan}};
  return json;
}

MarkResult ReadMark(const JsonField& field) {
  MarkResult mark;
  mark.id = field.At("id").AsString();
  mark.state = FromName(field.At("state"), kMarkStates);
  mark.pixel = field.FindVector2("pixel");
  mark.sigma_px = field.FindVector2("sigma_px");
  mark.residual_um = field.FindVector2("residual_um");
  mark.score = field.FindNumber("score");
  return mark;
}

ReseauResult ReadReseau(const JsonField& field) {
  ReseauResult reseau;
  FilmCorrection& grid = reseau.correction;
  grid.origin_px = field.At("origin_px").AsVector2();
  grid.step_px = field.At("step_px").AsVector2();
  grid.columns = field.At("columns").AsInt();
  grid.rows = field.At("rows").AsInt();
  for (const JsonField& um : field.At("correction_um").Elements())
    grid.correction_mm.push_back(1e-3 * um.AsVector2());
  if (!(grid.step_px.minCoeff() > 0)) field.At("step_px").Fail("must be positive");
  if (grid.columns < 2 || grid.rows < 2 ||
      std::ssize(grid.correction_mm) != std::int64_t{grid.columns} * grid.rows)
    field.At("correction_um").Fail("does not hold columns x rows values, two each way at least");
  reseau.crosses = field.At("crosses").AsInt();
  reseau.noise_um = field.FindNumber("noise_um").value_or(0);
  reseau.left_out_rms_um = field.FindNumber("left_out_rms_um").value_or(0);
  return reseau;
}

void ReadScan(const JsonField& scan, InteriorResult* result) {
  result->width = scan.At("width").AsInt();
  result->height = scan.At("height").AsInt();
  result->pixel_size_um = scan.FindNumber("pixel_size_um");
  if (const auto field = scan.Find("polarity")) result->polarity = FromName(*field, kPolarities);
  if (const auto field = scan.Find("orientation"))
    result->orientation = FromName(*field, kAllScanOrientations);
  if (const auto field = scan.Find("possible_orientations"))
    for (const JsonField& name : field->Elements())
      result->possible_orientations.push_back(FromName(name, kAllScanOrientations));
}

// ---- exterior ----

Json PoseJson(const std::optional<Pose>& pose) {
  if (!pose) return nullptr;
  const auto degrees = [&](int i) { return DegFromRad(NormalizeAngle(pose->opk_rad[i])); };
  return {{"x", pose->position_m.x()}, {"y", pose->position_m.y()}, {"z", pose->position_m.z()},
          {"omega", degrees(0)},       {"phi", degrees(1)},         {"kappa", degrees(2)}};
}

Json VectorJson(const Eigen::Vector3d& v) { return Json::array({v.x(), v.y(), v.z()}); }

Json RoundJson(const LoopRound& round) {
  return {{"searched", round.searched},
          {"matched", round.matched},
          {"window_px", ToJson(std::optional(round.window_px))},
          {"rms_px", ToJson(std::optional(round.rms_px))}};
}

Json PatchJson(const PatchResult& patch) {
  return {{"id", patch.id},
          {"state", Name(patch.state)},
          {"ground", patch.ground_m ? VectorJson(*patch.ground_m) : Json(nullptr)},
          {"predicted", ToJson(patch.predicted)},
          {"pixel", ToJson(patch.pixel)},
          {"sigma_px", ToJson(patch.sigma_px)},
          {"residual_px", ToJson(patch.residual_px)},
          {"ncc", ToJson(patch.ncc)},
          {"reason", patch.reason}};
}

// How many patches were not sought, for each reason.
Json NotVisibleJson(const std::vector<PatchResult>& patches) {
  std::map<std::string, int> counts;
  for (const PatchResult& patch : patches)
    if (patch.state == PatchState::kNotVisible) ++counts[patch.reason];
  return counts;
}

Json AloneJson(const AloneResult& alone) {
  return {{"status", Name(alone.status)},
          {"pose", PoseJson(alone.pose)},
          {"covariance", alone.covariance ? MatrixJson(*alone.covariance) : Json(nullptr)},
          {"sigma0_px", ToJson(alone.sigma0_px)},
          {"messages", alone.messages}};
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
               {"not_visible", NotVisibleJson(result.patches)},
               {"messages", result.messages}};
  if (result.alone) json["alone"] = AloneJson(*result.alone);
  if (const auto& freed = result.principal_distance)
    json["principal_distance_mm"] = {{"value", freed->value_mm},
                                     {"sigma", freed->sigma_mm},
                                     {"prior", freed->prior_mm},
                                     {"prior_sigma", freed->prior_sigma_mm}};
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

LoopRound ReadRound(const JsonField& field) {
  constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  LoopRound round;
  round.searched = field.At("searched").AsInt();
  round.matched = field.At("matched").AsInt();
  round.window_px = field.FindNumber("window_px").value_or(kUnknown);
  round.rms_px = field.FindNumber("rms_px").value_or(kUnknown);
  return round;
}

PatchResult ReadPatch(const JsonField& field) {
  PatchResult patch;
  patch.id = field.At("id").AsInteger();
  patch.state = FromName(field.At("state"), kPatchStates);
  if (const auto ground = field.Find("ground")) patch.ground_m = ground->AsVector3();
  patch.predicted = field.FindVector2("predicted");
  patch.pixel = field.FindVector2("pixel");
  patch.sigma_px = field.FindVector2("sigma_px");
  patch.residual_px = field.FindVector2("residual_px");
  patch.ncc = field.FindNumber("ncc");
  if (const auto reason = field.Find("reason")) patch.reason = reason->AsString();
  return patch;
}

AloneResult ReadAlone(const JsonField& field) {
  AloneResult alone;
  alone.status = FromName(field.At("status"), kStatuses);
  if (const auto pose = field.Find("pose")) alone.pose = ReadPose(*pose);
  if (const auto covariance = field.Find("covariance"))
    alone.covariance = covariance->AsMatrix(6, 6);
  alone.sigma0_px = field.FindNumber("sigma0_px");
  alone.messages = field.At("messages").AsStrings();
  return alone;
}

std::string ResultPath(const std::string& directory, const std::string& photo, const char* suffix) {
  return (std::filesystem::path(directory) / (photo + suffix)).string();
}

std::string Text(const Json& json) { return json.dump(2) + "\n"; }

}  // namespace

std::string_view Name(Status status) {
  switch (status) {
    case Status::kOk:
      return "ok";
    case Status::kWeak:
      return "weak";
    case Status::kFailed:
      return "failed";
  }
  throw std::invalid_argument("Name: not a Status");
}

std::string_view Name(Polarity polarity) {
  switch (polarity) {
    case Polarity::kPositive:
      return "positive";
    case Polarity::kNegative:
      return "negative";
  }
  throw std::invalid_argument("Name: not a Polarity");
}

std::string_view Name(MarkState state) {
  switch (state) {
    case MarkState::kUsed:
      return "used";
    case MarkState::kRejected:
      return "rejected";
    case MarkState::kMissing:
      return "missing";
  }
  throw std::invalid_argument("Name: not a MarkState");
}

std::string_view Name(PatchState state) {
  switch (state) {
    case PatchState::kMatched:
      return "matched";
    case PatchState::kNotFound:
      return "not_found";
    case PatchState::kRejected:
      return "rejected";
    case PatchState::kNotVisible:
      return "not_visible";
  }
  throw std::invalid_argument("Name: not a PatchState");
}

std::vector<std::string> InteriorResultPaths(const std::string& directory) {
  std::vector<std::string> paths;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(directory, error))
    if (entry.path().string().ends_with(kInteriorSuffix)) paths.push_back(entry.path().string());
  if (error)
    throw InputError(directory + ": cannot be listed (" + error.message() +
                     "); name the folder that 'orient interior' wrote");
  std::sort(paths.begin(), paths.end());
  return paths;
}

std::string InteriorResultPath(const std::string& directory, const std::string& photo) {
  return ResultPath(directory, photo, kInteriorSuffix);
}

std::string ExteriorResultPath(const std::string& directory, const std::string& photo) {
  return ResultPath(directory, photo, ".exterior.json");
}

void WriteInteriorResult(const std::string& directory, const InteriorResult& result) {
  WriteFileAtomically(InteriorResultPath(directory, result.photo), Text(InteriorJson(result)));
}

void WriteExteriorResult(const std::string& directory, const ExteriorResult& result) {
  WriteFileAtomically(ExteriorResultPath(directory, result.photo), Text(ExteriorJson(result)));
}

InteriorResult ReadInteriorResult(const std::string& path) {
  const Json json = ParseJsonFile(path);
  const JsonField root(json, path);
  InteriorResult result;
  result.photo = root.At("photo").AsString();
  result.status = FromName(root.At("status"), kStatuses);
  if (const auto field = root.Find("status_alone"))
    result.status_alone = FromName(*field, kStatuses);
  ReadScan(root.At("scan"), &result);
  if (const auto field = root.Find("photo_from_pixel")) {
    const Eigen::MatrixXd matrix = field->AsMatrix(2, 3);
    result.photo_from_pixel = Affine2d{matrix.leftCols<2>(), matrix.col(2)};
  }
  if (const auto field = root.Find("reseau")) result.reseau = ReadReseau(*field);
  result.sigma0_um = root.FindNumber("sigma0_um");
  result.margin = root.FindNumber("margin");
  for (const JsonField& mark : root.At("marks").Elements()) result.marks.push_back(ReadMark(mark));
  if (const auto field = root.Find("camera")) result.cameras = field->AsStrings();
  if (const auto field = root.Find("made_from"))
    result.made_from = MadeFrom{field->At("camera").AsString(), field->At("options").AsString(),
                                field->At("scan").AsString()};
  result.messages = root.At("messages").AsStrings();
  return result;
}

ExteriorResult ReadExteriorResult(const std::string& path) {
  const Json json = ParseJsonFile(path);
  const JsonField root(json, path);
  ExteriorResult result;
  result.photo = root.At("photo").AsString();
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
  if (const auto alone = root.Find("alone")) result.alone = ReadAlone(*alone);
  if (const auto freed = root.Find("principal_distance_mm"))
    result.principal_distance =
        FreedPrincipalDistance{freed->At("value").AsNumber(), freed->At("sigma").AsNumber(),
                               freed->At("prior").AsNumber(), freed->At("prior_sigma").AsNumber()};
  if (const auto ties = root.Find("ties"))
    result.ties = TieCount{ties->At("measured").AsInt(), ties->At("used").AsInt(),
                           ties->FindNumber("rms_px")};
  result.messages = root.At("messages").AsStrings();
  return result;
}

}  // namespace orient
