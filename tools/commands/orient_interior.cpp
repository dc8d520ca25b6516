// orient interior: fiducial marks, and with them the transform from pixel to film.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <ostream>

#include "block/inputs/block_files.h"
#include "block/inputs/camera_library.h"
#include "block/inputs/measurement_inputs.h"
#include "block/roll/roll.h"
#include "block/stages/interior_stage.h"
#include "core/base/error.h"
#include "core/files/block_file.h"
#include "core/files/orientation_table.h"
#include "core/files/used_marks.h"
#include "tools/commands/commands.h"
#include "tools/commands/estimate_camera.h"
#include "tools/commands/progress.h"
#include "tools/commands/shared_options.h"
#include "tools/commands/stage_runs.h"
#include "tools/commands/summary_table.h"

namespace orient {
namespace {

// "r0", or that it is open.
std::string Orientation(const InteriorResult& result) {
  if (result.orientation) return std::string(orient::Name(*result.orientation));
  const size_t possible = result.possible_orientations.size();
  return possible == 0 ? "-" : fmt::format("open ({})", possible);
}

class InteriorCommand : public Command {
 public:
  std::string Name() const override { return "interior"; }
  std::string Summary() const override {
    return "Interior orientation: measure the fiducial marks, pixel to film";
  }

  void Setup(CLI::App& app) override {
    AddPhotosOption(app, &patterns_);
    app.add_option("--camera", camera_,
                   "Camera file (TOML), a name from the camera library, or auto: identify it")
        ->required();
    AddCameraLibraryOption(app, &library_);
    AddOutputOptions(app, &output_);
    app.add_flag("--resume", resume_, "Keep existing results and process the other photos");
    AddPlanOption(app, &plan_);
    AddScanOptions(app, &scan_);
    AddScannerOption(app);
    AddMeasurementsOption(app, &measurements_);
    app.add_option("--assignment", assignment_,
                   "How candidates are assigned to marks; softassign is the published method")
        ->check(CLI::IsMember({"exact", "softassign"}))
        ->capture_default_str();
    app.add_option("--locator", locator_, "How marks are located")
        ->check(CLI::IsMember({"auto", "hough", "ncc", "lines"}))
        ->capture_default_str();
    app.add_option("--roll", roll_,
                   "Whether all photos lay on the scanner the same way: if so they decide together "
                   "a scan orientation that single photos leave open")
        ->check(CLI::IsMember({"alike", "differing"}))
        ->capture_default_str();
    AddJobsOption(app, &jobs_);
    estimate_camera_.Setup(app);
    app.add_flag("--micmac", micmac_, "Also write the marks for MicMac (DIR/Ori-InterneScan)");
  }

  // What the command line asks for.
  block::InteriorRunOptions Options() const {
    block::InteriorRunOptions options;
    options.photos = PhotosOf(patterns_);
    options.camera =
        camera_ == block::kAutoCamera ? camera_ : block::FindCameraFile(camera_, library_);
    options.camera_library = library_;
    options.out = output_.directory;
    options.scan = {scan_.pixel_size_um, scan_.polarity, scan_.orientation, scanner_,
                    Locator(),           Assignment()};
    options.measurements = measurements_;
    options.resume = resume_;
    options.redo_changed = output_.overwrite;
    options.jobs = jobs_;
    options.micmac = micmac_;
    options.roll_lies_alike = roll_ == "alike";
    options.alone = true;
    return options;
  }

  ExitCode Run(std::ostream& out) override {
    if (estimate_camera_.Asked()) return estimate_camera_.Run(out);
    const block::InteriorRunOptions options = Options();
    RefuseToReplace(options);
    if (plan_) {
      PrintPlan("interior", options.photos, block::InteriorsThatStay(options), out);
      return ExitCode::kAllDone;
    }
    ProgressLine progress("interior orientation", static_cast<int>(options.photos.size()));
    std::vector<std::string> notes;
    const auto results = block::RunInterior(
        options, [&] { progress.Advance(); }, &notes);
    progress.Finish();
    RecordRun(Invoked(), options.out, "interior",
              {FileInput("camera", camera_ == block::kAutoCamera ? "" : options.camera)});
    const ExitCode code = Summarise(results, out);
    for (const std::string& note : notes) out << note << "\n";
    if (const auto unknown =
            block::UnknownPhotos(options.measurements, block::PhotoNames(options.photos)))
      out << "note      " << Sentence(*unknown) << "\n";
    return code;
  }

