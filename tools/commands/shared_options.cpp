#include "tools/commands/shared_options.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <map>
#include <ostream>
#include <set>
#include <system_error>

#include "block/plan.h"
#include "core/base/error.h"
#include "core/files/block_file.h"
#include "core/files/orientation_table.h"
#include "patchdb/store/is_patch_database.h"

namespace orient {
namespace fs = std::filesystem;

CLI::Option* AddPhotosOption(CLI::App& app, std::vector<std::string>* patterns) {
  CLI::Option* photos =
      app.add_option("PHOTO", *patterns, "Scans or images; globs are expanded; @FILE: a list");
  app.add_option_function<std::string>(
      "--files-from", [patterns](const std::string& file) { patterns->push_back("@" + file); },
      "File that lists scans or globs, one per line: as @FILE");
  return photos;
}

std::vector<std::string> PhotosOf(const std::vector<std::string>& patterns) {
  if (patterns.empty())
    throw UsageError("PHOTO is required: name at least one scan, a glob or a list of them");
  return ExpandPhotos(patterns, "");
}

CLI::Option* AddJobsOption(CLI::App& app, int* jobs) {
  return app.add_option("--jobs", *jobs, "Photos processed at the same time; 0: one per processor")
      ->check(CLI::Range(0, 1024));
}

void AddLearnOption(CLI::App& app, bool* learn) {
  CLI::Option* option = app.add_flag(
      "--learn", *learn, "Record in the patch database which patches matched; may retire patches");
  app.add_flag("--no-feedback")
      ->description("Leave the patch database unchanged: the default")
      ->excludes(option);
}

CLI::Option* AddCameraLibraryOption(CLI::App& app, std::string* folder) {
  return app.add_option("--camera-library", *folder,
                        "Folder of the camera library, if not the program's own");
}

void AddOverwriteOption(CLI::App& app, bool* overwrite) {
  app.add_flag("--overwrite", *overwrite, "Replace existing results");
}

void AddPlanOption(CLI::App& app, bool* plan) {
  app.add_flag("--plan", *plan, "Print what would be done and stop");
}

void PrintPlan(const std::string& stage, const std::vector<std::string>& photos,
               const std::set<std::string>& kept, std::ostream& out) {
  for (const std::string& path : photos) {
    const std::string name = PhotoName(path);
    out << block::PlanLine(kept.contains(name), fmt::format("{}  {}", stage, name)) << "\n";
  }
}

void AddMeasurementsOption(CLI::App& app, Measurements* measurements) {
  app.add_option_function<std::string>(
      "--measurements",
      [measurements](const std::string& folder) { *measurements = ReadMeasurements(folder); },
      "Folder with manual measurements and decisions: marks.csv, image_points.csv, points.csv, "
      "decisions.csv");
}

void AddOutputOptions(CLI::App& app, OutputOptions* output) {
  app.add_option("--out", output->directory, "Folder for the results; created if missing")
      ->required();
  AddOverwriteOption(app, &output->overwrite);
}

void AddScanOptions(CLI::App& app, ScanOptions* scan) {
  app.add_option("--pixel-size-um", scan->pixel_size_um,
                 "Pixel size of the scan in micrometres, 1 to 1000; determined if not given")
      ->check(CLI::Range(1.0, 1000.0));
  app.add_option_function<std::string>(
         "--polarity",
         [scan](const std::string& text) {
           scan->polarity.reset();
           if (text == "positive") scan->polarity = Polarity::kPositive;
           if (text == "negative") scan->polarity = Polarity::kNegative;
         },
         "Polarity of the scan; auto: determined")
      ->check(CLI::IsMember({"auto", "positive", "negative"}))
      ->default_str("auto");
  std::vector<std::string> names = {"auto"};
  for (const ScanOrientation orientation : kAllScanOrientations)
    names.emplace_back(Name(orientation));
  app.add_option_function<std::string>(
         "--orientation",
         [scan](const std::string& text) { scan->orientation = ScanOrientationFromName(text); },
         "Scan orientation: rotated counter-clockwise, m: mirrored first")
      ->check(CLI::IsMember(names))
      ->default_str("auto");
}

void RefuseToOverwrite(const std::vector<std::string>& results, bool overwrite,
                       const std::string& alternative) {
  if (overwrite) return;
  std::error_code error;
  const auto existing = std::find_if(results.begin(), results.end(), [&](const std::string& path) {
    return fs::exists(fs::symlink_status(path, error));  // a link that leads nowhere, too
  });
  if (existing == results.end()) return;
  throw UsageError(*existing + " exists already; choose another folder or give --overwrite" +
                   (alternative.empty() ? "" : " or " + alternative));
}

namespace {

// Where files are, through links of their folders; folders are looked up once.
class Places {
 public:
  std::string Of(const std::string& path) {
    const fs::path given = fs::path(path).lexically_normal();
    const fs::path folder = given.parent_path().empty() ? "." : given.parent_path();
    const auto [known, is_new] = folders_.try_emplace(folder.string());
    std::error_code error;
    if (is_new) known->second = fs::weakly_canonical(folder, error).string();
    return (fs::path(known->second) / given.filename()).string();
  }

 private:
  std::map<std::string, std::string> folders_;
};

}  // namespace

void RefuseToReplaceInputs(const std::vector<std::string>& results,
                           const std::vector<std::string>& inputs) {
  Places places;
  std::set<std::string> written;
  for (const std::string& result : results) written.insert(places.Of(result));
  const auto in_written = [&](fs::path path) {
    for (; path.has_relative_path(); path = path.parent_path())
      if (written.contains(path.string())) return true;
    return false;
  };
  for (const std::string& input : inputs) {
    if (input.empty()) continue;
    std::error_code error;
    const fs::path target = fs::canonical(input, error);  // of a link
    if (in_written(places.Of(input)) || (!error && in_written(target)))
      throw UsageError(input +
                       " is an input of this run, and would be replaced by a result of this name; "
                       "choose another folder for the results, or rename it");
  }
}

void Append(const std::vector<std::string>& files, std::vector<std::string>* list) {
  list->insert(list->end(), files.begin(), files.end());
}

std::vector<std::string> MeasurementFiles(const std::string& folder) {
  std::vector<std::string> files;
  if (folder.empty()) return files;
  for (const char* file : {kMarksFile, kImagePointsFile, kPointsFile, kDecisionsFile})
    files.push_back((fs::path(folder) / file).string());
  return files;
}

void RefuseToReplacePatches(const std::string& directory) {
  const std::string path = (fs::path(directory) / "block.gpkg").string();
  if (patchdb::IsPatchDatabase(path))
    throw UsageError(path +
                     " is a patch database, and would be replaced by the block's GeoPackage of "
                     "this name; rename it, or choose another folder");
}

CLI::Option* AddEarthOption(CLI::App& app, EarthMode* mode) {
  return app
      .add_option_function<std::string>(
          "--earth", [mode](const std::string& name) { *mode = EarthModes().at(name); },
          "Earth curvature and refraction: auto (where they exceed 0.1 px), flat (without) or "
          "curved (with them)")
      ->check(CLI::IsMember({"auto", "flat", "curved"}))
      ->default_str("auto");
}

}  // namespace orient
