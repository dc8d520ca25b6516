#include "tools/report/report_json.h"

#include <filesystem>
#include <nlohmann/json.hpp>

#include "core/base/atomic_write.h"
#include "tools/report/approximation_moves.h"
#include "tools/report/figures/adjustment_figures.h"
#include "tools/report/film_section.h"
#include "tools/report/html_text.h"
#include "tools/report/overlap_map.h"
#include "tools/report/verdict.h"

namespace orient {
namespace {
namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

Json Or(const std::optional<double>& number) { return number ? Json(*number) : Json(nullptr); }

Json Projection(const std::optional<ProjectionSigma>& sigma) {
  if (!sigma) return nullptr;
  return {{"px", sigma->px}, {"m", sigma->m}};
}

Json Named(const BlockRecord& block, const std::optional<size_t>& photo) {
  return photo ? Json(block.photos[*photo].name) : Json(nullptr);
}

Json PoseJson(const PhotoVerdict& photo) {
  if (!photo.pose) return nullptr;
  Json json;
  constexpr const char* kNames[] = {"x_m", "y_m", "z_m", "omega_deg", "phi_deg", "kappa_deg"};
  const Vector6d values = photo.pose->AsVector();
  for (int i = 0; i < 6; ++i) {
    const bool angle = i >= 3;
    json[kNames[i]] = angle ? DegFromRad(NormalizeAngle(values[i])) : values[i];
    if (photo.sigma)
      json[std::string("sigma_") + kNames[i]] =
          angle ? DegFromRad((*photo.sigma)[i]) : (*photo.sigma)[i];
  }
  return json;
}

Json Ce90(const std::optional<GroundAccuracy>& ce90) {
  if (!ce90) return nullptr;
  return {{"median", ce90->median_m}, {"worst", ce90->worst_m}};
}

// Moves of all photos together; null if no photo states where it started.
Json MovesJson(const std::vector<ApproximationMove>& moves) {
  if (moves.empty()) return nullptr;
  const CommonMove common = CommonMoveOf(moves);
  const auto xyz = [](const Eigen::Vector3d& v) { return Json::array({v.x(), v.y(), v.z()}); };
  return {{"photos", common.photos},
          {"mean_m", xyz(common.mean_m)},
          {"rms_about_mean_m", xyz(common.rms_about_mean_m)}};
}

Json ScaleJson(const PhotoRecord& photo, const std::optional<Camera>& camera) {
  const auto seen = camera ? ScaleOf(photo, *camera) : std::nullopt;
  if (!seen) return nullptr;
  return {{"height_m", seen->height_m}, {"scale", seen->scale}, {"gsd_m", seen->gsd_m}};
}

Json CameraJson(const std::optional<Camera>& camera) {
  if (!camera) return nullptr;
  return {{"name", camera->name},
          {"principal_distance_mm", camera->principal_distance_mm},
          {"frame_mm", {camera->frame_mm.x(), camera->frame_mm.y()}}};
}

Json PhotoJson(const PhotoRecord& record, const PhotoVerdict& photo,
               const std::optional<Camera>& camera) {
  return {{"photo", record.name},
          {"status", Name(photo.status)},
          {"reasons", photo.reasons},
          {"marks", {{"used", photo.marks_used}, {"all", photo.marks}}},
          {"marks_sigma0_um", Or(photo.sigma0_um)},
          {"patches",
           {{"matched", photo.matched},
            {"not_found", photo.not_found},
            {"rejected", photo.rejected},
            {"not_visible", photo.not_visible}}},
          {"matches_sigma0_px", Or(photo.sigma0_px)},
          {"ground_ce90_m", photo.ce90 ? Json(photo.ce90->median_m) : Json(nullptr)},
          {"ground_ce90_m_at_worst", photo.ce90 ? Json(photo.ce90->worst_m) : Json(nullptr)},
          {"projection_sigma", Projection(photo.projection)},
          {"seen_at", ScaleJson(record, camera)},
          {"pose", PoseJson(photo)}};
}

Json OverlapJson(const std::optional<OverlapCounts>& counts) {
  if (!counts) return nullptr;
  Json shares = Json::array();
  for (int photos = 1; photos <= OverlapCounts::kMostCounted; ++photos)
    shares.push_back({{"photos", photos},
                      {"or_more", photos == OverlapCounts::kMostCounted},
                      {"share_of_ground", counts->Share(photos)}});
  return {{"cell_m", counts->Cell_m()}, {"seen_by", shares}};
}

Json OrthoJson(const std::optional<OrthoFolder>& ortho) {
  if (!ortho) return nullptr;
  Json photos = Json::array(), mosaic = nullptr;
  for (const OrthoFigures& photo : ortho->photos)
    photos.push_back({{"photo", photo.photo},
                      {"file", photo.file},
                      {"dem", photo.dem},
                      {"gsd_m", Or(photo.gsd_m)},
                      {"width", photo.width},
                      {"height", photo.height},
                      {"ce90_m", Ce90(photo.ce90)},
                      {"frame_with_heights", Or(photo.with_heights)}});
  if (ortho->mosaic)
    mosaic = {{"file", ortho->mosaic->file},
              {"width", ortho->mosaic->width},
              {"height", ortho->mosaic->height},
              {"ce90_m", Ce90(ortho->mosaic->ce90)},
              {"of_other_orthophotos", ortho->mosaic->changes.others},
              {"lacks", ortho->mosaic->changes.lacking}};
  const auto file = [](const std::string& name) {
    return name.empty() ? Json(nullptr) : Json(name);
  };
  return {{"ce90_m", Ce90(AccuracyOfAll(ortho->photos))},
          {"mosaic", mosaic},
          {"seamlines", file(ortho->seamlines)},
          {"tones", file(ortho->tones)},
          {"photos", photos},
          {"of_other_poses", ortho->of_other_poses},
          {"without_pose", ortho->without_pose},
          {"unreadable", ortho->unreadable}};
}

Json MeanJson(const std::optional<MeanAndSpread>& values) {
  if (!values) return nullptr;
  return {{"mean", values->mean}, {"spread", Or(values->spread)}};
}

Json FilmJson(const std::vector<FilmRoll>& rolls) {
  Json json = Json::array();
  for (const FilmRoll& roll : rolls)
    json.push_back({{"cameras", roll.cameras},
                    {"photos", roll.photos},
                    {"first", roll.first},
                    {"last", roll.last},
                    {"marks", {{"used", roll.marks_used}, {"all", roll.marks}}},
                    {"pixel_along_columns_um", MeanJson(roll.column_um)},
                    {"pixel_along_rows_um", MeanJson(roll.row_um)},
                    {"columns_over_rows_less_one_ppm", MeanJson(roll.difference_ppm)},
                    {"axes_off_square_urad", MeanJson(roll.shear_urad)},
                    {"marks_sigma0_um", MeanJson(roll.sigma0_um)}});
  return json;
}

Json Xyz(const std::optional<Eigen::Vector3d>& v) {
  return v ? Json::array({v->x(), v->y(), v->z()}) : Json(nullptr);
}

Json ResidualsJson(const GroundResiduals& residuals) {
  if (residuals.Count() == 0) return nullptr;
  return {{"points", residuals.Count()},
          {"rmse_m", Xyz(residuals.Rms_m())},
          {"ce90_m", residuals.Ce90_m()},
          {"le90_m", residuals.Le90_m()}};
}

Json SightingsJson(const SightingsByPhoto& photos) {
  Json json = Json::array();
  for (const auto& [name, photo] : photos)
    json.push_back({{"photo", name},
                    {"ties", {{"used", photo.ties_used}, {"all", photo.ties}}},
                    {"control", {{"used", photo.control_used}, {"all", photo.control}}},
                    {"rms_px", Or(photo.RmsPx())},
                    {"mean_redundancy", Or(photo.MeanRedundancy())},
                    {"largest_w", photo.Used() > 0 ? Json(photo.largest_w) : Json(nullptr)}});
  return json;
}

Json GroupsJson(const AdjustmentResult& adjusted) {
  Json json = Json::array();
  for (const ComponentResult& group : adjusted.components)
    json.push_back({{"group", group.group},
                    {"sigma_px", Or(ImageSigmaPx(group))},
                    {"sigma_over_stated", Or(SigmaOverStated(group))},
                    {"degrees_of_freedom", Or(group.redundancy)},
                    {"estimated", group.estimated}});
  return json;
}

Json PartsJson(const AdjustmentResult& adjusted) {
  Json json = Json::array();
  for (const PartResult& part : adjusted.parts)
    json.push_back({{"photos", part.photos},
                    {"control", part.control_points},
                    {"message", part.finding ? Sentence(*part.finding) : ""}});
  return json;
}

Json CalibrationJson(const AdjustmentResult& adjusted) {
  Json json = Json::array();
  for (const CalibrationResult& parameter : adjusted.calibration)
    json.push_back({{"parameter", parameter.parameter},
                    {"correction", Or(parameter.correction)},
                    {"sigma", Or(parameter.sigma)},
                    {"t", Or(parameter.t)},
                    {"state", parameter.state}});
  return json;
}

Json GnssJson(const AdjustmentResult& adjusted) {
  if (adjusted.gnss.empty()) return nullptr;
  Json strips = Json::array();
  for (const GnssStripResult& strip : adjusted.gnss_strips)
    strips.push_back({{"strip", strip.strip},
                      {"shift_m", Xyz(strip.shift_m)},
                      {"shift_sigma_m", Xyz(strip.shift_sigma_m)},
                      {"drift_m", Xyz(strip.drift_m)},
                      {"drift_sigma_m", Xyz(strip.drift_sigma_m)}});
  return {{"positions", adjusted.gnss.size()},
          {"used", ResidualsJson(ResidualsOfGnss(adjusted))},
          {"strips", strips}};
}

Json AdjustmentJson(const AdjustmentResult& adjusted) {
  const SightingsByPhoto photos = SightingsOf(adjusted);
  const WorstPhotos worst = WorstOf(photos);
  const CheckSightings checks = SightingsOfChecks(adjusted);
  return {{"converged", adjusted.converged},
          {"sigma0", Or(adjusted.sigma0)},
          {"degrees_of_freedom", Or(adjusted.redundancy)},
          {"ties",
           {{"points", adjusted.ties.size()},
            {"in_three_photos_or_more", TiesInThreePhotosOrMore(adjusted)}}},
          {"groups", GroupsJson(adjusted)},
          {"control",
           {{"patches", adjusted.control.size()},
            {"on_the_ground", ResidualsJson(ResidualsOfControl(adjusted))}}},
          {"checks",
           {{"patches", adjusted.checks.size()},
            {"sightings", checks.count},
            {"rms_px", Or(adjusted.CheckRmsPx())},
            {"median_px", Or(checks.median_px)},
            {"on_the_ground", ResidualsJson(ResidualsOfChecks(adjusted))}}},
          {"photo_of_largest_w", worst.by_w},
          {"photo_of_largest_rms", worst.by_rms},
          {"photos", SightingsJson(photos)},
          {"gnss", GnssJson(adjusted)},
          {"parts", PartsJson(adjusted)},
          {"calibration", CalibrationJson(adjusted)}};
}

}  // namespace

std::string WriteReportJson(const BlockRecord& block, const BlockVerdict& verdict) {
  Json json = {{"block", block.title},
               {"crs", block.crs ? Json(block.crs->Name()) : Json(nullptr)},
               {"camera", CameraJson(block.camera)},
               {"ok", verdict.ok},
               {"weak", verdict.weak},
               {"failed", verdict.failed},
               {"ground_ce90_m_median", Or(verdict.median_ce90_m)},
               {"ground_ce90_m_worst_photo", Named(block, verdict.worst_ce90)},
               {"ties_le90_m_median", Or(verdict.median_le90_m)},
               {"projection_sigma_median", Projection(verdict.median_projection)},
               {"projection_sigma_worst_photo", Named(block, verdict.worst_projection)},
               {"least_precise_photo", Named(block, verdict.least_precise)},
               {"patches", {{"matched", verdict.matched}, {"searched", verdict.searched}}},
               {"marks_sigma0_um_median", Or(verdict.median_sigma0_um)},
               {"matches_sigma0_px_median", Or(verdict.median_sigma0_px)},
               {"moved_from_approximations", MovesJson(ApproximationMoves(block, verdict))},
               {"overlap", OverlapJson(CountOverlap(block, verdict))},
               {"orthophotos", OrthoJson(block.ortho)},
               {"adjustment", block.adjusted ? AdjustmentJson(*block.adjusted) : Json(nullptr)},
               {"film", FilmJson(FilmRollsOf(block))},
               {"notes", block.notes},
               {"unreadable", block.unreadable},
               {"look_at_first", Json::array()},
               {"photos", Json::array()},
               {"runs", Json::object()}};
  for (const Concern& concern : verdict.concerns)
    json["look_at_first"].push_back(
        {{"photo", block.photos[concern.photo].name}, {"text", concern.text}});
  for (size_t i = 0; i < block.photos.size(); ++i)
    json["photos"].push_back(PhotoJson(block.photos[i], verdict.photos[i], block.camera));
  for (const auto& [stage, run] : block.runs) json["runs"][stage] = JsonOf(run);
  const std::string path = (fs::path(block.directory) / "report.json").string();
  // Names of files are what they are; JSON is UTF-8.
  WriteFileAtomically(path, json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
  return path;
}

}  // namespace orient
