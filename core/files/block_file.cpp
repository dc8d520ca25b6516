#include "core/files/block_file.h"

#include <fmt/format.h>
#include <glob.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <set>
#include <sstream>
#include <system_error>

#include "core/base/atomic_write.h"
#include "core/base/date.h"
#include "core/base/error.h"
#include "core/base/remote_files.h"
#include "core/files/flight_plan_keys.h"
#include "core/files/orientation_table.h"
#include "core/files/toml_fields.h"
#include "core/geometry/rotation.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

// Placeholder for the patch database that a run makes in its output directory, until it is named.
constexpr const char* kControlDatabase = "control.gpkg";

std::string Resolve(const std::string& base, const std::string& path) {
  if (const std::string name = GdalName(path); IsVirtual(name)) return name;
  return (fs::path(base) / path).lexically_normal().string();
}

// A file in a folder without access counts as missing; so does a name that is too long.
bool Exists(const std::string& path) {
  std::error_code ignored;
  return fs::exists(path, ignored);
}

// A folder's name is not a pattern, whatever characters it has.
std::string Escaped(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    if (std::string_view("*?[\\").find(c) != std::string_view::npos) escaped += '\\';
    escaped += c;
  }
  return escaped;
}

bool IsPattern(const std::string& text) { return text.find_first_of("*?[") != std::string::npos; }

// An address with a query (?) is not a pattern. [ counts in the last part only: addresses have
// [::1].
bool IsRemotePattern(const std::string& name) {
  return IsRemote(name) && name.find('?') == std::string::npos &&
         (name.find('*') != std::string::npos ||
          name.find('[', name.rfind('/')) != std::string::npos);
}

std::vector<std::string> Matches(const std::string& pattern, const std::string& base) {
  if (const std::string remote = GdalName(pattern); IsRemotePattern(remote)) {
    const std::vector<std::string> found = RemoteMatches(remote);
    if (found.empty()) throw InputError("no photo matches " + pattern + "; check the spelling");
    return found;
  }
  std::error_code ignored;  // a link to itself is a photo that cannot be opened
  if (const std::string plain = Resolve(base, pattern); IsVirtual(plain) || Exists(plain)) {
    if (!IsVirtual(plain) && fs::is_directory(plain, ignored))
      throw InputError(plain + " is a folder; name the photos in it, as in " + plain + "/*.tif");
    return {plain};
  }
  const bool absolute = fs::path(pattern).is_absolute() || base.empty();
  glob_t found{};
  const int status = glob(absolute ? pattern.c_str() : (Escaped(base) + "/" + pattern).c_str(), 0,
                          nullptr, &found);
  std::vector<std::string> paths;
  for (size_t i = 0; status == 0 && i < found.gl_pathc; ++i)
    if (!fs::is_directory(found.gl_pathv[i], ignored))
      paths.push_back(fs::path(found.gl_pathv[i]).lexically_normal().string());
  globfree(&found);
  if (paths.empty())
    throw InputError(fmt::format("no photo matches {}; check the folder and the spelling",
                                 Resolve(base, pattern)));
  return paths;
}

std::string ExistingFile(const TomlTable& table, std::string_view key, const std::string& base) {
  const std::string path = Resolve(base, table.Text(key));
  if (!IsVirtual(path) && !Exists(path))
    table.Fail(key,
               fmt::format("names {}, which does not exist{}", path,
                           key == "patchdb" ? "; 'orient patchdb create' and 'harvest' make it, "
                                              "or the block itself of what [control] names"
                                            : ""));
  return path;
}

// A file; or a name like wild_rc10, unchanged, if no file beside the block file has that name.
std::string CameraFileOrName(const TomlTable& table, const std::string& base) {
  const std::string named = table.Text("camera");
  const fs::path asked(named);
  if (asked.has_parent_path() || asked.has_extension() || Exists(Resolve(base, named)))
    return ExistingFile(table, "camera", base);
  return named;
}

void ReadAccuracy(const TomlTable& root, BlockFile* block) {
  const auto table =
      root.FindTable("approximate_accuracy", {"position_m", "attitude_deg", "observe"});
  if (!table) return;
  block->position_sigma_m = table->FindSigma("position_m");
  if (const auto deg = table->FindSigma("attitude_deg"))
    block->attitude_sigma_rad = RadFromDeg(*deg);
  block->observe_approximations = table->FindFlag("observe").value_or(false);
}

