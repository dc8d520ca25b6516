// orient block: from scans to an oriented block, in one command.
#include <CLI/CLI.hpp>
#include <filesystem>
#include <ostream>

#include "core/error.h"
#include "core/files/block_file.h"
#include "core/files/orientation_table.h"
#include "tools/block/block_run.h"
#include "tools/camera_library.h"
#include "tools/commands.h"
#include "tools/convert/convert_source.h"
#include "tools/exterior_learning.h"
#include "tools/exterior_summary.h"
#include "tools/shared_options.h"
#include "tools/summary_table.h"

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
    app.add_flag("--quicklook", quicklook_,
                 "Also draw reduced orthophotos and the seams between them");
    AddCameraLibraryOption(app, &library_);
    AddJobsOption(app, &jobs_);
  }

  ExitCode Run(std::ostream& out) override {
    BlockRunOptions options{.block = ReadBlockFile(block_path_)};
    CheckFormats(options.block.formats);
    options.block.camera = FindCameraFile(options.block.camera, library_);
    options.feedback = !no_feedback_;
    options.quicklook = quicklook_;
    options.jobs = jobs_;
    const std::string& directory = options.block.output_directory;
    options.resume = !overwrite_ && (resume_ || IsUnfinished(directory));
    if (plan_) {
      for (const std::string& line : PlanBlock(options)) out << line << "\n";
      return ExitCode::kAllDone;
    }
    RefuseToOverwrite(Results(options.block), overwrite_ || options.resume, "--resume");
    if (options.resume && !resume_)
      out << "goes on with the interrupted run in " << directory << "\n";
    for (const UnusablePhoto& photo : options.block.unusable)
      out << "cannot  " << photo.name << ": " << photo.reason << "\n";
    if (options.feedback) BringUpToDateForFeedback(options.block.patchdb, out);
    const BlockRunResult result = RunBlock(options);
    PrintExteriorSummary(result.results, out);
    PrintBlockSummary(result, out);
    out << "\nreport  " << fs::absolute(fs::path(directory) / "report.html").string() << "\n";
    return AllOriented(result.results) && result.not_there.empty() ? ExitCode::kAllDone
                                                                   : ExitCode::kSomeNotOriented;
  }

 private:
  // Before the work, not after it.
  void CheckFormats(const std::vector<std::string>& formats) const {
    for (const std::string& format : formats) {
      if (ExchangeFormatFromName(format)) continue;
      std::string message = block_path_;
      message.append(": output.formats has \"").append(format).append("\"; what can be written is");
      for (const ExchangeFormat one : kAllExchangeFormats)
        message.append(" ").append(orient::Name(one));
      throw InputError(message);
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

  static void PrintBlockSummary(const BlockRunResult& result, std::ostream& out) {
    if (const auto& block = result.summary) {
      out << "\nblock   " << block->photos << " photos by " << block->ties << " tie points ("
          << block->sightings << " sightings, " << block->rejected << " rejected, sigma0 "
          << Fixed(block->tie_sigma0_px, 2) << " px)";
      if (block->by_neighbours > 0)
        out << ", " << block->by_neighbours << " of them without enough patches of their own";
      if (block->checks > 0)
        out << "\ncheck   " << block->checks << " patches held out, RMS "
            << Fixed(block->check_rms_px, 2) << " px";
      out << "\n";
    }
    if (const auto& quicklook = result.quicklook) {
      out << "seams   " << quicklook->Measured() << " of " << quicklook->seams.size()
          << " places between orthophotos measured";
      if (const auto shift = quicklook->MedianShiftPx())
        out << ", median shift " << Fixed(*shift, 2) << " px";
      out << "\n";
    }
    for (const std::string& message : result.messages) out << "note    " << message << "\n";
  }

  std::string block_path_, library_;
  bool resume_ = false;
  bool overwrite_ = false;
  bool plan_ = false;
  bool no_feedback_ = false;
  bool quicklook_ = false;
  int jobs_ = 0;
};

}  // namespace

std::unique_ptr<Command> MakeBlockCommand() { return std::make_unique<BlockCommand>(); }

}  // namespace orient
