// orient interior: fiducial marks, and with them the transform from pixel to film.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <ostream>

#include "core/error.h"
#include "core/files/block_file.h"
#include "core/files/orientation_table.h"
#include "core/files/used_marks.h"
#include "interior/roll.h"
#include "tools/camera_library.h"
#include "tools/commands.h"
#include "tools/estimate_camera.h"
#include "tools/interior_run.h"
#include "tools/progress.h"
#include "tools/shared_options.h"
#include "tools/summary_table.h"

namespace orient {
namespace {

std::string First(const std::vector<std::string>& messages) {
  return messages.empty() ? "" : messages.front();
}

class InteriorCommand : public Command {
 public:
  std::string Name() const override { return "interior"; }
  std::string Summary() const override {
    return "Interior orientation: find the fiducial marks, pixel to film";
  }

  void Setup(CLI::App& app) override {
    // A required positional would take the subcommand's name for a photo; Run asks for it.
    AddPhotosOption(app, &patterns_)->required(false);
    app.add_option("--camera", camera_,
                   "Camera file (TOML), a name of the camera library, or auto: find out")
        ->required();
    AddCameraLibraryOption(app, &library_);
    AddOutputOptions(app, &output_);
    app.add_flag("--resume", resume_, "Keep the results that exist, do the other photos");
    AddScanOptions(app, &scan_);
    AddScannerOption(app);
    app.add_option("--locator", locator_, "How marks are searched")
        ->check(CLI::IsMember({"auto", "hough", "ncc", "lines"}))
        ->capture_default_str();
    AddJobsOption(app, &jobs_);
    estimate_camera_.Setup(app);
    app.add_flag("--micmac", micmac_, "Write the marks for MicMac too (DIR/Ori-InterneScan)");
  }

  ExitCode Run(std::ostream& out) override {
    if (estimate_camera_.Asked()) return estimate_camera_.Run(out);
    if (patterns_.empty()) throw UsageError("PHOTO is required: name at least one scan or a glob");
    InteriorRunOptions options;
    options.photos = ExpandPhotos(patterns_, "");
    options.camera = camera_ == kAutoCamera ? camera_ : FindCameraFile(camera_, library_);
    options.camera_library = library_;
    options.out = output_.directory;
    options.scan = {scan_.pixel_size_um, scan_.polarity, scan_.orientation, scanner_, Locator()};
    options.resume = resume_;
    options.jobs = jobs_;
    options.micmac = micmac_;
    std::vector<std::string> paths;
    for (const std::string& photo : options.photos)
      paths.push_back(InteriorResultPath(options.out, PhotoName(photo)));
    RefuseToOverwrite(paths, output_.overwrite || resume_, "--resume");
    Progress progress("interior orientation", static_cast<int>(options.photos.size()));
    std::vector<std::string> notes;
    const auto results = RunInterior(
        options, [&] { progress.Advance(); }, &notes);
    progress.Finish();
    const ExitCode code = Summarise(results, out);
    for (const std::string& note : notes) out << note << "\n";
    return code;
  }

 private:
  void AddScannerOption(CLI::App& app) {
    app.add_option_function<std::string>(
           "--scanner",
           [this](const std::string& text) {
             scanner_.reset();
             if (text == "photogrammetric") scanner_ = Scanner::kPhotogrammetric;
             if (text == "desktop") scanner_ = Scanner::kDesktop;
           },
           "How much the scanner or print deforms the film; found out by default")
        ->check(CLI::IsMember({"auto", "photogrammetric", "desktop"}))
        ->default_str("auto");
  }

  std::optional<LocatorKind> Locator() const {
    if (locator_ == "hough") return LocatorKind::kHough;
    if (locator_ == "ncc") return LocatorKind::kNcc;
    if (locator_ == "lines") return LocatorKind::kLines;
    return std::nullopt;
  }

  static ExitCode Summarise(const std::vector<InteriorResult>& results, std::ostream& out) {
    SummaryTable table({"photo", "status", "marks", "sigma0 um", "margin", "pixel um", "message"});
    bool all = true;
    for (const InteriorResult& r : results) {
      table.AddRow({r.photo, std::string(orient::Name(r.status)),
                    std::to_string(CountUsedMarks(r)) + "/" + std::to_string(r.marks.size()),
                    Fixed(r.sigma0_um, 1), Fixed(r.margin, 1), Fixed(r.pixel_size_um, 2),
                    First(r.messages)});
      all = all && r.status != Status::kFailed;
    }
    table.Print(out);
    if (const auto roll = StatisticsOfRoll(results))
      for (const std::string& finding : Findings(*roll)) out << finding << "\n";
    return all ? ExitCode::kAllDone : ExitCode::kSomeNotOriented;
  }

  std::vector<std::string> patterns_;
  std::string camera_;
  std::string library_;
  OutputOptions output_;
  bool resume_ = false;
  ScanOptions scan_;
  std::optional<Scanner> scanner_;
  std::string locator_ = "auto";
  int jobs_ = 0;
  bool micmac_ = false;
  EstimateCameraCommand estimate_camera_;
};

}  // namespace

std::unique_ptr<Command> MakeInteriorCommand() { return std::make_unique<InteriorCommand>(); }

}  // namespace orient