void ReadScan(const TomlTable& root, BlockFile* block) {
  const auto table = root.FindTable("scan", {"pixel_size_um", "polarity", "orientation"});
  if (!table) return;
  if (table->Has("pixel_size_um")) {
    block->pixel_size_um = table->PositiveNumber("pixel_size_um");
    if (*block->pixel_size_um < 1 || *block->pixel_size_um > 1000)
      table->Fail("pixel_size_um", "must lie between 1 and 1000 micrometres");
  }
  const std::string polarity = table->FindText("polarity").value_or("auto");
  if (polarity == "positive") {
    block->polarity = Polarity::kPositive;
  } else if (polarity == "negative") {
    block->polarity = Polarity::kNegative;
  } else if (polarity != "auto") {
    table->Fail("polarity", "is \"" + polarity + "\"; it must be auto, positive or negative");
  }
  const std::string orientation = table->FindText("orientation").value_or("auto");
  block->orientation = ScanOrientationFromName(orientation);
  if (!block->orientation && orientation != "auto")
    table->Fail("orientation", "is \"" + orientation +
                                   "\"; it must be auto, r0, r90, r180, r270, m0, m90, m180 or "
                                   "m270");
}

void ReadAdjustment(const TomlTable& root, BlockFile* block) {
  const auto table = root.FindTable(
      "block", {"ties", "check_share", "self_calibration", "pose_covariance", "sub_block_photos"});
  if (!table) return;
  BlockAdjustmentChoice& choice = block->adjustment;
  choice.ties = table->FindFlag("ties").value_or(choice.ties);
  choice.check_share = table->FindNumber("check_share").value_or(choice.check_share);
  if (choice.check_share < 0 || choice.check_share > 0.9)
    table->Fail("check_share", "must lie between 0 and 0.9");
  const std::string calibration = table->FindText("self_calibration").value_or("none");
  if (calibration != "none" && calibration != "camera")
    table->Fail("self_calibration", "is \"" + calibration + "\"; it must be none or camera");
  choice.self_calibration = calibration == "camera";
  choice.pose_covariance = table->FindFlag("pose_covariance").value_or(choice.pose_covariance);
  choice.sub_block_photos = table->FindCount("sub_block_photos").value_or(choice.sub_block_photos);
  constexpr int kLeast = 300;  // of fewer, most lie around a sub-block's core, not in it
  if (choice.sub_block_photos < kLeast)
    table->Fail("sub_block_photos", fmt::format("must be at least {}", kLeast));
  if (choice.self_calibration && std::ssize(block->photos) > choice.sub_block_photos)
    table->Fail("self_calibration",
                fmt::format("would give each sub-block a camera of its own: the block lists {} "
                            "photos, more than sub_block_photos = {}. Calibrate with a part of "
                            "the photos, and adjust all with its calibrated_camera.toml",
                            block->photos.size(), choice.sub_block_photos));
}

void ReadGnss(const TomlTable& root, const std::string& base, BlockFile* block) {
  const auto table = root.FindTable("gnss", {"positions", "sigma_m", "model"});
  if (!table) return;
  GnssChoice& gnss = block->gnss;
  gnss.positions = ExistingFile(*table, "positions", base);
  gnss.sigma_m = table->FindSigma("sigma_m");
  static const std::map<std::string, GnssModel> models = {
      {"plain", GnssModel::kPlain},
      {"shift", GnssModel::kShift},
      {"shift_and_drift", GnssModel::kShiftAndDrift}};
  const std::string name = table->FindText("model").value_or("shift");
  const auto model = models.find(name);
  if (model == models.end())
    table->Fail("model", "is \"" + name + "\"; it must be plain, shift or shift_and_drift");
  gnss.model = model->second;
  if (gnss.model == GnssModel::kShiftAndDrift && block->flight.Empty())
    table->Fail("model", "is \"shift_and_drift\", but drift is per strip: list them as [[strips]]");
}

void ReadOrtho(const TomlTable& root, BlockFile* block) {
  const auto table = root.FindTable(
      "ortho", {"gsd_m", "dem_sigma_m", "mosaic", "weak", "least_difference", "balance"});
  if (!table) return;
  OrthoChoice ortho;
  if (table->Has("gsd_m")) ortho.gsd_m = table->PositiveNumber("gsd_m");
  if (table->Has("dem_sigma_m")) ortho.dem_sigma_m = table->PositiveNumber("dem_sigma_m");
  ortho.mosaic = table->FindFlag("mosaic").value_or(ortho.mosaic);
  ortho.weak = table->FindFlag("weak").value_or(ortho.weak);
  ortho.least_difference = table->FindFlag("least_difference").value_or(ortho.least_difference);
  ortho.balance = table->FindFlag("balance").value_or(ortho.balance);
  for (const char* of_mosaic : {"least_difference", "balance"})
    if (!ortho.mosaic && table->Has(of_mosaic))
      table->Fail(of_mosaic, "is for the mosaic, which mosaic = false leaves out");
  block->ortho = ortho;
}

