// orient block: from scans to an oriented block, in one command.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <ostream>

#include "block/block.h"
#include "block/inputs/camera_library.h"
#include "block/plan.h"
#include "core/base/error.h"
#include "core/files/block_file.h"
#include "core/files/orientation_table.h"
#include "tools/commands/block/block_control.h"
#include "tools/commands/block/measured_block.h"
#include "tools/commands/block_outputs.h"
#include "tools/commands/commands.h"
#include "tools/commands/exterior_summary.h"
#include "tools/commands/ortho_run.h"
#include "tools/commands/patchdb_to_write.h"
#include "tools/commands/progress.h"
#include "tools/commands/shared_options.h"
#include "tools/commands/summary_table.h"
#include "tools/convert/convert_source.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

class BlockCommand : public Command {
 public:
  std::string Name() const override { return "block"; }
  std::string Summary() const override {
    return "Orient a block in one command: interior, exterior, adjustment, report";
  }

  void Setup(CLI::App& app) override {
    app.add_option("BLOCK", block_path_, "Block file (TOML)")->required();
    app.add_flag("--resume", resume_, "Keep existing results and do the others");
    AddOverwriteOption(app, &overwrite_);
    app.add_flag("--plan", plan_, "Print what would be done and stop");
    AddLearnOption(app, &learn_);
    app.add_flag("--quicklook", quicklook_,
                 "Also draw reduced orthophotos and the seams between them");
    AddCameraLibraryOption(app, &library_);
    AddJobsOption(app, &jobs_);
  }

  ExitCode Run(std::ostream& out) override {
    block::BlockRunOptions options{.block = ReadBlockFile(block_path_)};
    CheckFormats(options.block.formats);
    options.block.camera = block::FindCameraFile(options.block.camera, library_);
    if (options.block.ByMeasurementsAlone())
      return AdjustMeasuredBlock(options.block, overwrite_ || resume_, out);
    options.learn = learn_;
    options.jobs = jobs_;
    const std::string& directory = options.block.output_directory;
    options.resume = !overwrite_ && (resume_ || block::IsUnfinished(directory));
    if (plan_ && NeedsBlockControl(options.block)) {
      out << "control  " << options.block.patchdb
          << " is made first; the plan for the photos depends on it\n";
      return ExitCode::kAllDone;
    }
    if (plan_) {
      for (const std::string& line : PlanBlock(block::BlockInputs(options))) out << line << "\n";
      return ExitCode::kAllDone;
    }
    RefuseToOverwrite(Results(options.block), overwrite_ || options.resume, "--resume");
    if (options.resume && !resume_) out << "continues the interrupted run in " << directory << "\n";
    for (const UnusablePhoto& photo : options.block.unusable)
      out << "cannot  " << photo.name << ": " << photo.reason << "\n";
    MakeBlockControl(options.block, library_, out);
    if (options.learn) BringUpToDateToLearn(options.block.patchdb, out);
    const block::BlockInputs inputs(options);
    const block::BlockFolder folder(directory, options.resume);
    ShownProgress progress;
    block::OrientedBlock result = block::Orient(inputs, folder, &progress);
    RecordRun(
        Invoked(), directory, "block",
        {FileInput("block file", block_path_), FileInput("camera", options.block.camera),
         RasterInput("DEM", options.block.dem), FileInput("patch database", options.block.patchdb),
         FileInput("approximations", options.block.approximations)});
    const auto quicklook = WriteBlockOutputs(options.block, quicklook_, &result);
    PrintExteriorSummary(result.results, out);
    PrintBlockSummary(result, quicklook, out);
    MakeOrthophotosOf(options.block, out);
    folder.Finish();
    out << "\nreport  " << fs::absolute(fs::path(directory) / "report.html").string() << "\n";
    return AllOriented(result.results) && result.not_there.empty() ? ExitCode::kAllDone
                                                                   : ExitCode::kSomeNotOriented;
  }

 private:
  void MakeOrthophotosOf(const BlockFile& block, std::ostream& out) const {
    if (!block.ortho) return;
    out << "\n";
    OrthoRunOptions run{.source = {.poses = block.output_directory,
                                   .scans = block.photos,
                                   .dem = block.dem,
                                   .weak = block.ortho->weak},
                        .out = (fs::path(block.output_directory) / "ortho").string(),
                        .gsd_m = block.ortho->gsd_m,
                        .dem_sigma_m = block.ortho->dem_sigma_m,
                        .jobs = jobs_,
                        .mosaic = block.ortho->mosaic,
                        .overwrite = overwrite_,
                        .resume = !overwrite_};
    try {
      MakeOrthophotos(run, out);
    } catch (const InputError& error) {
      throw InputError(
          fmt::format("the block is done and written to {}, but not its orthophotos: {}",
                      block.output_directory, error.what()));
    }
  }

  // Before the work, not after it.
  void CheckFormats(const std::vector<std::string>& formats) const {
    for (const std::string& format : formats) {
      if (ExchangeFormatFromName(format)) continue;
      std::string known;
      for (const ExchangeFormat one : kAllExchangeFormats) known += " " + orient::Name(one);
      throw InputError(fmt::format("{}: output.formats has \"{}\"; the formats are{}", block_path_,
                                   format, known));
    }
  }

  static std::vector<std::string> Results(const BlockFile& block) {
    std::vector<std::string> results;
    for (const std::string& photo : block.photos) {
      results.push_back(InteriorResultPath(block.output_directory, PhotoName(photo)));
      results.push_back(ExteriorResultPath(block.output_directory, PhotoName(photo)));
    }
    for (const UnusablePhoto& photo : block.unusable)
      results.push_back(ExteriorResultPath(block.output_directory, photo.name));
    // Of another block's photos, perhaps.
    for (const char* file : {"orientation.csv", "block.json", "block.gpkg"})
      results.push_back((fs::path(block.output_directory) / file).string());
    return results;
  }

  static void PrintBlockSummary(const block::OrientedBlock& result,
                                const std::optional<block::Quicklook>& quicklook,
                                std::ostream& out) {
    if (const auto& block = result.summary) {
      out << "\nblock   " << block->photos << " photos by " << block->ties << " tie points ("
          << block->sightings << " observations, " << block->rejected << " rejected, sigma0 "
          << Fixed(block->tie_sigma0_px, 2) << " px)";
      if (block->by_neighbours > 0)
        out << ", " << block->by_neighbours << " of them without enough patches of their own";
      if (block->checks > 0)
        out << "\ncheck   " << block->checks << " patches held out, RMS "
            << Fixed(block->check_rms_px, 2) << " px";
      out << "\n";
    }
    if (quicklook) {
      out << "seams   " << quicklook->Measured() << " of " << quicklook->seams.size()
          << " places along seams measured";
      if (const auto shift = quicklook->MedianShiftPx())
        out << ", median shift " << Fixed(*shift, 2) << " px";
      out << "\n";
    }
    for (const std::string& line : result.control_points) out << line << "\n";
    for (const std::string& message : Sentences(result.findings))
      out << "note    " << message << "\n";
  }

  std::string block_path_, library_;
  bool resume_ = false;
  bool overwrite_ = false;
  bool plan_ = false;
  bool learn_ = false;
  bool quicklook_ = false;
  int jobs_ = 0;
};

}  // namespace

std::unique_ptr<Command> MakeBlockCommand() { return std::make_unique<BlockCommand>(); }

}  // namespace orient
