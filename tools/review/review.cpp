#include "tools/review/review.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "block/inputs/measurement_inputs.h"
#include "core/base/atomic_write.h"
#include "core/base/error.h"
#include "core/base/number_text.h"
#include "core/files/orientation_table.h"
#include "tools/review/page_entries.h"

namespace orient {
namespace {
namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr const char* kViewer = "/usr/share/javascript/leaflet";
constexpr const char* kOrtho = "ortho";

Reply Answer(int status, const Json& json) {
  return {status, "application/json",
          std::make_shared<const std::string>(
              json.dump(-1, ' ', false, Json::error_handler_t::replace))};
}

Reply Error(int status, const std::string& message) { return Answer(status, {{"error", message}}); }

Reply NotThere() { return Error(404, "there is no such page"); }

Reply JsonText(std::string text) {
  return {200, "application/json", std::make_shared<const std::string>(std::move(text))};
}

// Errors in a file or a statement are reported to the page; the server goes on.
template <typename Action>
Reply Answered(const Action& action) {
  try {
    return action();
  } catch (const InputError& error) {
    return Error(422, error.what());
  } catch (const UsageError& error) {
    return Error(422, error.what());
  } catch (const std::exception& error) {
    return Error(500, error.what());
  }
}

std::map<std::string, std::string> ByName(const std::vector<std::string>& paths) {
  std::map<std::string, std::string> scans;
  for (const std::string& path : paths)
    if (const auto [at, added] = scans.emplace(PhotoName(path), path); !added && at->second != path)
      throw UsageError(fmt::format("{} and {} have one name; name one of them", at->second, path));
  return scans;
}

std::string Today() {
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  gmtime_r(&now, &utc);
  return fmt::format("{:04}-{:02}-{:02}T{:02}:{:02}:{:02}Z", utc.tm_year + 1900, utc.tm_mon + 1,
                     utc.tm_mday, utc.tm_hour, utc.tm_min, utc.tm_sec);
}

std::string TextIn(const std::map<std::string, std::string>& query, const char* key) {
  const auto found = query.find(key);
  return found == query.end() ? "" : found->second;
}

std::string TypeOf(const std::string& file) {
  if (file.ends_with(".html")) return "text/html; charset=utf-8";
  if (file.ends_with(".css")) return "text/css; charset=utf-8";
  if (file.ends_with(".js")) return "text/javascript; charset=utf-8";
  return file.ends_with(".svg") ? "image/svg+xml" : "image/png";
}

// Footprints and centres with a margin: heights are wanted there.
Bounds WantedGround(const BlockRecord& block) {
  Bounds bounds = Bounds::OfNothing();
  for (const PhotoRecord& photo : block.photos) {
    if (!photo.exterior) continue;
    for (const Eigen::Vector3d& corner : photo.exterior->footprint_m)
      bounds.Include(corner.x(), corner.y());
    if (photo.exterior->pose)
      bounds.Include(photo.exterior->pose->position_m.x(), photo.exterior->pose->position_m.y());
  }
  const double margin = std::max(bounds.max_x - bounds.min_x, bounds.max_y - bounds.min_y);
  return {bounds.min_x - margin, bounds.min_y - margin, bounds.max_x + margin,
          bounds.max_y + margin};
}

}  // namespace

Review::Review(ReviewOptions options)
    : options_(std::move(options)),
      lock_(options_.directory, ".orient-review.lock"),
      states_(options_.directory),
      folder_(options_.measurements),
      scans_(ByName(options_.scans)),
      ortho_({{kOrtho, options_.ortho}}),
      run_again_(options_.run_again) {
  states_.Now();
  ReadViewer();
  if (!options_.ortho.empty()) ReadOrtho();
  if (!options_.camera.empty()) camera_ = ReadCameraFile(options_.camera);
}

void Review::ReadViewer() {
  const auto add = [&](const std::string& name, std::string_view contents, bool keep) {
    files_[name] = {200, TypeOf(name), std::make_shared<const std::string>(contents), keep};
  };
  for (const EmbeddedFile& file : ReviewFiles()) add(std::string(file.name), file.contents, false);
  for (const char* name :
       {"leaflet.js", "leaflet.css", "images/layers.png", "images/layers-2x.png"}) {
    const fs::path path = fs::path(kViewer) / name;
    if (!fs::exists(path))
      throw InputError(path.string() +
                       " is not there; install the viewer: apt-get install libjs-leaflet");
    add(name, ReadFile(path.string()), true);
  }
}

void Review::ReadOrtho() {
  const Raster raster = Raster::Open(options_.ortho);
  const auto g = raster.GeoTransform();
  if (!g || (*g)[2] != 0 || (*g)[4] != 0 || !((*g)[1] > 0 && (*g)[5] < 0))
    throw InputError(options_.ortho +
                     ": has no georeference with north up; make one with gdalwarp");
  const auto& crs = states_.Now()->block.crs;
  if (crs && !raster.CrsWkt().empty() && !SameHorizontalCrs(raster.CrsWkt(), crs->Wkt()))
    throw InputError(fmt::format("{}: is not in the block's CRS, {}; make one with gdalwarp",
                                 options_.ortho, crs->Name()));
  ground_ = {ortho_.Size(kOrtho).value(), (*g)[0], (*g)[3], (*g)[1], -(*g)[5]};
}

Reply Review::Get(const WebPath& path, const std::map<std::string, std::string>& query) {
  return Answered([&]() -> Reply {
    const std::string joined = fmt::format("{}", fmt::join(path, "/"));
    const auto file = files_.find(joined.empty() ? "index.html" : joined);
    if (file != files_.end()) return file->second;
    if (path.size() == 5 && path[0] == "tile") return GetTile(&scans_, path[1], path);
    if (path.size() == 5 && path[0] == "ground" && ground_) return GetTile(&ortho_, kOrtho, path);
    return path.size() >= 2 && path[0] == "api" ? GetData(path, query) : NotThere();
  });
}

Reply Review::GetData(const WebPath& path, const std::map<std::string, std::string>& query) {
  if (path.size() == 3 && path[1] == "photo") return GetPhoto(path[2]);
  if (path.size() != 2) return NotThere();
  if (path[1] == "height") return GetHeight(query);
  if (path[1] == "seen") return GetSeen(query);
  if (path[1] == "progress") return GetProgress();
  const auto state = states_.Now();
  const auto [measurements, version] = folder_.Read();
  if (path[1] == "list")
    return JsonText(ListJson(*state, measurements, version, folder_.LatestAbout(), scans_));
  if (path[1] == "map") return JsonText(MapJson(*state, measurements, ground_));
  return NotThere();
}

Reply Review::GetPhoto(const std::string& name) {
  const auto state = states_.Now();
  const PhotoRecord* photo = state->Photo(name);
  if (photo == nullptr) return Error(404, "there is no such photo");
  ShownScan scan;
  try {
    scan.size = scans_.Size(name);
    if (!scan.size)
      scan.why_not = "its scan was not named; name it after OUT, or in the block file";
  } catch (const InputError& error) {
    scan.why_not = error.what();
  }
  return JsonText(
      PhotoJson(*state, folder_.Read().first, *photo, scan, camera_ ? &*camera_ : nullptr));
}

// What a person says, otherwise what the interior orientation found, otherwise the run's options.
ScanKnowledge Review::KnownOf(const PhotoRecord& photo) const {
  const Measurements measurements = folder_.Read().first;
  ScanKnowledge known{measurements.PixelSizeOf_um(photo.name),
                      measurements.PolarityOf(photo.name),
                      measurements.OrientationOf(photo.name),
                      {}};
  const bool nothing_said = !known.pixel_size_um && !known.polarity && !known.orientation;
  if (const auto& found = photo.interior) {
    if (nothing_said) known.photo_from_pixel = found->photo_from_pixel;
    if (!known.pixel_size_um) known.pixel_size_um = found->pixel_size_um;
    if (!known.polarity) known.polarity = found->polarity;
    if (!known.orientation) known.orientation = found->orientation;
  }
  const ScanKnowledge& run = options_.scan;
  if (!known.pixel_size_um) known.pixel_size_um = run.pixel_size_um;
  if (!known.polarity) known.polarity = run.polarity;
  if (!known.orientation) known.orientation = run.orientation;
  return known;
}

// The mark under a click.
Reply Review::GetSeen(const std::map<std::string, std::string>& query) {
  const auto col = NumberIn<double>(TextIn(query, "col")),
             row = NumberIn<double>(TextIn(query, "row"));
  if (!col || !row) return Error(400, "col and row must be numbers");
  const auto state = states_.Now();
  const PhotoRecord* photo = state->Photo(TextIn(query, "photo"));
  const auto path = photo == nullptr ? std::nullopt : scans_.PathOf(photo->name);
  if (!path) return Error(404, "there is no such photo, or its scan was not named");
  const Raster scan = Raster::OpenScan(*path);
  if (!(*col >= 0 && *col <= scan.Width() && *row >= 0 && *row <= scan.Height()))
    return Error(400, "col and row must lie in the scan");
  const auto seen =
      camera_ ? SeeMark(scan, *camera_, KnownOf(*photo), TextIn(query, "mark"), {*col, *row})
              : std::nullopt;
  if (!seen) return Answer(200, {{"pixel", nullptr}});
  return Answer(
      200, {{"pixel", {seen->pixel.x(), seen->pixel.y()}}, {"correlation", seen->correlation}});
}

Reply Review::GetHeight(const std::map<std::string, std::string>& query) {
  const auto x = NumberIn<double>(TextIn(query, "x")), y = NumberIn<double>(TextIn(query, "y"));
  if (!x || !y) return Error(400, "x and y must be numbers");
  const auto state = states_.Now();
  if (options_.dem.empty() || !state->block.crs) return Answer(200, {{"z", nullptr}});
  const std::lock_guard lock(surface_mutex_);
  if (!surface_)
    surface_ = GroundSurface::FromFile(options_.dem, *state->block.crs, WantedGround(state->block));
  const auto height = surface_->HeightAt(*x, *y);
  return Answer(200, {{"z", height ? Json(*height) : Json()}});
}

Reply Review::GetProgress() const {
  const RunProgress now = run_again_.Progress();
  return Answer(200, {{"offered", options_.run_again != nullptr},
                      {"running", now.running},
                      {"runs", now.runs},
                      {"task", now.task},
                      {"done", now.done},
                      {"total", now.total},
                      {"error", now.error}});
}

Reply Review::GetTile(ScanTiles* tiles, const std::string& scan, const WebPath& place) {
  const auto level = NumberIn<int>(place[2]), col = NumberIn<int>(place[3]),
             row = NumberIn<int>(place[4]);
  if (!level || !col || !row) return Error(400, "level, column and row must be whole numbers");
  auto png = tiles->Tile(scan, {*level, *col, *row});
  if (png == nullptr) return Error(404, "there is no such tile");
  return {200, "image/png", std::move(png), true};
}

Reply Review::Post(const WebPath& path, const std::string& body) {
  return Answered([&] {
    if (path == WebPath{"api", "say"}) return Record(body);
    if (path == WebPath{"api", "undo"}) return Undo(body);
    if (path == WebPath{"api", "again"}) return Start();
    return NotThere();
  });
}

// Throws InputError if there can be no such mark there.
void Review::RequireMark(const PhotoRecord& photo, const MarkMeasurement& mark) {
  if (!photo.interior)
    throw InputError(fmt::format(
        "{} holds no interior orientation of {}: open the folder where its marks were measured",
        options_.directory, photo.name));
  if (camera_)
    if (const auto ids = block::MarkIds(*camera_); !std::count(ids.begin(), ids.end(), mark.mark))
      throw InputError(fmt::format("camera {} has no mark \"{}\"; its marks are {}",
                                   camera_->camera.name, mark.mark, fmt::join(ids, ", ")));
  const auto size = scans_.Size(photo.name);
  if (size && !(mark.pixel.x() >= 0 && mark.pixel.y() >= 0 && mark.pixel.x() <= size->width &&
                mark.pixel.y() <= size->height))
    throw InputError(fmt::format("pixel {:.1f}, {:.1f} is outside the scan of {}", mark.pixel.x(),
                                 mark.pixel.y(), photo.name));
}

// Throws InputError if the statement cannot apply to this block.
void Review::RequireValid(const Entry& entry) {
  const auto state = states_.Now();
  for (const std::string& photo : PhotosOf(entry))
    if (state->Photo(photo) == nullptr)
      throw InputError(fmt::format("{} has no photo \"{}\"", options_.directory, photo));
  for (const auto& mark : entry.marks) RequireMark(*state->Photo(mark.photo), mark);
  for (const Decision& decision : entry.decisions) {
    const auto index = state->Photo(decision.photo) - state->block.photos.data();
    const Status status = state->verdict.photos.at(static_cast<std::size_t>(index)).status;
    if (decision.kind == DecisionKind::kAccept && status == Status::kFailed)
      throw InputError(
          fmt::format("photo {} has failed and has nothing to accept; measure marks or "
                      "ground points in it, and orient it again",
                      decision.photo));
  }
}

Reply Review::Record(const std::string& body) {
  const PageEntry page = EntryOfPage(body, {options_.by, Today()});
  RequireValid(page.entry);
  if (folder_.Record(page.version, page.entry) == EntryOutcome::kOtherVersion)
    return Error(409,
                 "another window or an editor has changed the files since; this window now "
                 "shows them: please look, and repeat it");
  return Answer(200, {{"version", folder_.Read().second}});
}

Reply Review::Undo(const std::string& body) {
  switch (folder_.Undo(EntryOfPage(body, {}).version)) {
    case EntryOutcome::kRecorded:
      return Answer(200, {{"version", folder_.Read().second}});
    case EntryOutcome::kNothing:
      return Error(409, "there is nothing to take back");
    case EntryOutcome::kOtherVersion:
      break;
  }
  return Error(409, "the files have changed since this was said; this window now shows them");
}

Reply Review::Start() {
  if (!options_.run_again)
    return Error(422, "nothing can be oriented again here: " + options_.why_not_again);
  if (!run_again_.Start()) return Error(409, "a run is under way");
  return GetProgress();
}

}  // namespace orient
