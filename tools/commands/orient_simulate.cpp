// orient simulate: a small block with exact truth, to try the program with and to test it.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <map>
#include <optional>
#include <ostream>

#include "tools/commands/commands.h"
#include "tools/commands/progress.h"
#include "tools/commands/shared_options.h"
#include "tools/commands/summary_table.h"
#include "tools/simulate/simulate.h"

namespace orient {
namespace {

// A value that goes by a name; --help lists the names, and not the numbers that stand for them.
template <typename Enum>
CLI::Option* AddNamed(CLI::App& app, const char* option, Enum* value,
                      const std::map<std::string, Enum>& values, const char* help) {
  const auto set = [value, values](const std::string& name) { *value = values.at(name); };
  return app.add_option_function<std::string>(option, set, help)->check(CLI::IsMember(values));
}

class SimulateCommand : public Command {
 public:
  std::string Name() const override { return "simulate"; }
  std::string Summary() const override {
    return "Simulate a small photo block whose truth is known";
  }
  void Setup(CLI::App& app) override;
  ExitCode Run(std::ostream& out) override;

 private:
  void SetupBlock(CLI::App& app);
  void SetupScans(CLI::App& app);
  void SetupOldPhotos(CLI::App& app);

  SimulationOptions options_;
  OutputOptions output_;
  std::string scan_orientation_ = "r0";
  bool bare_ = false;
};

void SimulateCommand::Setup(CLI::App& app) {
  AddOutputOptions(app, &output_);
  app.add_option("--seed", options_.seed, "Seed of everything random")->capture_default_str();
  SetupBlock(app);
  SetupScans(app);
  SetupOldPhotos(app);
}

void SimulateCommand::SetupBlock(CLI::App& app) {
  const auto add = [&](const char* name, auto& value, const char* help) {
    app.add_option(name, value, help)->capture_default_str()->group("Block");
  };
  add("--photos", options_.photos, "Number of photos to orient");
  add("--strips", options_.strips, "Number of strips");
  add("--gsd-m", options_.gsd_m, "Ground sample distance of these photos, m");
  add("--forward-overlap", options_.forward_overlap, "Within a strip, share of a photo");
  add("--side-overlap", options_.side_overlap, "Between strips, share of a photo");
  add("--kappa", options_.kappa_deg,
      "Of the first strip, degrees; every other strip is flown back");
  add("--tilt-deg", options_.tilt_deg, "Sigma of omega and phi, degrees");
  add("--relief-m", options_.relief_m, "Highest minus lowest ground, m");
  add("--dem-cell-m", options_.dem_cell_m, "Cell of the DEM, m");
  add("--crs", options_.crs, "Projected, metric CRS of the block");
  add("--change", options_.change, "Share of the parcels that changed between the dates");
  add("--position-error-m", options_.position_error_m, "Sigma of the approximate positions, m");
  add("--attitude-error-deg", options_.attitude_error_deg,
      "Sigma of the approximate angles, degrees");
  AddEarthOption(app, &options_.earth)->group("Block");
  app.add_flag("--bare", bare_, "No buildings and no trees")->group("Block");
}

void SimulateCommand::SetupScans(CLI::App& app) {
  const auto add = [&](const char* name, auto& value, const char* help) {
    return app.add_option(name, value, help)->capture_default_str()->group("Camera and scans");
  };
  const std::map<std::string, CameraPreset> presets = {
      {"demo", CameraPreset::kDemo},     {"rc10", CameraPreset::kRc10},
      {"rc30", CameraPreset::kRc30},     {"lmk", CameraPreset::kLmk},
      {"umk", CameraPreset::kUmk},       {"p31", CameraPreset::kP31},
      {"reseau", CameraPreset::kReseau}, {"digital", CameraPreset::kDigital}};
  AddNamed(
      app, "--camera-preset", &options_.camera, presets,
      "demo (6 cm film), rc10, rc30, lmk (23 cm), umk (13 x 18 cm), p31, reseau (crosses in the "
      "picture) or digital")
      ->default_str("demo")
      ->group("Camera and scans");
  app.add_option("--pixel-size-um", options_.pixel_size_um, "Of the scans; default the preset's")
      ->group("Camera and scans");
  add("--scan-orientation", scan_orientation_, "Scan orientation of the film")
      ->check(CLI::IsMember({"r0", "r90", "r180", "r270", "m0", "m90", "m180", "m270", "random"}));
  const std::map<std::string, Polarity> polarities = {{"positive", Polarity::kPositive},
                                                      {"negative", Polarity::kNegative}};
  AddNamed(app, "--polarity", &options_.polarity, polarities, "positive or negative")
      ->default_str("positive")
      ->group("Camera and scans");
  add("--bits", options_.bits, "Per grey value, 8 or 16");
  add("--scan-rotation-deg", options_.scan_rotation_deg, "Sigma of the film's rotation, degrees");
  add("--film-shrink-ppm", options_.film_shrink_ppm, "Sigma of the film's affine deformation");
  add("--film-bend-um", options_.film_bend_um, "The rest of its deformation, smooth, RMS");
  add("--grain", options_.grain, "Sigma in 8-bit grey values");
  add("--blur-px", options_.blur_px, "Sigma of the scanner's point spread");
  add("--missing-marks", options_.missing_marks, "Number of missing fiducial marks");
  add("--dirty-marks", options_.dirty_marks, "Number of fiducial marks under a hair and a blot");
  app.add_flag("--mark-symbols", options_.mark_symbols, "Number the marks by lines beside them")
      ->group("Camera and scans");
}

void SimulateCommand::SetupOldPhotos(CLI::App& app) {
  const auto add = [&](const char* name, auto& value, const char* help) {
    app.add_option(name, value, help)->capture_default_str()->group("Old photos");
  };
  add("--old-gsd-ratio", options_.old_gsd_ratio, "Their ground sample distance / the new photos'");
  add("--old-height-ratio", options_.old_height_ratio, "Their flying height / the new photos'");
  add("--old-kappa", options_.old_kappa_deg, "Their kappa relative to the new photos, degrees");
  app.add_flag("--old-film", options_.old_film, "Scanned film, not digital")->group("Old photos");
  app.add_flag("--ortho", options_.ortho, "Also make an orthophoto of the old date")
      ->group("Old photos");
}

ExitCode SimulateCommand::Run(std::ostream& out) {
  options_.overwrite = output_.overwrite;
  options_.objects = !bare_;
  options_.orientation = ScanOrientationFromName(scan_orientation_);  // random: none for all
  std::optional<ProgressLine> progress;
  const SimulationSummary summary = Simulate(options_, output_.directory, [&](int, int steps) {
    if (progress)
      progress->Advance();
    else
      progress.emplace("simulate", steps);
  });
  progress.reset();

  SummaryTable table({"made", "count", "what"});
  table.AddRow({"new photos", std::to_string(summary.photos.size()),
                fmt::format("{} x {} px, flown {} m above ground", summary.width, summary.height,
                            Fixed(summary.flying_height_m, 0))});
  table.AddRow({"old photos", std::to_string(summary.old_photos.size()), "with their orientation"});
  table.AddRow({"parcels", std::to_string(summary.parcels), "of land"});
  table.AddRow({"buildings", std::to_string(summary.buildings), "not in the DEM"});
  table.AddRow({"trees", std::to_string(summary.trees), "not in the DEM"});
  table.Print(out);
  out << "block " << summary.block_file << "\ntruth " << summary.truth_file << "\n";
  return ExitCode::kAllDone;
}

}  // namespace

std::unique_ptr<Command> MakeSimulateCommand() { return std::make_unique<SimulateCommand>(); }

}  // namespace orient
