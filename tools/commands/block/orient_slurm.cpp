// orient slurm: a block's stages as jobs of Slurm.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <ostream>
#include <utility>
#include <vector>

#include "block/inputs/camera_library.h"
#include "block/part.h"
#include "core/base/error.h"
#include "core/base/median.h"
#include "core/base/remote_files.h"
#include "core/files/block_file.h"
#include "core/files/camera_file.h"
#include "core/files/orientation_table.h"
#include "tools/cluster/job_scripts.h"
#include "tools/cluster/measured_job.h"
#include "tools/cluster/store_object.h"
#include "tools/commands/block_control.h"
#include "tools/commands/block_outputs.h"
#include "tools/commands/commands.h"
#include "tools/commands/shared_options.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

constexpr int kMostWhole_MB = 10'000'000;
constexpr int kMostTasks = 1000;      // of an array, as Slurm is set up by default
constexpr double kPart_s = 20 * 60;   // of work that a part is to hold
constexpr double kMargin = 3;         // resources requested, over those measured
constexpr std::size_t kMeasured = 2;  // photos

// Assumed if nothing was measured.
constexpr StageNeeds kUnknown = {60, 1500};

class SlurmCommand : public Command {
 public:
  std::string Name() const override { return "slurm"; }
  std::string Summary() const override {
    return "Write, and submit, the jobs that orient a block on a Slurm cluster";
  }

  void Setup(CLI::App& app) override {
    app.add_option("BLOCK", block_path_, "Block file (TOML)")->required();
    app.add_flag("--submit", submit_, "Also submit the jobs; with --engine local run them");
    app.add_option("--engine", engine_, "Where --submit runs the jobs")
        ->check(CLI::IsMember({"slurm", "local"}))
        ->capture_default_str();
    app.add_option("--parts", parts_,
                   "Tasks of a stage (default: so that each works for some twenty minutes)")
        ->check(CLI::Range(1, kMostTasks));
    app.add_option("--rounds", rounds_,
                   "Passes of exterior orientation over the photos before the whole block's "
                   "run (default: 1, or 3 for photos located by strips)")
        ->check(CLI::Range(1, 20));
    app.add_option("--cpus", jobs_.cpus, "Cores of the whole block's run")
        ->check(CLI::Range(1, 1024))
        ->capture_default_str();
    app.add_option("--time", minutes_, "Minutes that a task may take (default: as measured)")
        ->check(CLI::Range(1, 60 * 24 * 30));
    app.add_option("--memory", megabytes_, "Megabytes of a task (default: as measured)")
        ->check(CLI::Range(100, 1000000));
    app.add_option("--whole-time", whole_minutes_,
                   "Minutes of the jobs that concern all photos (default: by their number)")
        ->check(CLI::Range(1, 60 * 24 * 30));
    app.add_option(
           "--whole-memory", whole_megabytes_,
           "Megabytes of these jobs (default: by the number of photos and the size of their "
           "results)")
        ->check(CLI::Range(100, kMostWhole_MB));
    app.add_flag("--no-measure", no_measure_,
                 "Do not orient the first photos here to measure time and memory");
    app.add_option("--partition", jobs_.partition, "Slurm's partition");
    app.add_option("--account", jobs_.account, "Slurm's account");
    app.add_option("--upload", jobs_.place,
                   "Object storage for the output folder, uploaded at the end (orient upload)");
    AddLearnOption(app, &jobs_.learn);
    AddCameraLibraryOption(app, &library_);
    AddOverwriteOption(app, &overwrite_);
  }

