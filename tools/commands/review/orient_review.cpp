// orient review: a page on this machine for looking at photos and saying what they show.
#include <fmt/format.h>
#include <pwd.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdlib>
#include <filesystem>
#include <ostream>
#include <sstream>

#include "block/block.h"
#include "block/inputs/block_files.h"
#include "block/inputs/camera_library.h"
#include "core/base/error.h"
#include "core/files/block_file.h"
#include "tools/commands/block_control.h"
#include "tools/commands/block_outputs.h"
#include "tools/commands/commands.h"
#include "tools/commands/memory.h"
#include "tools/commands/patchdb_to_write.h"
#include "tools/commands/review/recorded_stages.h"
#include "tools/commands/shared_options.h"
#include "tools/review/server.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

// Shows the address in the person's browser; where there is none the printed address remains.
void OpenInBrowser(const std::string& address) {
  if (fork() != 0) return;
  execlp("xdg-open", "xdg-open", address.c_str(), nullptr);
  _exit(127);
}

// The account's name, which programs without a login session have as well.
std::string UserName() {
  if (const char* user = std::getenv("USER"); user != nullptr && *user != '\0') return user;
  const passwd* account = getpwuid(getuid());
  return account == nullptr ? std::to_string(getuid()) : account->pw_name;
}

class ReviewCommand : public Command {
 public:
  std::string Name() const override { return "review"; }
  std::string Summary() const override {
    return "Look at photos in the browser; measure marks and points, decide, orient again";
  }

  void Setup(CLI::App& app) override {
    app.add_option("OUT", options_.directory, "Output folder of orient interior, exterior or block")
        ->required();
    AddPhotosOption(app, &patterns_)->description("Scans or globs; by default those of the run");
    app.add_option("--block", block_path_,
                   "Block file (TOML) that OUT was made from; with it, photos of a block are "
                   "oriented again");
    app.add_option(
        "--measurements", measurements_,
        "Folder for measurements and decisions (marks.csv ...), created if missing; by default "
        "that of the run");
    app.add_option("--ortho", options_.ortho, "Orthophoto under the map, in the block's CRS");
    app.add_option("--dem", options_.dem,
                   "Heights of points clicked in the map; by default those of the run");
    app.add_option("--camera", options_.camera,
                   "Camera file (TOML) or a name from the camera library: shows where marks and "
                   "frame are expected; by default the run's");
    app.add_option("--by", by_, "Name recorded with each entry (default: the user's name)");
    app.add_option("--port", port_, "Port on 127.0.0.1; 0: one that is free")
        ->check(CLI::Range(0, 65535))
        ->capture_default_str();
    app.add_flag("--open", open_, "Open the page in the browser");
    AddLearnOption(app, &learn_);
    AddCameraLibraryOption(app, &library_);
    AddJobsOption(app, &jobs_);
  }

  ExitCode Run(std::ostream& out) override {
    constexpr int kCache_MB = 64;  // tiles of the scans are kept as the page shows them
    BoundBlockCache(kCache_MB);
    options_.scans = ExpandPhotos(patterns_, "");
    if (!block_path_.empty())
      TakeFromBlock(out);
    else
      TakeFromRecord();
    if (measurements_.empty())
      throw UsageError(
          "name the folder for measurements and decisions: --measurements DIR, or in the block "
          "file measurements = \"DIR\"");
    // Runs write a table of marks to OUT that has the name of the measured ones.
    if (fs::weakly_canonical(measurements_) == fs::weakly_canonical(options_.directory))
      throw UsageError("--measurements must not be " + options_.directory +
                       " itself: runs write their own marks.csv there; name another folder");
    if (!options_.camera.empty())
      options_.camera = block::FindCameraFile(options_.camera, library_);
    options_.measurements = measurements_;
    options_.by = by_ ? *by_ : UserName();
    Review review(options_);
    ServeReview(&review, port_, [&](const std::string& address) {
      out << "review  " << address << std::endl;  // flushed: whoever waits for it reads it now
      if (open_) OpenInBrowser(address);
    });
    return ExitCode::kAllDone;
  }

