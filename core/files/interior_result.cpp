#include <array>

#include "core/base/atomic_write.h"
#include "core/files/result_fields.h"

namespace orient {
namespace {

constexpr std::array kPolarities = {Polarity::kPositive, Polarity::kNegative};
constexpr std::array kMarkStates = {MarkState::kUsed, MarkState::kRejected, MarkState::kMissing};

Json MarkJson(const MarkResult& mark) {
  Json json = {{"id", mark.id},
               {"state", Name(mark.state)},
               {"pixel", ToJson(mark.pixel)},
               {"sigma_px", ToJson(mark.sigma_px)},
               {"residual_um", ToJson(mark.residual_um)},
               {"score", ToJson(mark.score)}};
  if (mark.expected) json["expected"] = ToJson(mark.expected);
  if (const auto& w = mark.window) json["window"] = {w->col, w->row, w->width, w->height};
  return json;
}

Json EvidenceJson(const std::vector<OrientationEvidence>& evidence) {
  Json list = Json::array();
  for (const OrientationEvidence& said : evidence) {
    Json nats = Json::object();
    for (const auto& [orientation, value] : said.nats) nats[std::string(Name(orientation))] = value;
    list.push_back({{"by", said.by}, {"nats", std::move(nats)}});
  }
  return list;
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
    // Rounded to 0.01 um: no film is stable to that.
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
  const auto names = [](const std::vector<ScanOrientation>& orientations) {
    Json list = Json::array();
    for (const ScanOrientation o : orientations) list.push_back(Name(o));
    return list;
  };
  Json json = {{"photo", result.photo},
               {"status", Name(result.status)},
               {"status_alone", NameOrNull(result.status_alone)},
               {"scan",
                {{"width", result.width},
                 {"height", result.height},
                 {"pixel_size_um", ToJson(result.pixel_size_um)},
                 {"polarity", NameOrNull(result.polarity)},
                 {"orientation", NameOrNull(result.orientation)},
                 {"possible_orientations", names(result.possible_orientations)}}},
               {"photo_from_pixel", TransformJson(result.photo_from_pixel)},
               {"reseau", ReseauJson(result.reseau)},
               {"sigma0_um", ToJson(result.sigma0_um)},
               {"margin", ToJson(result.margin)},
               {"marks", std::move(marks)}};
  if (!result.orientation_nats.empty()) json["scan"]["orientation_nats"] = result.orientation_nats;
  if (!result.orientation_evidence.empty())
    json["scan"]["orientation_evidence"] = EvidenceJson(result.orientation_evidence);
  if (!result.orientations_alone.empty())
    json["scan"]["orientations_alone"] = names(result.orientations_alone);
  WriteFindings(result.findings, &json);
  if (!result.cameras.empty()) json["camera"] = result.cameras;
  if (!result.made_from.empty()) json["made_from"] = result.made_from;
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
  mark.expected = field.FindVector2("expected");
  if (const auto window = field.Find("window")) {
    const std::vector<JsonField> values = window->Elements();
    if (values.size() != 4) window->Fail("must be column, row, width and height");
    mark.window =
        SearchedWindow{values[0].AsInt(), values[1].AsInt(), values[2].AsInt(), values[3].AsInt()};
  }
  return mark;
}

OrientationEvidence ReadEvidence(const JsonField& field) {
  OrientationEvidence said{field.At("by").AsString(), {}};
  for (const ScanOrientation orientation : kAllScanOrientations)
    if (const auto nats = field.At("nats").FindNumber(std::string(Name(orientation))))
      said.nats.emplace_back(orientation, *nats);
  return said;
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
  const auto orientations = [&](const char* key, std::vector<ScanOrientation>* list) {
    if (const auto field = scan.Find(key))
      for (const JsonField& name : field->Elements())
        list->push_back(FromName(name, kAllScanOrientations));
  };
  orientations("possible_orientations", &result->possible_orientations);
  orientations("orientations_alone", &result->orientations_alone);
  if (const auto field = scan.Find("orientation_nats"))
    for (const JsonField& nats : field->Elements())
      result->orientation_nats.push_back(nats.AsNumber());
  if (const auto field = scan.Find("orientation_evidence"))
    for (const JsonField& said : field->Elements())
      result->orientation_evidence.push_back(ReadEvidence(said));
}

}  // namespace

void WriteInteriorResult(const std::string& directory, const InteriorResult& result) {
  WriteFileAtomically(InteriorResultPath(directory, result.photo), TextOf(InteriorJson(result)));
}

InteriorResult ReadInteriorResult(const std::string& path) {
  const Json json = ParseJsonFile(path);
  const JsonField root(json, path);
  InteriorResult result;
  result.photo = ReadPhotoName(root, path, ".interior.json");
  result.status = FromName(root.At("status"), kStatuses);
  if (const auto field = root.Find("status_alone"))
    result.status_alone = FromName(*field, kStatuses);
  ReadScan(root.At("scan"), &result);
  if (const auto field = root.Find("photo_from_pixel")) {
    const Eigen::MatrixXd matrix = field->AsMatrix(2, 3);
    result.photo_from_pixel = Affine2d{matrix.leftCols<2>(), matrix.col(2)};
    if (!result.photo_from_pixel->IsInvertible()) field->Fail("is singular: it is no transform");
  }
  if (const auto field = root.Find("reseau")) result.reseau = ReadReseau(*field);
  result.sigma0_um = root.FindNumber("sigma0_um");
  result.margin = root.FindNumber("margin");
  for (const JsonField& mark : root.At("marks").Elements()) result.marks.push_back(ReadMark(mark));
  if (const auto field = root.Find("camera")) result.cameras = field->AsStrings();
  result.made_from = root.FindTexts("made_from");
  result.findings = ReadFindings(root);
  return result;
}

}  // namespace orient
