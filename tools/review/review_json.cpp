#include "tools/review/review_json.h"

#include <Eigen/LU>
#include <nlohmann/json.hpp>
#include <set>

namespace orient {
namespace {
using Json = nlohmann::ordered_json;

// What is no UTF-8 becomes U+FFFD.
std::string Text(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

template <typename Vector>
Json Numbers(const Vector& vector) {
  Json numbers = Json::array();
  for (const double number : vector) numbers.push_back(number);
  return numbers;
}

template <typename Vector>
Json Numbers(const std::optional<Vector>& vector) {
  return vector ? Numbers(*vector) : Json();
}

Json Number(const std::optional<double>& number) { return number ? Json(*number) : Json(); }

Json AttributionJson(const Attribution& attribution) {
  return {{"by", attribution.by}, {"when", attribution.when}};
}

Json DecisionsJson(const Measurements& measurements, const std::string& photo) {
  Json decisions = Json::array();
  for (const Decision& one : measurements.decisions)
    if (one.photo == photo)
      decisions.push_back({{"decision", Name(one.kind)},
                           {"value", one.value},
                           {"reason", one.reason},
                           {"said", AttributionJson(one.attribution)}});
  return decisions;
}

// Codes of what keeps the photo from being ok.
Json CodesJson(const PhotoRecord& photo) {
  std::set<std::string> codes;
  const auto add = [&](const Findings& findings) {
    for (const Finding& finding : findings)
      if (finding.at_best != Status::kOk) codes.emplace(Code(finding.reason));
  };
  if (photo.interior) add(photo.interior->findings);
  if (photo.exterior) add(photo.exterior->findings);
  return codes;
}

Json ListedPhoto(const ReviewState& state, const Measurements& measurements, std::size_t i,
                 const std::string& concern, const ScanTiles& scans) {
  const PhotoRecord& photo = state.block.photos[i];
  const PhotoVerdict& verdict = state.verdict.photos[i];
  return {{"name", photo.name},
          {"status", Name(verdict.status)},
          {"concern", concern},
          {"codes", CodesJson(photo)},
          {"decisions", DecisionsJson(measurements, photo.name)},
          {"said",
           measurements.MarksOf(photo.name).size() + measurements.ImagePointsOf(photo.name).size()},
          {"pending", IsPending(state, measurements, photo.name)},
          {"scan", scans.Has(photo.name)}};
}

// Micrometres of the photo system as pixels of the scan.
std::optional<Eigen::Vector2d> PixelsOf(const std::optional<Eigen::Vector2d>& residual_um,
                                        const std::optional<Affine2d>& photo_from_pixel) {
  if (!residual_um || !photo_from_pixel) return std::nullopt;
  return Eigen::Vector2d(photo_from_pixel->A.inverse() * *residual_um * 1e-3);
}

// The scan pixel of a point in the photo system.
Json PixelJson(const InteriorResult& interior, const Eigen::Vector2d& photo_mm) {
  const FilmCorrection* film = interior.reseau ? &interior.reseau->correction : nullptr;
  return Numbers(PixelFromPhoto(*interior.photo_from_pixel, film, photo_mm));
}

Json ExpectedJson(const InteriorResult& interior, const CameraFile& camera) {
  Json expected = Json::array();
  for (const Fiducial& fiducial : camera.fiducials)
    expected.push_back({{"id", fiducial.id}, {"pixel", PixelJson(interior, fiducial.position_mm)}});
  return expected;
}

Json FrameJson(const InteriorResult& interior, const Camera& camera) {
  Json frame = Json::array();
  for (const auto& [x, y] : {std::pair{-0.5, -0.5}, {0.5, -0.5}, {0.5, 0.5}, {-0.5, 0.5}})
    frame.push_back(
        PixelJson(interior, camera.frame_centre_mm +
                                Eigen::Vector2d(x * camera.frame_mm.x(), y * camera.frame_mm.y())));
  return frame;
}

Json InteriorJson(const InteriorResult& interior, const CameraFile* camera) {
  const bool placed = camera != nullptr && interior.photo_from_pixel;
  Json marks = Json::array();
  for (const MarkResult& mark : interior.marks)
    marks.push_back(
        {{"id", mark.id},
         {"state", Name(mark.state)},
         {"pixel", Numbers(mark.pixel)},
         {"residual_um", Numbers(mark.residual_um)},
         {"residual_px", Numbers(PixelsOf(mark.residual_um, interior.photo_from_pixel))}});
  return {{"status", Name(interior.status)},
          {"orientation", interior.orientation ? Json(Name(*interior.orientation)) : Json()},
          {"polarity", interior.polarity ? Json(Name(*interior.polarity)) : Json()},
          {"pixel_size_um", Number(interior.pixel_size_um)},
          {"sigma0_um", Number(interior.sigma0_um)},
          {"cameras", interior.cameras},
          {"marks", marks},
          {"expected", placed ? ExpectedJson(interior, *camera) : Json::array()},
          {"frame", placed ? FrameJson(interior, camera->camera) : Json::array()}};
}

Json ExteriorJson(const ExteriorResult& exterior) {
  Json patches = Json::array();
  for (const PatchResult& patch : exterior.patches)
    if (patch.state != PatchState::kNotVisible)
      patches.push_back({{"id", patch.id},
                         {"state", Name(patch.state)},
                         {"ground", Numbers(patch.ground_m)},
                         {"predicted", Numbers(patch.predicted)},
                         {"pixel", Numbers(patch.pixel)},
                         {"residual_px", Numbers(patch.residual_px)},
                         {"ncc", Number(patch.ncc)},
                         {"reason", JoinedSentences(patch.findings)}});
  return {{"status", Name(exterior.status)},
          {"sigma0_px", Number(exterior.sigma0_px)},
          {"patches", patches}};
}

Json TiesJson(const BlockRecord& block, const std::string& photo) {
  Json ties = Json::array();
  if (!block.adjusted) return ties;
  for (const PointResult& tie : block.adjusted->ties)
    for (const SightingResult& seen : tie.seen)
      if (seen.photo == photo)
        ties.push_back({{"id", tie.id},
                        {"state", seen.state},
                        {"pixel", Numbers(seen.pixel)},
                        {"residual_px", Numbers(seen.residual_px)}});
  return ties;
}

Json MeasurementsJson(const Measurements& measurements, const std::string& photo) {
  Json marks = Json::array(), points = Json::array();
  for (const MarkMeasurement& mark : measurements.MarksOf(photo))
    marks.push_back({{"mark", mark.mark},
                     {"pixel", Numbers(mark.pixel)},
                     {"exact", mark.exact},
                     {"said", AttributionJson(mark.attribution)}});
  for (const ImagePointMeasurement& seen : measurements.ImagePointsOf(photo)) {
    const GroundPoint* point = measurements.Point(seen.point);
    points.push_back({{"point", seen.point},
                      {"pixel", Numbers(seen.pixel)},
                      {"ground", point ? Numbers(point->ground_m) : Json()},
                      {"ground_said", point ? AttributionJson(point->attribution) : Json()},
                      {"said", AttributionJson(seen.attribution)}});
  }
  return {{"marks", marks}, {"points", points}, {"decisions", DecisionsJson(measurements, photo)}};
}

}  // namespace

std::string ListJson(const ReviewState& state, const Measurements& measurements,
                     const std::string& version, const std::string& undo, const ScanTiles& scans) {
  Json photos = Json::array();
  std::set<std::size_t> listed;
  for (const Concern& concern : state.verdict.concerns)
    if (listed.insert(concern.photo).second)
      photos.push_back(ListedPhoto(state, measurements, concern.photo, concern.text, scans));
  for (std::size_t i = 0; i < state.block.photos.size(); ++i)
    if (!listed.contains(i)) photos.push_back(ListedPhoto(state, measurements, i, "", scans));
  return Text({{"title", state.block.title},
               {"version", version},
               {"undo", undo},
               {"unreadable", state.block.unreadable},
               {"photos", photos}});
}

std::string PhotoJson(const ReviewState& state, const Measurements& measurements,
                      const PhotoRecord& photo, const ShownScan& scan, const CameraFile* camera) {
  const auto index = static_cast<std::size_t>(&photo - state.block.photos.data());
  Json json = {{"name", photo.name},
               {"status", Name(state.verdict.photos.at(index).status)},
               {"reasons", state.verdict.photos.at(index).reasons},
               {"why_no_scan", scan.why_not}};
  json["scan"] = scan.size ? Json{{"width", scan.size->width},
                                  {"height", scan.size->height},
                                  {"levels", scan.size->levels}}
                           : Json();
  json["interior"] = photo.interior ? InteriorJson(*photo.interior, camera) : Json();
  json["exterior"] = photo.exterior ? ExteriorJson(*photo.exterior) : Json();
  json["ties"] = TiesJson(state.block, photo.name);
  json["said"] = MeasurementsJson(measurements, photo.name);
  return Text(json);
}

std::string MapJson(const ReviewState& state, const Measurements& measurements,
                    const std::optional<MapGround>& ground) {
  Json photos = Json::array(), points = Json::array();
  for (std::size_t i = 0; i < state.block.photos.size(); ++i) {
    const PhotoRecord& photo = state.block.photos[i];
    const auto& pose = state.verdict.photos[i].pose;
    Json footprint = Json::array();
    if (photo.exterior)
      for (const Eigen::Vector3d& corner : photo.exterior->footprint_m)
        footprint.push_back({corner.x(), corner.y()});
    const auto said_at = measurements.PositionOf(photo.name);
    const bool started = photo.exterior && photo.exterior->approximation;
    if (!pose && footprint.empty() && !said_at && !started) continue;
    photos.push_back(
        {{"name", photo.name},
         {"status", Name(state.verdict.photos[i].status)},
         {"centre", pose ? Numbers(pose->position_m) : Json()},
         {"start", started ? Numbers(photo.exterior->approximation->pose.position_m) : Json()},
         {"said_at", said_at ? Numbers(said_at->ground_m) : Json()},
         {"footprint", footprint}});
  }
  for (const GroundPoint& point : measurements.points)
    points.push_back({{"point", point.name},
                      {"ground", Numbers(point.ground_m)},
                      {"sigma", Numbers(point.sigma_m)},
                      {"role", point.role == PointRole::kCheck ? "check" : "control"}});
  std::set<std::string> measured;
  for (const ImagePointMeasurement& seen : measurements.image_points) measured.insert(seen.point);
  Json json = {{"crs", state.block.crs ? state.block.crs->Name() : ""},
               {"photos", photos},
               {"points", points},
               {"measured_points", measured}};
  json["ground"] = ground ? Json{{"width", ground->size.width},
                                 {"height", ground->size.height},
                                 {"levels", ground->size.levels},
                                 {"x0", ground->x0},
                                 {"y0", ground->y0},
                                 {"step_x", ground->step_x},
                                 {"step_y", ground->step_y}}
                          : Json();
  return Text(json);
}

}  // namespace orient
