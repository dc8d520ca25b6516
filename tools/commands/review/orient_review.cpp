// orient review: a page on this machine for looking at photos and saying what they show.
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdlib>
#include <filesystem>
#include <ostream>
#include <sstream>

#include "block/block.h"
#include "block/inputs/block_files.h"
#include "block/inputs/camera_library.h"
#include "block/stages/exterior_stage.h"
#include "block/stages/interior_stage.h"
#include "core/base/error.h"
#include "core/files/block_file.h"
#include "tools/commands/block_control.h"
#include "tools/commands/block_outputs.h"
#include "tools/commands/commands.h"
#include "tools/commands/exterior_options.h"
#include "tools/commands/patchdb_to_write.h"
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

class ReviewCommand : public Command {
 public:
  std::string Name() const override { return "review"; }
  std::string Summary() const override {
    return "Look at photos in the browser; measure marks and points, decide, orient again";
  }

  void Setup(CLI::App& app) override {
    app.add_option("OUT", options_.directory, "Output folder of orient interior, exterior or block")
        ->required();
    app.add_option("PHOTO", patterns_, "Scans or globs; with --block those of the block file");
    app.add_option("--block", block_path_,
                   "Block file (TOML) that OUT was made from; needed for orienting again");
    app.add_option(
        "--measurements", measurements_,
        "Folder for what is said (marks.csv ...), made where it is not there; by default "
        "that of the block file");
    app.add_option("--ortho", options_.ortho, "Orthophoto under the map, in the block's CRS");
    app.add_option("--dem", options_.dem,
                   "Ground heights, for points clicked in the map and for orienting again; by "
                   "default the block file's");
    app.add_option("--camera", options_.camera,
                   "Camera file (TOML) or a name from the camera library: shows where marks and "
                   "frame are expected, and orients photos of orient interior and exterior again; "
                   "by default the block file's");
    AddScanOptions(app, &scan_);
    exterior_.Setup(app);
    app.add_option("--by", by_, "Who says it, as the files record it (default: the user's name)");
    app.add_option("--port", port_, "Port on 127.0.0.1; 0: one that is free")
        ->check(CLI::Range(0, 65535))
        ->capture_default_str();
    app.add_flag("--open", open_, "Open the page in the browser");
    AddLearnOption(app, &learn_);
    AddCameraLibraryOption(app, &library_);
    AddJobsOption(app, &jobs_);
  }

  ExitCode Run(std::ostream& out) override {
    if (!block_path_.empty()) {
      if (scan_.pixel_size_um || scan_.polarity || scan_.orientation || exterior_.AnyTold())
        throw UsageError(
            "what the runs were told of photos is the block file's with --block: "
            "leave out --pixel-size-um, --approximations, --patchdb and the like");
      TakeFromBlock(out);
    } else {
      options_.scan = {scan_.pixel_size_um, scan_.polarity, scan_.orientation, {}};
    }
    for (const std::string& photo : ExpandPhotos(patterns_, "")) options_.scans.push_back(photo);
    if (measurements_.empty())
      throw UsageError(
          "where shall it be written what is said? Give --measurements DIR, or a block file with "
          "measurements = \"DIR\"");
    // Runs write a table of marks to OUT that has the name of the measured ones.
    if (fs::weakly_canonical(measurements_) == fs::weakly_canonical(options_.directory))
      throw UsageError("--measurements must not be " + options_.directory +
                       " itself: runs write their own marks.csv there; name another folder");
    if (!options_.camera.empty())
      options_.camera = block::FindCameraFile(options_.camera, library_);
    if (!options_.run_again) OfferStages();
    options_.measurements = measurements_;
    const char* user = std::getenv("USER");
    options_.by = by_ ? *by_ : user == nullptr ? "" : user;
    Review review(options_);
    ServeReview(&review, port_, [&](const std::string& address) {
      out << "review  " << address << std::endl;  // whoever waits for it reads it now
      if (open_) OpenInBrowser(address);
    });
    return ExitCode::kAllDone;
  }

 private:
  // Doing again in a folder of orient interior or exterior, where enough is known for it.
  void OfferStages() {
    if (!exterior_.PatchDatabase().empty()) {
      if (options_.camera.empty() || options_.scans.empty() || options_.dem.empty())
        throw UsageError("with --patchdb photos are oriented again: name scans, --camera, --dem");
      options_.run_again = [this](ProgressListener* listener) { OrientPhotosAgain(listener); };
    } else if (!options_.camera.empty() && !options_.scans.empty()) {
      options_.run_again = [this](ProgressListener* listener) { MeasureAgain(listener); };
    }
  }

