#include "tools/report/report_json.h"

#include <filesystem>
#include <nlohmann/json.hpp>

#include "core/base/atomic_write.h"
#include "tools/report/approximation_moves.h"
#include "tools/report/film_section.h"
#include "tools/report/html_text.h"
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

Json Ce90(const std::optional<ProjectionSigma>& sigma) {
  return sigma ? Json(Ce90_m(*sigma)) : Json(nullptr);
}

// Of all photos together; null where no photo says where it started.
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
          {"ground_ce90_m", Ce90(photo.projection)},
          {"projection_sigma", Projection(photo.projection)},
          {"seen_at", ScaleJson(record, camera)},
          {"pose", PoseJson(photo)}};
}

}  // namespace

std::string WriteReportJson(const BlockRecord& block) {
  const BlockVerdict verdict = Judge(block);
  Json json = {{"block", block.title},
               {"crs", block.crs ? Json(block.crs->Name()) : Json(nullptr)},
               {"camera", CameraJson(block.camera)},
               {"ok", verdict.ok},
               {"weak", verdict.weak},
               {"failed", verdict.failed},
               {"ground_ce90_m_median", Ce90(verdict.median_projection)},
               {"ground_ce90_m_worst_photo", Named(block, verdict.worst_on_ground)},
               {"ties_le90_m_median", Or(verdict.median_le90_m)},
               {"projection_sigma_median", Projection(verdict.median_projection)},
               {"projection_sigma_worst_photo", Named(block, verdict.worst_projection)},
               {"least_precise_photo", Named(block, verdict.least_precise)},
               {"patches", {{"matched", verdict.matched}, {"searched", verdict.searched}}},
               {"marks_sigma0_um_median", Or(verdict.median_sigma0_um)},
               {"matches_sigma0_px_median", Or(verdict.median_sigma0_px)},
               {"moved_from_approximations", MovesJson(ApproximationMoves(block, verdict))},
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