  ExitCode Run(std::ostream& out) override {
    BlockFile block = ReadBlockFile(block_path_);
    if (block.ByMeasurementsAlone() || block.photos.empty())
      throw UsageError(block_path_ + " names no photos that jobs could share");
    for (const std::string* word : {&jobs_.partition, &jobs_.account})
      if (word->find_first_of(" \t\r\n") != std::string::npos)
        throw UsageError("'" + *word +
                         "' has blanks in it; give the name of a Slurm partition or account");
    if (!jobs_.place.empty() && !IsStore(GdalName(jobs_.place))) throw NoStore(jobs_.place);
    block.camera = block::FindCameraFile(block.camera, library_);
    jobs_.program = OwnProgram();
    jobs_.block = fs::absolute(block_path_).lexically_normal().string();
    jobs_.folder = (fs::absolute(block.output_directory) / kJobsFolder).lexically_normal().string();
    if (!library_.empty()) jobs_.camera_library = fs::absolute(library_).string();
    jobs_.control = block.control.has_value();
    jobs_.film = ReadCameraFile(block.camera).camera.kind == CameraKind::kFilm;
    jobs_.overwrite = overwrite_;
    constexpr int kRoundsOfStrips = 3;
    jobs_.rounds = rounds_.value_or(block.flight.Empty() ? 1 : kRoundsOfStrips);
    RequireInputsApart(block, block_path_);
    RefuseToOverwrite(JobScriptPaths(jobs_), overwrite_);
    AskFor(&block, out);
    for (const std::string& path : WriteJobScripts(jobs_)) out << path << "\n";
    return submit_ ? Submit(out) : ExitCode::kAllDone;
  }

 private:
  // Time and memory of a photo: measured now on two photos, or as measured before.
  StageNeeds Needs(const BlockFile& file, block::BlockStage stage, std::ostream& out) const {
    const auto before = ReadStageNeeds(jobs_.folder, block::Name(stage));
    if (before && !overwrite_) return Reported(stage, *before, "measured before", out);
    const bool asked = minutes_ && megabytes_ && parts_;
    const auto measured = asked || no_measure_ ? std::nullopt : Measure(file, stage);
    if (measured) return Reported(stage, *measured, "measured", out);
    if (before) return Reported(stage, *before, "measured before", out);
    return asked ? kUnknown : Reported(stage, kUnknown, "not measured, taken for", out);
  }

  static StageNeeds Reported(block::BlockStage stage, const StageNeeds& needs, const char* whence,
                             std::ostream& out) {
    out << fmt::format("{} orientation, {}: {:.1f} s a photo, {:.0f} MB\n", block::Name(stage),
                       whence, needs.seconds, needs.megabytes);
    return needs;
  }

  // Empty if no photo was done: they are done already, or wait for others.
  std::optional<StageNeeds> Measure(const BlockFile& file, block::BlockStage stage) const {
    const std::size_t parts = (file.photos.size() + kMeasured - 1) / kMeasured;
    const std::size_t before = Undone(file, stage, parts);
    if (before == 0) return std::nullopt;
    std::vector<std::string> words = {jobs_.program, "block", jobs_.block, "--stage",
                                      block::Name(stage)};
    words.insert(words.end(), {"--part", fmt::format("1/{}", parts), "--jobs", "1", "--quiet"});
    if (!library_.empty()) words.insert(words.end(), {"--camera-library", jobs_.camera_library});
    const MeasuredJob job = RunMeasured(words);
    if (job.exit_code != 0 && job.exit_code != static_cast<int>(ExitCode::kSomeNotOriented))
      throw InputError("the first photos cannot be oriented (see above): jobs would fail likewise");
    const std::size_t done = before - Undone(file, stage, parts);
    if (done == 0) return std::nullopt;
    const StageNeeds needs{job.seconds / static_cast<double>(done), job.megabytes};
    WriteStageNeeds(jobs_.folder, block::Name(stage), needs);
    return needs;
  }

  // Photos of the first of `parts` that have no result yet.
  static std::size_t Undone(const BlockFile& file, block::BlockStage stage, std::size_t parts) {
    std::size_t undone = 0;
    for (std::size_t i = 0; i < file.photos.size(); i += parts) {
      const std::string path =
          block::ResultPathOf(stage, file.output_directory, PhotoName(file.photos[i]));
      undone += fs::exists(path) ? 0 : 1;
    }
    return undone;
  }

  // Median size of the existing results of exterior orientation.
  static double MedianMegabytesOfResult(const BlockFile& file) {
    constexpr double kUsual_MB = 0.3;
    constexpr std::size_t kEnough = 100;
    std::vector<double> megabytes;
    for (const std::string& photo : file.photos) {
      std::error_code absent;
      const auto bytes = fs::file_size(block::ResultPathOf(block::BlockStage::kExterior,
                                                           file.output_directory, PhotoName(photo)),
                                       absent);
      if (!absent) megabytes.push_back(static_cast<double>(bytes) / 1e6);
      if (megabytes.size() == kEnough) break;
    }
    return megabytes.empty() ? kUsual_MB : Median(std::move(megabytes));
  }