 private:
  void RefuseToReplace(const block::InteriorRunOptions& options) const {
    std::vector<std::string> inputs = options.photos;
    if (camera_ != block::kAutoCamera) inputs.push_back(options.camera);
    Append(MeasurementFiles(options.measurements.folder), &inputs);
    std::vector<std::string> written = block::InteriorFiles(options.out);
    Append(block::PhotoFiles(options.out, block::PhotoNames(options.photos)), &written);
    RefuseToReplaceInputs(written, inputs);
    std::vector<std::string> paths;
    for (const std::string& photo : options.photos)
      paths.push_back(InteriorResultPath(options.out, PhotoName(photo)));
    RefuseToOverwrite(paths, output_.overwrite || resume_, "--resume");
  }

  void AddScannerOption(CLI::App& app) {
    app.add_option_function<std::string>(
           "--scanner",
           [this](const std::string& text) {
             scanner_.reset();
             if (text == "photogrammetric") scanner_ = interior::Scanner::kPhotogrammetric;
             if (text == "desktop") scanner_ = interior::Scanner::kDesktop;
           },
           "How much the scanner or print deforms the film; determined by default")
        ->check(CLI::IsMember({"auto", "photogrammetric", "desktop"}))
        ->default_str("auto");
  }

  interior::AssignmentMethod Assignment() const {
    return assignment_ == "softassign" ? interior::AssignmentMethod::kSoftassign
                                       : interior::AssignmentMethod::kExact;
  }

  std::optional<interior::LocatorKind> Locator() const {
    if (locator_ == "hough") return interior::LocatorKind::kHough;
    if (locator_ == "ncc") return interior::LocatorKind::kNcc;
    if (locator_ == "lines") return interior::LocatorKind::kLines;
    return std::nullopt;
  }

  static ExitCode Summarise(const std::vector<InteriorResult>& results, std::ostream& out) {
    SummaryTable table(
        {"photo", "status", "marks", "lies", "sigma0 um", "margin", "pixel um", "message"});
    bool all = true;
    for (const InteriorResult& r : results) {
      table.AddRow({r.photo, std::string(orient::Name(r.status)),
                    fmt::format("{}/{}", CountUsedMarks(r), r.marks.size()), Orientation(r),
                    Fixed(r.sigma0_um, 1), Fixed(r.margin, 1), Fixed(r.pixel_size_um, 2),
                    MessageCell(r.findings)});
      all = all && r.status != Status::kFailed;
    }
    table.Print(out);
    if (const auto roll = block::StatisticsOfRoll(results))
      for (const std::string& sentence : block::RollSentences(*roll)) out << sentence << "\n";
    return all ? ExitCode::kAllDone : ExitCode::kSomeNotOriented;
  }

  std::vector<std::string> patterns_;
  std::string camera_;
  std::string library_;
  OutputOptions output_;
  bool resume_ = false;
  bool plan_ = false;
  ScanOptions scan_;
  std::optional<interior::Scanner> scanner_;
  Measurements measurements_;
  std::string locator_ = "auto";
  std::string assignment_ = "exact";
  std::string roll_ = "alike";
  int jobs_ = 0;
  bool micmac_ = false;
  EstimateCameraCommand estimate_camera_;
};

}  // namespace

block::InteriorRunOptions InteriorRunOf(const std::vector<std::string>& arguments) {
  return OptionsOf<InteriorCommand>(arguments);
}

std::unique_ptr<Command> MakeInteriorCommand() { return std::make_unique<InteriorCommand>(); }

}  // namespace orient
