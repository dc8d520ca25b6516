// orient exterior: poses of photos from control patches.
#include <CLI/CLI.hpp>
#include <ostream>

#include "block/inputs/camera_library.h"
#include "block/stages/exterior_stage.h"
#include "core/files/block_file.h"
#include "tools/commands/commands.h"
#include "tools/commands/exterior_options.h"
#include "tools/commands/exterior_summary.h"
#include "tools/commands/patchdb_to_write.h"
#include "tools/commands/progress.h"
#include "tools/commands/shared_options.h"

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
    app.add_option("--camera", camera_, "Camera file (TOML) or a name from the camera library")
        ->required();
    AddCameraLibraryOption(app, &library_);
    app.add_option("--dem", dem_, "Ground heights: any raster GDAL reads")->required();
    AddMeasurementsOption(app, &measurements_);
    told_.Setup(app);
    app.get_option("--patchdb")->required();
    AddLearnOption(app, &learn_);
    AddJobsOption(app, &jobs_);
    AddOutputOptions(app, &output_);
    app.add_flag("--resume", resume_, "Keep existing results and do the others");
    AddPlanOption(app, &plan_);
  }

  ExitCode Run(std::ostream& out) override {
    block::ExteriorRunOptions options = told_.For(measurements_);
    options.photos = ExpandPhotos(patterns_, "");
    options.camera = block::FindCameraFile(camera_, library_);
    options.dem = dem_;
    options.out = output_.directory;
    options.learn = learn_;
    options.resume = resume_;
    options.jobs = jobs_;
    RefuseToReplace(options, output_.overwrite);
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
               FileInput("patch database", options.patchdb),
               FileInput("approximations", options.approximations)});
    PrintExteriorSummary(done, out);
    return AllOriented(done) ? ExitCode::kAllDone : ExitCode::kSomeNotOriented;
  }

 private:
  std::vector<std::string> patterns_;
  std::string camera_, library_, dem_;
  Measurements measurements_;
  ExteriorOptions told_;
  OutputOptions output_;
  int jobs_ = 0;
  bool learn_ = false;
  bool resume_ = false;
  bool plan_ = false;
};

}  // namespace

std::unique_ptr<Command> MakeExteriorCommand() { return std::make_unique<ExteriorCommand>(); }

}  // namespace orient