  // Determines parts, times and memory to request.
  void AskFor(BlockFile* file, std::ostream& out) {
    const bool there = FindBlockControl(library_, file);
    StageNeeds interior{0, 0};
    if (jobs_.film) interior = Needs(*file, block::BlockStage::kInterior, out);
    const StageNeeds exterior = there ? Needs(*file, block::BlockStage::kExterior, out) : kUnknown;
    if (!there)
      out << "note      the control patches are made by the first job: exterior orientation was "
             "not measured\n";
    const auto photos = static_cast<double>(file->photos.size());
    const double slower = std::max(interior.seconds, exterior.seconds);
    const double of_part = std::clamp(kPart_s / slower, 1.0, photos);
    jobs_.parts = parts_.value_or(
        static_cast<int>(std::clamp(std::ceil(photos / of_part), 1.0, double{kMostTasks})));
    const double each = std::ceil(photos / jobs_.parts);
    const auto asked = [&](const StageNeeds& needs) {
      constexpr double kStart_min = 10, kStart_MB = 200, kMoreMemory = 1.5;
      return JobNeeds{
          minutes_.value_or(static_cast<int>(kStart_min + kMargin * each * needs.seconds / 60)),
          megabytes_.value_or(static_cast<int>(kStart_MB + kMoreMemory * needs.megabytes))};
    };
    jobs_.interior = asked(interior);
    jobs_.exterior = asked(exterior);
    // Memory of a photo: its points in the adjustment; its result, held by the run, the report and
    // block.gpkg.
    constexpr double kWhole_min = 60, kWhole_MB = 2000, kPoints_MB = 0.4, kResults = 3;
    const double photo_MB = kPoints_MB + kResults * MedianMegabytesOfResult(*file);
    const double most_MB = std::max(exterior.megabytes, interior.megabytes);
    const auto of_all = [&](double minutes) {
      const double megabytes = kWhole_MB + photo_MB * photos + jobs_.cpus * most_MB;
      return JobNeeds{
          whole_minutes_.value_or(static_cast<int>(kWhole_min + minutes)),
          whole_megabytes_.value_or(static_cast<int>(std::min<double>(megabytes, kMostWhole_MB)))};
    };
    // Ties take a photo about as long as its exterior orientation; the adjustment holds all of
    // them.
    jobs_.whole = of_all(kMargin * photos * exterior.seconds / 60 / jobs_.cpus);
    jobs_.roll = of_all(kMargin * each * interior.seconds / 60);  // and a part that was lost
    constexpr double kUploaded_min = 0.2;  // a photo's results, and its orthophoto's
    constexpr int kUpload_MB = 1000;       // each of the files sent at a time takes 50 MB
    jobs_.upload = {whole_minutes_.value_or(static_cast<int>(kWhole_min + kUploaded_min * photos)),
                    kUpload_MB};
  }

  ExitCode Submit(std::ostream& out) const {
    const std::string script =
        (fs::path(jobs_.folder) / (engine_ == "local" ? "local.sh" : "submit.sh")).string();
    out.flush();
    const MeasuredJob job = RunMeasured({"/bin/bash", script});
    if (job.exit_code != 0)
      throw InputError(
          engine_ == "local"
              ? fmt::format("a job of {} has failed (see above)", script)
              : fmt::format("{} could not submit all jobs (see above); none is left in "
                            "the queue",
                            script));
    return ExitCode::kAllDone;
  }

  std::string block_path_, engine_ = "slurm", library_;
  std::optional<int> parts_, rounds_, minutes_, megabytes_, whole_minutes_, whole_megabytes_;
  bool submit_ = false, no_measure_ = false, overwrite_ = false;
  BlockJobs jobs_;
};

}  // namespace

std::unique_ptr<Command> MakeSlurmCommand() { return std::make_unique<SlurmCommand>(); }

}  // namespace orient
