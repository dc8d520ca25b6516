// orient measurements: what other programs measured, as files of measurements.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <ostream>

#include "core/base/error.h"
#include "core/base/output_directory.h"
#include "core/exchange/measured_files.h"
#include "core/geometry/sigma.h"
#include "core/measurements/written_measurements.h"
#include "tools/commands/commands.h"
#include "tools/commands/shared_options.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

class MeasurementsCommand : public Command {
 public:
  std::string Name() const override { return "measurements"; }
  std::string Summary() const override {
    return "Read other programs' image and ground points into files of measurements";
  }

  void Setup(CLI::App& app) override {
    app.add_option("FILE", files_, "Files of one format")->required();
    app.add_option("--from", from_, "Program that wrote the files")
        ->required()
        ->check(CLI::IsMember({"metashape", "micmac", "patb", "bingo", "csv"}));
    app.add_option(
        "--sigma", sigma_.image,
        "One sigma of image coordinates: pixels, for PAT-B and BINGO mm; in a CSV, for lines "
        "without an accuracy (default: 1 pixel, 0.01 mm)");
    app.add_option("--ground-sigma-m", sigma_.ground_m,
                   "One sigma of ground coordinates for which the file states none, metres")
        ->capture_default_str();
    app.add_flag("--marks", marks_, "The image points are fiducial marks");
    AddOutputOptions(app, &output_);
  }

  ExitCode Run(std::ostream& out) override {
    RequireSigmas();
    GatheredMeasurements gathered;
    for (const std::string& file : files_)
      AddMeasuredFile(file, *MeasuredFormatFromName(from_), sigma_, &gathered);
    Measurements all = gathered.All();
    if (marks_) TakeForMarks(&all);
    std::vector<std::string> paths;
    for (const std::string& file : FilesOf(all))
      paths.push_back((fs::path(output_.directory) / file).string());
    RefuseToReplaceInputs(paths, files_);
    RefuseToOverwrite(paths, output_.overwrite);
    MakeOutputDirectory(output_.directory);
    WriteMeasurements(output_.directory, all);
    for (const std::string& note : gathered.Notes()) out << note << "\n";
    out << fmt::format("{} marks, {} image points, {} ground points\n", all.marks.size(),
                       all.image_points.size(), all.points.size());
    return ExitCode::kAllDone;
  }

 private:
  void RequireSigmas() const {
    if (!sigma_.image && from_ != "csv")
      throw UsageError("--sigma is missing: files of " + from_ +
                       " state no accuracy of image coordinates");
    for (const double sigma : {sigma_.image.value_or(1), sigma_.ground_m})
      if (const std::string why = SigmaProblem(sigma); !why.empty())
        throw UsageError(fmt::format("--sigma or --ground-sigma-m is {:g}; {}", sigma, why));
  }

  void TakeForMarks(Measurements* all) const {
    for (const ImagePointMeasurement& seen : all->image_points) {
      if (!seen.pixel) throw UsageError("--marks: " + from_ + " measures no marks on scans");
      all->marks.push_back({seen.photo, seen.point, *seen.pixel, seen.sigma, false, {}});
    }
    all->image_points.clear();
  }

  std::vector<std::string> files_;
  std::string from_;
  MeasuredSigma sigma_;
  bool marks_ = false;
  OutputOptions output_;
};

}  // namespace

std::unique_ptr<Command> MakeMeasurementsCommand() {
  return std::make_unique<MeasurementsCommand>();
}

}  // namespace orient
