// orient block: from scans to an oriented block, in one command.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <ostream>

#include "block/block.h"
#include "block/inputs/block_files.h"
#include "block/inputs/camera_library.h"
#include "block/part.h"
#include "block/plan.h"
#include "block/stages/exterior_stage.h"
#include "core/base/atomic_write.h"
#include "core/base/error.h"
#include "core/files/block_file.h"
#include "core/files/camera_file.h"
#include "core/files/orientation_table.h"
#include "tools/commands/block/block_metrics.h"
#include "tools/commands/block/measured_block.h"
#include "tools/commands/block_control.h"
#include "tools/commands/block_outputs.h"
#include "tools/commands/commands.h"
#include "tools/commands/exterior_summary.h"
#include "tools/commands/ortho_run.h"
#include "tools/commands/patchdb_to_write.h"
#include "tools/commands/progress.h"
#include "tools/commands/shared_options.h"
#include "tools/commands/summary_table.h"
#include "tools/convert/convert_source.h"
#include "tools/report/gis/block_project.h"

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
    AddPlanOption(app, &plan_);
    app.add_option("--stage", stage_,
                   "Only this stage, for runs that share the work: control, interior, exterior")
        ->check(CLI::IsMember({"control", "interior", "exterior"}));
    app.add_option("--part", part_, "The K-th of N parts of the stage's photos, as K/N");
    app.add_flag("--status", status_, "Print what is done, and what is left, and stop");
    app.add_option("--metrics", metrics_,
                   "With --status: also write it for a monitor (Prometheus text format)");
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
    RequireOptionsTogether(options.block);
    if (status_) return PrintStatus(options.block, out);
    RequireInputsApart(options.block, block_path_);
    if (options.block.ByMeasurementsAlone())
      return AdjustMeasuredBlock(options.block,
                                 {Invoked(), block_path_, resume_, overwrite_, plan_}, out);
    options.learn = learn_;
    options.jobs = jobs_;
    if (!stage_.empty()) return RunStage(std::move(options), out);
    const std::string& directory = options.block.output_directory;
    options.resume = !overwrite_ && (resume_ || block::IsUnfinished(directory));
    RefuseToOverwrite(Results(options.block), overwrite_ || options.resume, "--resume");
    const bool has_control = FindControlOrCheckTheRest(&options);
    if (plan_ && !has_control) {
      out << "control  " << options.block.patchdb
          << " is made first; the plan for the photos depends on it\n";
      return ExitCode::kAllDone;
    }
    if (plan_) {
      for (const std::string& line : PlanBlock(block::BlockInputs(options))) out << line << "\n";
      return ExitCode::kAllDone;
    }
    for (const UnusablePhoto& photo : options.block.unusable)
      out << "cannot  " << photo.name << ": " << photo.reason << "\n";
    if (!has_control) MakeBlockControl(library_, options.block, out);
    if (options.learn) BringUpToDateToLearn(options.block.patchdb, out);
    const block::BlockInputs inputs(options);
    const block::BlockFolder folder(directory, options.resume);
    if (options.resume && !resume_) out << "continues the interrupted run in " << directory << "\n";
    ShownProgress progress;
    block::OrientedBlock result = block::Orient(inputs, folder, &progress);
    RecordRun(Invoked(), directory, "block", RecordedInputs(options.block));
    const auto quicklook = WriteBlockOutputs(options.block, quicklook_, &result);
    PrintExteriorSummary(result.results, out);
    PrintBlockSummary(result, quicklook, out);
    MakeOrthophotosOf(options.block, out);
    if (options.block.ortho) WriteBlockReport(options.block, result);
    WriteBlockProject(directory);
    folder.Finish();
    out << "\nreport  " << fs::absolute(fs::path(directory) / "report.html").string() << "\n";
    return AllOriented(result.results) && result.not_there.empty() ? ExitCode::kAllDone
                                                                   : ExitCode::kSomeNotOriented;
  }

 private:
  // As FindBlockControl; before a harvest, which takes long, checks what would stop the run later.
  bool FindControlOrCheckTheRest(block::BlockRunOptions* options) const {
    if (FindBlockControl(library_, &options->block)) return true;
    const block::BlockInputs checked(*options, block::Patches::kToBeMade);
    return false;
  }

  std::vector<RunInput> RecordedInputs(const BlockFile& block) const {
    std::vector<RunInput> inputs = {FileInput("block file", block_path_),
                                    FileInput("camera", block.camera),
                                    RasterInput("DEM", block.dem), PatchesInput(block.patchdb),
                                    FileInput("approximations", block.approximations)};
    if (!block.control) return inputs;
    for (const std::string& path : block.control->orthophotos)
      inputs.push_back(RasterInput("control orthophoto", path));
    for (const std::string& path : block.control->photos)
      inputs.push_back(FileInput("control photo", path));
    inputs.push_back(FileInput("control orientation", block.control->orientation));
    if (!block.control->dsm.empty()) inputs.push_back(RasterInput("DSM", block.control->dsm));
    return inputs;
  }

  void RequireOptionsTogether(const BlockFile& block) const {
    const auto refuse = [](const std::string& why) { throw UsageError(why); };
    if (!part_.empty() && stage_.empty()) refuse("--part needs --stage");
    if (!metrics_.empty() && !status_) refuse("--metrics needs --status");
    if (status_ && (!stage_.empty() || overwrite_ || plan_ || learn_ || quicklook_))
      refuse("--status prints and stops; give it alone");
    if (block.ByMeasurementsAlone() && (learn_ || quicklook_))
      refuse(block_path_ + " names no photos; --learn and --quicklook are for blocks of photos");
    if (stage_.empty() && !status_) return;
    if (block.ByMeasurementsAlone())
      refuse(block_path_ + " names no photos; --stage and --status are for blocks of photos");
    if (overwrite_ || plan_ || learn_ || quicklook_)
      refuse("--stage goes with none of --overwrite, --plan, --learn, --quicklook");
    if (stage_ == "control" && !block.control)
      refuse(block_path_ + " has no [control] that --stage control could make");
    if (stage_ == "control" && !part_.empty()) refuse("--stage control has no parts");
  }

  ExitCode RunStage(block::BlockRunOptions options, std::ostream& out) const {
    const auto part = part_.empty() ? block::PhotosOfPart() : block::PhotosOfPartFromText(part_);
    if (!part)
      throw UsageError(fmt::format("--part is {}; it must be K/N, with K from 1 to N", part_));
    if (stage_ == "control") {
      if (FindControlOrCheckTheRest(&options))
        out << options.block.patchdb << " is there\n";
      else
        MakeBlockControl(library_, options.block, out);
      return ExitCode::kAllDone;
    }
    if (!FindBlockControl(library_, &options.block))
      throw UsageError(options.block.patchdb + " is not there yet: run --stage control first");
    const std::string& directory = options.block.output_directory;
    // Runs of parts do not write these files.
    if (!resume_ && !block::IsUnfinished(directory))
      RefuseToOverwrite(Tables(directory), false, "--resume");
    options.resume = true;
    const block::BlockInputs inputs(options);
    // The photos of a roll are compared by one run at a time.
    return part->IsAll() ? RunPart(inputs, block::BlockFolder(directory, true), *part, out)
                         : RunPart(inputs, block::BlockFolder(directory), *part, out);
  }

  // The stage's part; the run of the whole block takes over what it leaves.
  ExitCode RunPart(const block::BlockInputs& inputs, const block::BlockFolder& folder,
                   const block::PhotosOfPart& part, std::ostream& out) const {
    ShownProgress progress;
    const auto stage =
        stage_ == "interior" ? block::BlockStage::kInterior : block::BlockStage::kExterior;
    const block::PartOutcome outcome = block::RunPart(inputs, folder, stage, part, &progress);
    if (part.IsAll()) RecordRun(Invoked(), folder.Directory(), stage_, {});
    out << fmt::format("{}{}: {} done, {} of them failed", stage_, part.IsAll() ? "" : " " + part_,
                       outcome.done, outcome.failed);
    if (outcome.left == 0) {
      out << "\n";
      return ExitCode::kAllDone;
    }
    out << fmt::format(
        "; {} wait for photos of other parts: run this part again when those are "
        "done\n",
        outcome.left);
    return ExitCode::kSomeNotOriented;
  }

  ExitCode PrintStatus(const BlockFile& block, std::ostream& out) const {
    const bool film = ReadCameraFile(block.camera).camera.kind == CameraKind::kFilm;
    SummaryTable table(
        {"stage", "photos", "ok", "weak", "failed", "left", "per hour", "hours to go"});
    const std::vector<block::StageStatus> stages =
        block::StatusOf(block.photos, block.output_directory, film);
    for (const block::StageStatus& status : stages) {
      std::string per_hour = "-", hours = "-";
      if (status.per_hour) {
        per_hour = Fixed(*status.per_hour, 0);
        hours = Fixed(static_cast<double>(status.Left()) / *status.per_hour, 2);
      }
      table.AddRow({block::Name(status.stage), std::to_string(status.photos),
                    std::to_string(status.ok), std::to_string(status.weak),
                    std::to_string(status.failed + status.unreadable),
                    std::to_string(status.Left()), per_hour, hours});
    }
    table.Print(out);
    const bool finished = fs::exists(block::PoseTablePath(block.output_directory)) &&
                          !block::IsUnfinished(block.output_directory);
    if (!metrics_.empty()) WriteMetrics(metrics_, stages, finished);
    out << (finished ? "finished\n"
                     : "not finished: orient block without --stage adjusts and writes the rest\n");
    return ExitCode::kAllDone;
  }

  [[noreturn]] static void ThrowWithoutOrthophotos(const BlockFile& block,
                                                   const std::exception& error) {
    throw InputError(fmt::format("the block is done and written to {}, but not its orthophotos: {}",
                                 block.output_directory, error.what()));
  }

  void MakeOrthophotosOf(const BlockFile& block, std::ostream& out) const {
    if (!block.ortho) return;
    out << "\n";
    OrthoRunOptions run{.source = {.poses = block.output_directory,
                                   .scans = block.photos,
                                   .dem = block.dem,
                                   .weak = block.ortho->weak},
                        .out = (fs::path(block.output_directory) / "ortho").string(),
                        .inputs = {FileInput("poses", block::PoseTablePath(block.output_directory)),
                                   RasterInput("DEM", block.dem)},
                        .gsd_m = block.ortho->gsd_m,
                        .dem_sigma_m = block.ortho->dem_sigma_m,
                        .jobs = jobs_,
                        .mosaic = block.ortho->mosaic,
                        .least_difference = block.ortho->least_difference,
                        .balance = block.ortho->balance,
                        .overwrite = overwrite_,
                        .resume = !overwrite_};
    try {
      MakeOrthophotos(run, out);
      RecordRun(Invoked(), run.out, "ortho", run.inputs);
    } catch (const UsageError& error) {
      ThrowWithoutOrthophotos(block, error);
    } catch (const InputError& error) {
      ThrowWithoutOrthophotos(block, error);
    }
  }

  // Checked before the work, not after it.
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
    // They may be of another block's photos, or a person's.
    for (const std::string& file : block::BlockFiles(block.output_directory))
      results.push_back(file);
    return results;
  }

  // Files that only the run of a whole block writes.
  static std::vector<std::string> Tables(const std::string& directory) {
    std::vector<std::string> tables;
    for (const char* file : {"orientation.csv", "block.json", "block.gpkg"})
      tables.push_back((fs::path(directory) / file).string());
    return tables;
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
        out << "\ncheck   " << block->checks << " patches or points held out, RMS "
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

  std::string block_path_, library_, stage_, part_, metrics_;
  bool resume_ = false;
  bool overwrite_ = false;
  bool plan_ = false;
  bool status_ = false;
  bool learn_ = false;
  bool quicklook_ = false;
  int jobs_ = 0;
};

}  // namespace

std::unique_ptr<Command> MakeBlockCommand() { return std::make_unique<BlockCommand>(); }

}  // namespace orient
