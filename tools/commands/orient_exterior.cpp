// orient exterior: poses of photos from control patches.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <ostream>

#include "block/inputs/approximations.h"
#include "block/inputs/block_files.h"
#include "block/inputs/camera_library.h"
#include "block/inputs/measurement_inputs.h"
#include "block/stages/exterior_stage.h"
#include "core/base/error.h"
#include "core/files/adjustment_result.h"
#include "core/files/block_file.h"
#include "core/files/orientation_table.h"
#include "tools/commands/commands.h"
#include "tools/commands/exterior_summary.h"
#include "tools/commands/patchdb_to_write.h"
#include "tools/commands/progress.h"
#include "tools/commands/shared_options.h"
#include "tools/commands/stage_runs.h"

namespace orient {
namespace {

class ExteriorCommand : public Command {
 public:
  std::string Name() const override { return "exterior"; }
  std::string Summary() const override {
    return "Exterior orientation: poses of photos from control patches";
  }

  void Setup(CLI::App& app) override {
    AddPhotosOption(app, &patterns_);
    app.add_option("--camera", options_.camera,
                   "Camera file (TOML) or a name from the camera library")
        ->required();
    AddCameraLibraryOption(app, &library_);
    app.add_option("--approximations", options_.approximations,
                   "Approximate orientations (OPK CSV with its .prj beside it); required where "
                   "no ground points are measured");
    app.add_option("--flying-height-m", options_.flying_height_m,
                   "Flying height above the ground, metres, for approximate positions without "
                   "heights");
    AddMeasurementsOption(app, &options_.measurements);
    app.add_option("--dem", options_.dem, "Ground heights: any raster GDAL reads")->required();
    app.add_option("--patchdb", options_.patchdb, "Patch database, or a folder of them")
        ->required();
    app.add_option("--interior", options_.interior,
                   "Folder with the results of 'orient interior'; required for film photos");
    app.add_option("--position-sigma-m", options_.position_sigma_m,
                   "One sigma of approximate positions without sigma columns, metres "
                   "(default 10)");
    app.add_option("--attitude-sigma-deg", attitude_sigma_deg_,
                   "One sigma of approximate angles without sigma columns, degrees "
                   "(default 3)");
    app.add_option("--kappa-sigma-deg", kappa_sigma_deg_,
                   "One sigma of approximate kappas without sigma columns, if it differs from that "
                   "of omega and phi; 180: unknown");
    AddEarthOption(app, &options_.earth);
    app.add_option("--principal-distance-sigma-mm", options_.principal_distance_sigma_mm,
                   "Estimate the principal distance with each photo's pose; one sigma of the "
                   "camera file's, mm");
    app.add_option(
        "--target-m", options_.target_m,
        "Accuracy on the ground that makes a photo ok: one sigma anywhere in its frame, "
        "metres (default: what the control allows: a pixel of the photo, half a pixel of "
        "the patches, and the effect of their heights' accuracy in the corners)");
    app.add_option("--date", options_.date,
                   "Date of exposure of photos without one in the table of approximations, "
                   "ISO 8601 (1961, 1961-07-30)");
    AddLearnOption(app, &options_.learn);
    AddJobsOption(app, &options_.jobs);
    AddOutputOptions(app, &output_);
    app.add_flag("--resume", options_.resume, "Keep existing results and do the others");
    AddPlanOption(app, &plan_);
  }

  // What the command line asks for.
  block::ExteriorRunOptions Options() const {
    block::ExteriorRunOptions options = options_;
    options.photos = PhotosOf(patterns_);
    options.camera = block::FindCameraFile(options.camera, library_);
    options.out = output_.directory;
    if (attitude_sigma_deg_) options.attitude_sigma_rad = RadFromDeg(*attitude_sigma_deg_);
    if (kappa_sigma_deg_) options.kappa_sigma_rad = RadFromDeg(*kappa_sigma_deg_);
    options.alone = true;
    return options;
  }