// The database lies in the output directory, which must have been read before.
void ReadControl(const TomlTable& root, const std::string& base, BlockFile* block) {
  const auto table =
      root.FindTable("control", {"orthophotos", "photos", "camera", "orientation", "interior",
                                 "dsm", "dem_sigma_m", "date", "chip_px"});
  if (!table) return;
  if (root.Has("patchdb"))
    root.Fail("patchdb",
              "is given, and so is [control]; the one is a database that is there, the "
              "other has one made: leave one of them out");
  ControlChoice control;
  if (table->Has("orthophotos") == table->Has("photos"))
    table->Fail("orthophotos", "or photos must be given, one of them");
  const char* key = table->Has("photos") ? "photos" : "orthophotos";
  auto& images = table->Has("photos") ? control.photos : control.orthophotos;
  try {
    images = ExpandPhotos(*table->FindTexts(key), base);
  } catch (const InputError& error) {
    table->Fail(key, std::string("cannot be used: ") + error.what());
  }
  if (images.empty()) table->Fail(key, "is empty");
  for (const char* of_photos : {"camera", "orientation", "interior"})
    if (table->Has("orthophotos") && table->Has(of_photos))
      table->Fail(of_photos, "is for photos; orthophotos need none");
  if (table->Has("photos")) {
    control.camera = CameraFileOrName(*table, base);
    control.orientation = ExistingFile(*table, "orientation", base);
    if (table->Has("interior")) control.interior = ExistingFile(*table, "interior", base);
  }
  if (table->Has("dsm")) control.dsm = ExistingFile(*table, "dsm", base);
  if (table->Has("dem_sigma_m")) control.dem_sigma_m = table->PositiveNumber("dem_sigma_m");
  control.chip_px = table->FindCount("chip_px");
  if (control.chip_px &&
      (*control.chip_px < 15 || *control.chip_px > 501 || *control.chip_px % 2 == 0))
    table->Fail("chip_px", "must be odd, from 15 to 501");
  control.date = table->FindText("date");
  if (control.date && !DateProblem(*control.date).empty())
    table->Fail("date", "is " + DateProblem(*control.date));
  block->control = std::move(control);
  block->patchdb = (fs::path(block->output_directory) / kControlDatabase).string();
}

EarthMode ReadEarth(const TomlTable& root) {
  const std::string earth = root.FindText("earth").value_or("auto");
  const auto mode = EarthModes().find(earth);
  if (mode == EarthModes().end())
    root.Fail("earth", fmt::format("is \"{}\"; it must be auto, flat or curved", earth));
  return mode->second;
}

// Replaces "@FILE" by the file's lines, except empty ones and comments (#), unless a photo has
// this name.
std::vector<std::string> WithListed(const std::vector<std::string>& patterns,
                                    const std::string& base) {
  std::vector<std::string> all;
  for (const std::string& pattern : patterns) {
    if (!pattern.starts_with('@') || Exists(Resolve(base, pattern))) {
      all.push_back(pattern);
      continue;
    }
    std::string text = ReadFile(Resolve(base, pattern.substr(1)));
    if (text.starts_with("\xef\xbb\xbf")) text.erase(0, 3);  // a byte order mark
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) {
      line.erase(line.find_last_not_of(" \t\r") + 1);
      if (!line.empty() && line.front() != '#') all.push_back(line);
    }
  }
  return all;
}

using PathsByName = std::map<std::string, std::set<std::string>>;

// Throws InputError for a pattern without a match; a plain path is kept even if it does not exist.
PathsByName PhotosByName(const std::vector<std::string>& patterns, const std::string& base) {
  PathsByName paths;
  for (const std::string& pattern : WithListed(patterns, base)) {
    const std::string plain = Resolve(base, pattern);
    if (!IsPattern(pattern) && !IsVirtual(plain) && !Exists(plain)) {
      paths[PhotoName(plain)].insert(plain);
      continue;
    }
    for (const std::string& path : Matches(pattern, base)) paths[PhotoName(path)].insert(path);
  }
  return paths;
}