 private:
  void TakeFromBlock(std::ostream& out) {
    BlockFile block = ReadBlockFile(block_path_);
    if (block.ByMeasurementsAlone())
      throw UsageError(block_path_ +
                       " has no photos to look at: it is adjusted by image measurements alone");
    std::error_code ignored;
    if (!fs::equivalent(block.output_directory, options_.directory, ignored))
      throw UsageError(fmt::format("{} writes to {}, not to {}; name the block file of OUT",
                                   block_path_, block.output_directory, options_.directory));
    TakeMeasurementsOf(block_path_, block.measurements);
    if (block.measurements.empty() && !measurements_.empty())
      out << fmt::format(
          "note    orient block does not read {}; write measurements = \"{}\" in {}\n",
          measurements_, fs::absolute(measurements_).string(), block_path_);
    if (options_.dem.empty()) options_.dem = block.dem;
    if (options_.camera.empty()) options_.camera = block.camera;
    options_.scan = {block.pixel_size_um, block.polarity, block.orientation, {}};
    if (options_.scans.empty()) options_.scans = block.photos;
    options_.run_again = [this](ProgressListener* listener) { OrientAgain(listener); };
  }

  // If `run` reads measurements (`folder` is not empty), no other folder can be meant.
  void TakeMeasurementsOf(const std::string& run, const std::string& folder) {
    if (measurements_.empty()) measurements_ = folder;
    if (!folder.empty() && fs::weakly_canonical(measurements_) != fs::weakly_canonical(folder))
      throw UsageError(fmt::format("{} takes its measurements from {}; leave out --measurements {}",
                                   run, folder, measurements_));
  }

  // Takes the options of a folder of orient interior or exterior from its run.json.
  void TakeFromRecord() {
    stages_ = ReadRecordedStages(options_.directory);
    TakeMeasurementsOf(options_.directory, stages_.measurements);
    if (stages_.interior) {
      const interior::InteriorOptions& told = stages_.interior->scan;
      options_.scan = {told.pixel_size_um, told.polarity, told.orientation, {}};
      if (options_.scans.empty()) options_.scans = stages_.interior->photos;
      if (options_.camera.empty() && stages_.interior->camera != block::kAutoCamera)
        options_.camera = stages_.interior->camera;
    }
    if (stages_.exterior) {
      if (options_.scans.empty()) options_.scans = stages_.exterior->photos;
      if (options_.camera.empty()) options_.camera = stages_.exterior->camera;
      if (options_.dem.empty()) options_.dem = stages_.exterior->dem;
    }
    options_.why_not_again = stages_.why_not;
    if (stages_.why_not.empty())
      options_.run_again = [this](ProgressListener* listener) {
        const Measurements measurements =
            HasNoEntries() ? Measurements() : ReadMeasurements(measurements_);
        std::ostringstream unheard;
        if (learn_ && stages_.exterior) BringUpToDateToLearn(stages_.exterior->patchdb, unheard);
        DoAgain(stages_, measurements, learn_, jobs_, listener);
      };
  }

  // As orient block --resume does: everything that the new statements concern is done again, and of
  // the rest only what depends on it.
  void OrientAgain(ProgressListener* listener) const {
    block::BlockRunOptions options{.block = ReadBlockFile(block_path_), .resume = true};
    options.block.camera = block::FindCameraFile(options.block.camera, library_);
    if (!FindBlockControl(library_, &options.block))
      throw InputError(options.block.patchdb + " is not there: run orient block first");
    RequireInputsApart(options.block, block_path_);
    options.block.measurements = HasNoEntries() ? "" : measurements_;
    options.learn = learn_;
    options.jobs = jobs_;
    std::ostringstream unheard;
    if (options.learn) BringUpToDateToLearn(options.block.patchdb, unheard);
    const block::BlockInputs inputs(options);
    const block::BlockFolder folder(options.block.output_directory, true);
    block::OrientedBlock result = block::Orient(inputs, folder, listener);
    const bool quicklook =
        fs::exists(fs::path(options.block.output_directory) / block::kQuicklookFile);
    WriteBlockOutputs(options.block, quicklook, &result);
    folder.Finish();
  }

  // Whether nothing was stated yet: reading a folder without any of the files is an error.
  bool HasNoEntries() const {
    for (const char* file : {kMarksFile, kImagePointsFile, kPointsFile, kDecisionsFile})
      if (fs::exists(fs::path(measurements_) / file)) return false;
    return true;
  }

  ReviewOptions options_;
  std::vector<std::string> patterns_;
  std::string block_path_, measurements_, library_;
  RecordedStages stages_;
  std::optional<std::string> by_;
  int port_ = 0;
  int jobs_ = 0;
  bool open_ = false;
  bool learn_ = false;
};

}  // namespace

std::unique_ptr<Command> MakeReviewCommand() { return std::make_unique<ReviewCommand>(); }

}  // namespace orient