  ExitCode Run(std::ostream& out) override {
    const block::ExteriorRunOptions options = Options();
    const Measurements& measurements = options.measurements;
    if (options.approximations.empty() && measurements.image_points.empty() &&
        std::none_of(
            measurements.decisions.begin(), measurements.decisions.end(),
            [](const Decision& decision) { return decision.kind == DecisionKind::kPosition; }))
      throw UsageError(
          "--approximations is required unless ground points are measured or positions "
          "are decided");
    RefuseToReplace(options);
    if (plan_) {
      PrintPlan("exterior", options.photos, block::ExteriorsThatStay(options), out);
      return ExitCode::kAllDone;
    }
    if (options.learn) BringUpToDateToLearn(options.patchdb, out);
    ProgressLine progress("exterior orientation", static_cast<int>(options.photos.size()));
    const auto done = block::RunExterior(options, [&] { progress.Advance(); });
    progress.Finish();
    RecordRun(Invoked(), options.out, "exterior",
              {FileInput("camera", options.camera), RasterInput("DEM", options.dem),
               PatchesInput(options.patchdb), FileInput("approximations", options.approximations)});
    PrintExteriorSummary(done, out);
    PrintRemarks(options.approximations, out);
    if (const auto unknown = block::UnknownPhotos(measurements, block::PhotoNames(options.photos)))
      out << "note      " << Sentence(*unknown) << "\n";
    return AllOriented(done) ? ExitCode::kAllDone : ExitCode::kSomeNotOriented;
  }

 private:
  // Refuses to replace what the run writes, or what it removes because it holds for other poses.
  void RefuseToReplace(const block::ExteriorRunOptions& options) const {
    const auto path = [&](const char* file) {
      return (std::filesystem::path(options.out) / file).string();
    };
    std::vector<std::string> inputs = options.photos;
    for (const std::string& input :
         {options.camera, options.dem, options.patchdb, options.approximations})
      inputs.push_back(input);
    Append(MeasurementFiles(options.measurements.folder), &inputs);
    std::vector<std::string> written = block::ExteriorFiles(options.out);
    Append(block::PhotoFiles(options.out, block::PhotoNames(options.photos)), &written);
    RefuseToReplaceInputs(written, inputs);
    std::vector<std::string> results = {path("orientation.csv"), path("block_camera.toml")};
    for (const std::string& photo : options.photos)
      results.push_back(ExteriorResultPath(options.out, PhotoName(photo)));
    RefuseToOverwrite(results, output_.overwrite || options.resume, "--resume");
    if (options.resume && !output_.overwrite) RefuseOtherPhotos(options, results.front());
    RefuseToOverwrite(
        {AdjustmentResultPath(options.out), path(block::kQuicklookFile), path(block::kSeamsFile),
         path(block::kCalibratedCameraFile), path(block::kPoseCovarianceFile)},
        output_.overwrite);
  }

  // Prints what the table of approximations holds but the run did not use.
  static void PrintRemarks(const std::string& table, std::ostream& out) {
    if (table.empty() || !block::IsOrientationTable(table)) return;
    const OrientationTable read = ReadOrientationTable(table, OpenCells::kAnglesAndHeights);
    for (const std::string& remark : Sentences(block::RemarksOn(read, table)))
      out << "note      " << remark << "\n";
  }

  // The table of a resumed run must hold only its own photos.
  static void RefuseOtherPhotos(const block::ExteriorRunOptions& options,
                                const std::string& table) {
    if (!std::filesystem::exists(table)) return;
    for (const OrientationRow& row : ReadOrientationTable(table).rows)
      if (std::none_of(options.photos.begin(), options.photos.end(),
                       [&](const std::string& photo) { return PhotoName(photo) == row.photo; }))
        throw UsageError(table + " also has the photo " + row.photo +
                         ", and would be replaced; name all of its photos, choose another folder, "
                         "or give --overwrite");
  }

  std::vector<std::string> patterns_;
  block::ExteriorRunOptions options_;
  std::string library_;
  OutputOptions output_;
  bool plan_ = false;
  std::optional<double> attitude_sigma_deg_, kappa_sigma_deg_;
};

}  // namespace

block::ExteriorRunOptions ExteriorRunOf(const std::vector<std::string>& arguments) {
  return OptionsOf<ExteriorCommand>(arguments);
}

std::unique_ptr<Command> MakeExteriorCommand() { return std::make_unique<ExteriorCommand>(); }

}  // namespace orient