void ReadPhotos(const TomlTable& root, const std::string& base, BlockFile* block) {
  const auto patterns = root.FindTexts("photos");
  if (!patterns || patterns->empty())
    root.Fail("photos", "must list the photos, as in [\"scans/*.tif\"]");
  try {
    for (const auto& [name, paths] : PhotosByName(*patterns, base)) {
      const std::string& path = *paths.begin();
      if (paths.size() == 1 && (IsVirtual(path) || Exists(path)))
        block->photos.push_back(path);
      else if (paths.size() == 1)
        block->unusable.push_back({name, path + " does not exist; check the block file's photos"});
      else
        block->unusable.push_back({name, *paths.begin() + " and " + *paths.rbegin() +
                                             " have the same name, so their results and "
                                             "approximations would coincide; rename one"});
    }
  } catch (const InputError& error) {
    root.Fail("photos", std::string("cannot be used: ") + error.what());
  }
  std::sort(block->photos.begin(), block->photos.end());
  if (block->photos.empty() && block->unusable.empty())
    root.Fail("photos", "names no photo: the list is empty");
  if (block->photos.empty())
    root.Fail("photos", "names no photo that can be used: " + block->unusable.front().reason);
}

std::vector<std::string> NamesOf(const BlockFile& block) {
  std::vector<std::string> names;
  for (const std::string& path : block.photos) names.push_back(PhotoName(path));
  for (const UnusablePhoto& photo : block.unusable) names.push_back(photo.name);
  return names;
}

void ReadOutput(const TomlTable& root, const std::string& base, BlockFile* block) {
  const auto table = root.FindTable("output", {"directory", "formats"});
  const std::string directory = table ? table->FindText("directory").value_or("out") : "out";
  if (directory.empty()) table->Fail("directory", "is empty; name a folder for the results");
  block->output_directory = Resolve(base, directory);
  if (table) block->formats = table->FindTexts("formats").value_or(std::vector<std::string>());
}

// A definition, or the file (.prj) that holds one.
Crs ReadCrs(const TomlTable& root, const std::string& base, const std::string& path) {
  const std::string given = root.Text("crs");
  const std::string file = Resolve(base, given);
  std::error_code ignored;
  return fs::is_regular_file(file, ignored) ? Crs::FromFile(file)
                                            : Crs::Parse(given, path + ", crs");
}

}  // namespace

std::vector<std::string> ExpandPhotos(const std::vector<std::string>& patterns,
                                      const std::string& base) {
  std::vector<std::string> photos;
  for (const std::string& pattern : WithListed(patterns, base)) {
    const std::vector<std::string> found = Matches(pattern, base);
    photos.insert(photos.end(), found.begin(), found.end());
  }
  std::sort(photos.begin(), photos.end());
  photos.erase(std::unique(photos.begin(), photos.end()), photos.end());
  std::map<std::string, std::string> path_of_name;
  for (const std::string& photo : photos) {
    const auto [other, is_new] = path_of_name.emplace(PhotoName(photo), photo);
    if (!is_new)
      throw InputError(other->second + " and " + photo + " would both be the photo \"" +
                       other->first + "\"; rename one or name fewer photos");
  }
  return photos;
}

BlockFile ReadBlockFile(const std::string& path) {
  const toml::table document = ParseTomlFile(path);
  const TomlTable root(document, path, "",
                       {"crs", "dem", "patchdb", "camera", "photos", "approximations",
                        "approximate_accuracy", "scan", "output", "block", "earth", "flight",
                        "strips", "gnss", "date", "target_m", "ortho", "measurements", "control"});
  const std::string base = fs::path(path).parent_path().string();
  const bool measured = root.Has("measurements") && !root.Has("patchdb") && !root.Has("control") &&
                        !root.Has("photos") && !root.Has("dem");
  BlockFile block{
      .crs = ReadCrs(root, base, path),
      .dem = measured ? "" : ExistingFile(root, "dem", base),
      .patchdb = measured || root.Has("control") ? "" : ExistingFile(root, "patchdb", base),
      .camera = CameraFileOrName(root, base),
      .approximations =
          root.Has("approximations") ? ExistingFile(root, "approximations", base) : std::string(),
      .earth = ReadEarth(root)};
  if (!measured) ReadPhotos(root, base, &block);
  if (root.Has("measurements")) block.measurements = ExistingFile(root, "measurements", base);
  block.flight = ReadFlightPlan(root, NamesOf(block));
  ReadGnss(root, base, &block);
  ReadOutput(root, base, &block);
  ReadControl(root, base, &block);
  ReadAccuracy(root, &block);
  ReadAdjustment(root, &block);
  ReadScan(root, &block);
  ReadOrtho(root, &block);
  block.date = root.FindText("date");
  if (block.date && !DateProblem(*block.date).empty())
    root.Fail("date", "is " + DateProblem(*block.date));
  if (root.Has("target_m")) block.target_m = root.PositiveNumber("target_m");
  return block;
}

}  // namespace orient
