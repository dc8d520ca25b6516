// orient block: from scans to an oriented block, in one command.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <ostream>

#include "core/files/block_file.h"
#include "core/files/camera_file.h"
#include "core/files/orientation_table.h"
#include "tools/block_geopackage.h"
#include "tools/camera_library.h"
#include "tools/commands.h"
#include "tools/exterior_run.h"
#include "tools/exterior_summary.h"
#include "tools/interior_run.h"
#include "tools/progress.h"
#include "tools/report/report.h"
#include "tools/shared_options.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

class BlockCommand : public Command {
 public:
  std::string Name() const override { return "block"; }
  std::string Summary() const override {
    return "Orient a block: interior, exterior, report, in one command";
  }

  void Setup(CLI::App& app) override {
    app.add_option("BLOCK", block_path_, "Block file (TOML)")->required();
    app.add_flag("--resume", resume_, "Keep the results that are there, do the others");
    AddOverwriteOption(app, &overwrite_);
    app.add_flag("--plan", plan_, "Print what would be done and stop");
    app.add_flag("--no-feedback", no_feedback_,
                 "Do not tell the patch database which patches were found");
    AddCameraLibraryOption(app, &library_);
    AddJobsOption(app, &jobs_);
  }

  ExitCode Run(std::ostream& out) override {
    BlockFile block = ReadBlockFile(block_path_);
    block.camera = FindCameraFile(block.camera, library_);
    const bool film = ReadCameraFile(block.camera).camera.kind == CameraKind::kFilm;
    if (plan_) {
      PrintPlan(block, film, out);
      return ExitCode::kAllDone;
    }
    RefuseToOverwrite(Results(block, film), overwrite_ || resume_, "--resume");
    MakeOutputDirectory(block.output_directory);
    if (film) OrientInteriors(block);
    const std::vector<ExteriorResult> results = OrientExteriors(block, film);
    WriteBlockGeopackage(block.output_directory, block.crs, results);
    const std::string report = WriteReport(block.output_directory);
    PrintExteriorSummary(results, out);
    out << "\nreport  " << fs::absolute(report).string() << "\n";
    return AllOriented(results) ? ExitCode::kAllDone : ExitCode::kSomeNotOriented;
  }

 private:
  static std::vector<std::string> Results(const BlockFile& block, bool film) {
    std::vector<std::string> results;
    for (const std::string& photo : block.photos) {
      if (film) results.push_back(InteriorResultPath(block.output_directory, PhotoName(photo)));
      results.push_back(ExteriorResultPath(block.output_directory, PhotoName(photo)));
    }
    return results;
  }

  void OrientInteriors(const BlockFile& block) const {
    InteriorRunOptions options;
    options.photos = block.photos;
    options.camera = block.camera;
    options.out = block.output_directory;
    options.scan = {block.pixel_size_um, block.polarity, block.orientation};
    options.resume = resume_;
    options.jobs = jobs_;
    Progress progress("interior orientation", static_cast<int>(block.photos.size()));
    RunInterior(options, [&] { progress.Advance(); });
  }

  std::vector<ExteriorResult> OrientExteriors(const BlockFile& block, bool film) const {
    ExteriorRunOptions options;
    options.photos = block.photos;
    options.camera = block.camera;
    options.approximations = block.approximations;
    options.dem = block.dem;
    options.patchdb = block.patchdb;
    options.out = block.output_directory;
    if (film) options.interior = block.output_directory;
    options.crs = block.crs;
    options.position_sigma_m = block.position_sigma_m;
    options.attitude_sigma_rad = block.attitude_sigma_rad;
    options.feedback = !no_feedback_;
    options.resume = resume_;
    options.jobs = jobs_;
    Progress progress("exterior orientation", static_cast<int>(block.photos.size()));
    return RunExterior(options, [&](const ExteriorResult&) { progress.Advance(); });
  }

  void PrintPlan(const BlockFile& block, bool film, std::ostream& out) const {
    const auto there = [&](const std::string& path) { return resume_ && fs::exists(path); };
    for (const std::string& photo : block.photos) {
      const std::string name = PhotoName(photo);
      if (film)
        out << (there(InteriorResultPath(block.output_directory, name)) ? "keep  " : "do    ")
            << "interior  " << name << "\n";
      out << (there(ExteriorResultPath(block.output_directory, name)) ? "keep  " : "do    ")
          << "exterior  " << name << "\n";
    }
    out << "do    write     " << block.output_directory
        << "/orientation.csv, block.gpkg, report.html\n";
  }

  std::string block_path_, library_;
  bool resume_ = false;
  bool overwrite_ = false;
  bool plan_ = false;
  bool no_feedback_ = false;
  int jobs_ = 0;
};

}  // namespace

std::unique_ptr<Command> MakeBlockCommand() { return std::make_unique<BlockCommand>(); }

}  // namespace orient
