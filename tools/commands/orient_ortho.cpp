// orient ortho: orthophotos of oriented photos, and their mosaic.
#include <CLI/CLI.hpp>
#include <cmath>
#include <filesystem>
#include <ostream>

#include "block/block_folder.h"
#include "block/inputs/camera_library.h"
#include "core/base/error.h"
#include "core/files/adjustment_result.h"
#include "core/files/block_file.h"
#include "tools/commands/commands.h"
#include "tools/commands/memory.h"
#include "tools/commands/ortho_run.h"
#include "tools/commands/record_run.h"
#include "tools/commands/shared_options.h"
#include "tools/convert/convert_source.h"
#include "tools/report/gis/block_project.h"
#include "tools/report/report.h"
#include "tools/report/run_record.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

// A check as CLI11 requires it: empty if the text is a pixel size.
std::string WhyNoPixelSize(const std::string& text) {
  double size_m = 0;
  if (CLI::detail::lexical_cast(text, size_m) && size_m > 0 && std::isfinite(size_m)) return "";
  return text + " is not a pixel size; give a positive number of metres";
}

class OrthoCommand : public Command {
 public:
  std::string Name() const override { return "ortho"; }
  std::string Summary() const override {
    return "Orthophotos of oriented photos over a DEM or DSM, and their mosaic";
  }

  void Setup(CLI::App& app) override {
    app.add_option(
           "INPUT", input_,
           "Block file (TOML), the folder of 'orient block' or 'orient exterior', or an OPK "
           "CSV")
        ->required();
    AddPhotosOption(app, &patterns_)
        ->description("Scans (globs are expanded); for a block file, all of its photos by default");
    app.add_option("--dem", options_.source.dem,
                   "Ground heights: any raster GDAL reads (default: the block file's)");
    app.add_option("--camera", options_.source.camera,
                   "Camera file (TOML), where the folder does not hold the poses' own");
    app.add_option("--interior", options_.source.interior,
                   "Folder with the results of 'orient interior' (default: the poses' folder)");
    app.add_option("--gsd-m", options_.gsd_m,
                   "Pixel size on the ground, metres (default: the photos' median ground sample "
                   "distance, to two digits)")
        ->check(CLI::Validator(WhyNoPixelSize, "POSITIVE"));
    app.add_option("--border-mm", options_.border_mm,
                   "Width of the frame's border that is left out, mm (default: 1 % of film "
                   "frames, nothing of digital ones)")
        ->check(CLI::Range(0.0, 50.0));
    app.add_option("--dem-sigma-m", options_.dem_sigma_m,
                   "Accuracy of the heights, one sigma, metres: included in the stated CE90")
        ->check(CLI::Range(0.0, 1000.0));
    app.add_flag("--weak", options_.source.weak, "Also photos whose orientation is weak");
    app.add_flag("--mosaic", options_.mosaic,
                 "Also make a mosaic, mosaic.tif, and its seamlines.gpkg");
    app.add_option("--seams", options_.seams,
                   "Seamlines of the mosaic: a seamlines.gpkg, perhaps edited (default: by the "
                   "nearest nadir)");
    app.add_flag("--least-difference", options_.least_difference,
                 "Let the mosaic's seamlines run where the photos differ least, near those of the "
                 "nearest nadir");
    app.add_flag("--balance", options_.balance,
                 "Give the photos one tone in the mosaic: a gain and an offset each, from their "
                 "overlaps");
    app.add_option("--out", options_.out,
                   "Folder for the results (default: 'ortho' beside the poses)");
    AddOverwriteOption(app, &options_.overwrite);
    app.add_flag("--resume", options_.resume,
                 "Keep existing results, edited seamlines too, and do the others");
    AddPlanOption(app, &options_.plan);
    AddJobsOption(app, &options_.jobs)->description("Threads; 0: one per processor");
  }