  void TakeFromBlock(std::ostream& out) {
    BlockFile block = ReadBlockFile(block_path_);
    if (block.ByMeasurementsAlone())
      throw UsageError(block_path_ +
                       " has no photos to look at: it is adjusted by image measurements alone");
    std::error_code ignored;
    if (!fs::equivalent(block.output_directory, options_.directory, ignored))
      throw UsageError(fmt::format("{} writes to {}, not to {}; name the block file of OUT",
                                   block_path_, block.output_directory, options_.directory));
    if (measurements_.empty()) measurements_ = block.measurements;
    if (!block.measurements.empty() &&
        fs::weakly_canonical(measurements_) != fs::weakly_canonical(block.measurements))
      throw UsageError(fmt::format("{} takes its measurements from {}; leave out --measurements {}",
                                   block_path_, block.measurements, measurements_));
    if (block.measurements.empty() && !measurements_.empty())
      out << fmt::format(
          "note    orient block does not read {}; write measurements = \"{}\" in {}\n",
          measurements_, fs::absolute(measurements_).string(), block_path_);
    if (options_.dem.empty()) options_.dem = block.dem;
    if (options_.camera.empty()) options_.camera = block.camera;
    options_.scan = {block.pixel_size_um, block.polarity, block.orientation, {}};
    if (patterns_.empty()) options_.scans = block.photos;
    options_.run_again = [this](ProgressListener* listener) { OrientAgain(listener); };
  }

  // As orient block --resume does: of what the word concerns, all is done again, of the rest
  // nothing but what follows from it.
  void OrientAgain(ProgressListener* listener) const {
    block::BlockRunOptions options{.block = ReadBlockFile(block_path_), .resume = true};
    options.block.camera = block::FindCameraFile(options.block.camera, library_);
    if (!FindBlockControl(library_, &options.block))
      throw InputError(options.block.patchdb + " is not there: run orient block first");
    options.block.measurements = SaidNothing() ? "" : measurements_;
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

  // As orient interior --resume does.
  void MeasureAgain(ProgressListener* listener) const {
    block::InteriorRunOptions options;
    options.photos = options_.scans;
    options.camera = options_.camera;
    options.out = options_.directory;
    options.scan.pixel_size_um = scan_.pixel_size_um;
    options.scan.polarity = scan_.polarity;
    options.scan.orientation = scan_.orientation;
    if (!SaidNothing()) options.measurements = ReadMeasurements(measurements_);
    options.resume = true;
    options.jobs = jobs_;
    options.roll_lies_alike = true;
    ProgressTask progress(listener, "interior orientation",
                          static_cast<int>(options.photos.size()));
    block::RunInterior(options, [&] { progress.Advance(); });
  }

  // As orient exterior --resume does, and before it orient interior where both have one folder.
  void OrientPhotosAgain(ProgressListener* listener) const {
    const Measurements said = SaidNothing() ? Measurements() : ReadMeasurements(measurements_);
    block::ExteriorRunOptions options = exterior_.For(said);
    options.photos = options_.scans;
    options.camera = options_.camera;
    options.dem = options_.dem;
    options.out = options_.directory;
    options.learn = learn_;
    options.resume = true;
    options.jobs = jobs_;
    RefuseToReplace(options, false);
    std::error_code ignored;
    if (options.interior && fs::equivalent(*options.interior, options.out, ignored))
      MeasureAgain(listener);
    std::ostringstream unheard;
    if (options.learn) BringUpToDateToLearn(options.patchdb, unheard);
    ProgressTask progress(listener, "exterior orientation",
                          static_cast<int>(options.photos.size()));
    block::RunExterior(options, [&] { progress.Advance(); });
  }

  // A folder without any of the files is an error to whoever reads it.
  bool SaidNothing() const {
    for (const char* file : {kMarksFile, kImagePointsFile, kPointsFile, kDecisionsFile})
      if (fs::exists(fs::path(measurements_) / file)) return false;
    return true;
  }

  ReviewOptions options_;
  std::vector<std::string> patterns_;
  std::string block_path_, measurements_, library_;
  ScanOptions scan_;
  ExteriorOptions exterior_;
  std::optional<std::string> by_;
  int port_ = 0;
  int jobs_ = 0;
  bool open_ = false;
  bool learn_ = false;
};

}  // namespace

std::unique_ptr<Command> MakeReviewCommand() { return std::make_unique<ReviewCommand>(); }

}  // namespace orient