  ExitCode Run(std::ostream& out) override {
    constexpr int kCache_MB = 64;  // decoded pixels are used once
    BoundBlockCache(kCache_MB);
    Prepare();
    if (!options_.plan) options_.inputs = Inputs();
    if (const auto note = block::UnfinishedNote(FolderOf(options_.source.poses)))
      out << "note      " << *note << "\n";
    const bool all = MakeOrthophotos(options_, out);
    if (options_.plan) return all ? ExitCode::kAllDone : ExitCode::kSomeNotOriented;
    RecordRun(Invoked(), options_.out, "ortho", options_.inputs);
    ShowInProject(out);
    ShowInReport(out);
    return all ? ExitCode::kAllDone : ExitCode::kSomeNotOriented;
  }

 private:
  std::vector<RunInput> Inputs() const {
    std::vector<RunInput> inputs = {FileInput("poses", PosesFile()),
                                    FileInput("camera", options_.source.camera),
                                    RasterInput("DEM", options_.source.dem),
                                    RunInput{"interior orientation", options_.source.interior, ""},
                                    FileInput("seamlines", options_.seams)};
    std::erase_if(inputs, [](const RunInput& input) { return input.path.empty(); });
    return inputs;
  }

  std::string PosesFile() const {
    const fs::path poses(options_.source.poses);
    return (fs::is_directory(poses) ? poses / "orientation.csv" : poses).string();
  }

  // The block's project for QGIS, which lists its orthophotos; a failure costs none of them.
  void ShowInProject(std::ostream& out) const {
    try {
      WriteBlockProject(FolderOf(options_.source.poses));
    } catch (const InputError& error) {
      out << "note      block.qgz does not show them: " << error.what() << "\n";
    }
  }

  // Rewrites a report that is there, so that it is up to date.
  void ShowInReport(std::ostream& out) const {
    const std::string folder = FolderOf(options_.source.poses);
    if (!fs::exists(fs::path(folder) / "report.html")) return;
    std::error_code ignored;  // then they lie elsewhere, as far as is known
    const fs::path block = fs::weakly_canonical(folder, ignored);
    const fs::path out_folder = fs::weakly_canonical(options_.out, ignored);
    if (out_folder != block && out_folder != block / "ortho") return;
    // The findings of a block that was not adjusted are in its report alone.
    if (ReadRunRecords(folder).contains("block") && !fs::exists(AdjustmentResultPath(folder))) {
      out << "note      report.html does not show them: orient block makes it, with --resume\n";
      return;
    }
    try {
      WriteReport(folder);
    } catch (const InputError& error) {
      out << "note      report.html does not show them: " << error.what() << "\n";
    }
  }

  void Prepare() {
    OrthoSource& source = options_.source;
    if (fs::path(input_).extension() == ".toml") {
      const BlockFile block = ReadBlockFile(input_);
      source.poses = block.output_directory;
      source.scans = block.photos;
      if (source.dem.empty()) source.dem = block.dem;
    } else {
      source.poses = input_;
    }
    if (!patterns_.empty()) source.scans = ExpandPhotos(patterns_, "");
    if (source.scans.empty()) throw UsageError("name the photos' scans after " + input_);
    if (source.dem.empty()) throw UsageError("name the ground heights with --dem");
    if (!source.camera.empty()) source.camera = block::FindCameraFile(source.camera, "");
    if (options_.out.empty()) options_.out = (fs::path(FolderOf(source.poses)) / "ortho").string();
    if (!options_.seams.empty() && options_.least_difference)
      throw UsageError(
          "--seams gives the seamlines, --least-difference computes them; give only one of "
          "them");
    if (!options_.seams.empty() || options_.least_difference || options_.balance)
      options_.mosaic = true;
  }

  std::string input_;
  std::vector<std::string> patterns_;
  OrthoRunOptions options_;
};

}  // namespace

std::unique_ptr<Command> MakeOrthoCommand() { return std::make_unique<OrthoCommand>(); }

}  // namespace orient
