// orient patchdb harvest, harvest-ortho, add-gcp.

#include <CLI/CLI.hpp>
#include <ostream>

#include "block/plan.h"
#include "block/stages/harvest_stage.h"
#include "core/base/date.h"
#include "core/base/error.h"
#include "core/files/block_file.h"
#include "patchdb/store/patch_database.h"
#include "tools/commands/harvested.h"
#include "tools/commands/patchdb/add_control.h"
#include "tools/commands/patchdb/filter_options.h"
#include "tools/commands/patchdb/verb.h"
#include "tools/commands/patchdb_to_write.h"
#include "tools/commands/progress.h"
#include "tools/commands/shared_options.h"

namespace orient {
namespace {

void PrintHarvestPlan(const patchdb::PatchDatabase& database, patchdb::SourceKind kind,
                      const std::vector<std::string>& paths, const patchdb::PatchSource& about,
                      std::ostream& out) {
  const std::vector<bool> harvested = block::AreHarvested(database, kind, paths, about);
  for (std::size_t i = 0; i < paths.size(); ++i)
    out << block::PlanLine(harvested[i], "harvest   " + paths[i]) << "\n";
}

// Arguments of both kinds of harvest.
struct HarvestArguments {
  block::HarvestRun run;
  std::string date, provenance, licence;
  bool plan = false;

  void Declare(CLI::App& app, const std::string& max_option) {
    patchdb::HarvestOptions& options = run.options;
    options.max_further_views = 0;  // until poses from several views are as good as from one
    app.add_option("--dem", run.dem, "Ground heights: any raster GDAL reads, any projected CRS")
        ->required();
    app.add_option(
        "--dsm", run.dsm,
        "Surface model with buildings and trees, to refuse patches on them: formats as for --dem");
    app.add_option("--date", date, "Date of the images, ISO 8601 (1961, 1961-07-30)")
        ->check(DateProblem);
    app.add_option("--provenance", provenance, "Who made the images, from what");
    app.add_option("--licence", licence, "Licence of the images");
    app.add_option("--chip-px", options.chip_px, "Side of a chip in pixels, odd");
    app.add_flag("--colour", options.colour,
                 "Keep chips in colour: about twice as much to store and read");
    app.add_option("--spacing-px", options.spacing_px,
                   "Distance between patches in source pixels; default: from " + max_option);
    app.add_option(max_option, options.max_count,
                   "Grid cells per source: about the largest number of patches");
    app.add_option("--dem-sigma-m", options.dem_sigma_m,
                   "Precision of the DEM's heights in metres; default: a tenth of its cell");
    app.add_option("--orientation-sigma-px", options.orientation_sigma_px,
                   "Precision of the source's orientation in its pixels, if no sigmas are given");
    app.add_option(
        "--min-distinctness", options.min_distinctness,
        "Refuse patches that fit nearly as well at a second place: 0 nothing, 1 everything");
    app.add_option(
        "--max-lean-px", options.max_lean_px,
        "Refuse patches where the DSM is this far above or below the ground, in chip pixels");
    app.add_option(
        "--further-views", options.max_further_views,
        "Also measure each place in up to this many other sources; 0: every source by itself");
    AddPlanOption(app, &plan);
  }
  // A plan writes nothing.
  patchdb::PatchDatabase Open(const std::string& path, std::ostream& out) const {
    return plan ? patchdb::PatchDatabase::Open(path, patchdb::PatchDatabase::Mode::kRead)
                : OpenToWrite(path, out);
  }
  const block::HarvestRun& Checked() {
    if (const auto wrong = run.options.Check()) throw UsageError(*wrong);
    if (!date.empty()) run.about.date = date;
    if (!provenance.empty()) run.about.provenance = provenance;
    if (!licence.empty()) run.about.licence = licence;
    return run;
  }
};

class HarvestVerb : public PatchdbVerb {
 public:
  CLI::App* Declare(CLI::App& app) override {
    CLI::App* verb = app.add_subcommand("harvest", "Cut patches from oriented photos");
    verb->add_option("DB", path_, "Patch database")->required();
    AddPhotosOption(*verb, &patterns_);
    verb->add_option("--camera", camera_, "Camera file")->required();
    verb->add_option("--orientation", photos_.orientation_path, "Orientation table (OPK CSV)")
        ->required();
    verb->add_option("--interior", photos_.interior_folder,
                     "Folder of interior orientations (film cameras)");
    AddEarthOption(*verb, &photos_.earth);
    arguments_.Declare(*verb, "--max-per-photo");
    return verb;
  }
  void Run(std::ostream& out) override {
    const block::HarvestRun& run = arguments_.Checked();
    patchdb::PatchDatabase database = arguments_.Open(path_, out);
    ReadPhotosToHarvest(camera_, patterns_, path_, database, &photos_);
    if (arguments_.plan)
      return PrintHarvestPlan(database, patchdb::SourceKind::kPhoto, photos_.paths, run.about, out);
    ShownProgress progress;
    PrintHarvest(block::HarvestPhotos(database, run, photos_, &progress), !run.dsm.empty(), out);
  }

 private:
  std::string path_, camera_;
  std::vector<std::string> patterns_;
  block::PhotosToHarvest photos_;
  HarvestArguments arguments_;
};

class HarvestOrthoVerb : public PatchdbVerb {
 public:
  CLI::App* Declare(CLI::App& app) override {
    CLI::App* verb = app.add_subcommand("harvest-ortho", "Cut patches from orthophotos");
    verb->add_option("DB", path_, "Patch database")->required();
    verb->add_option("--ortho", orthos_, "Orthophotos or globs, any projected CRS")->required();
    arguments_.run.options = patchdb::OrthoHarvestOptions();
    arguments_.Declare(*verb, "--max-per-ortho");
    return verb;
  }
  void Run(std::ostream& out) override {
    const block::HarvestRun& run = arguments_.Checked();
    patchdb::PatchDatabase database = arguments_.Open(path_, out);
    const std::vector<std::string> paths = ExpandPhotos(orthos_, "");
    if (arguments_.plan)
      return PrintHarvestPlan(database, patchdb::SourceKind::kOrthophoto, paths, run.about, out);
    ShownProgress progress;
    PrintHarvest(block::HarvestOrthophotos(database, run, paths, &progress), !run.dsm.empty(), out);
  }

 private:
  std::string path_;
  std::vector<std::string> orthos_;
  HarvestArguments arguments_;
};

class AddGcpVerb : public PatchdbVerb {
 public:
  CLI::App* Declare(CLI::App& app) override {
    CLI::App* verb =
        app.add_subcommand("add-gcp", "Make patches of ground control points measured in photos");
    verb->add_option("DB", path_, "Patch database")->required();
    AddPhotosOption(*verb, &patterns_);
    verb->add_option("--points", control_.table,
                     "CSV: point,x,y,z,sigma_x,sigma_y,sigma_z,photo,col,row")
        ->required();
    verb->add_option("--camera", camera_, "Camera file")->required();
    verb->add_option("--orientation", photos_.orientation_path, "Orientation table (OPK CSV)")
        ->required();
    verb->add_option("--dem", control_.dem, "Ground heights around the points")->required();
    verb->add_option("--interior", photos_.interior_folder,
                     "Folder of interior orientations (film cameras)");
    AddEarthOption(*verb, &photos_.earth);
    verb->add_option("--date", date_, "Date of the images, ISO 8601 (1961, 1961-07-30)")
        ->check(DateProblem);
    verb->add_option("--provenance", provenance_, "Who surveyed the points");
    verb->add_option("--chip-px", control_.chip_px, "Side of a chip in pixels, odd");
    return verb;
  }
  void Run(std::ostream& out) override {
    patchdb::HarvestOptions options;
    options.chip_px = control_.chip_px;
    if (const auto wrong = options.Check()) throw UsageError(*wrong);
    patchdb::PatchDatabase database = OpenToWrite(path_, out);
    ReadPhotosToHarvest(camera_, patterns_, path_, database, &photos_);
    if (!date_.empty()) control_.about.date = date_;
    if (!provenance_.empty()) control_.about.provenance = provenance_;
    AddControlPoints(database, control_, photos_, out);
  }

 private:
  std::string path_, camera_, date_, provenance_;
  std::vector<std::string> patterns_;
  block::PhotosToHarvest photos_;
  ControlToAdd control_;
};

}  // namespace

std::unique_ptr<PatchdbVerb> MakeAddGcpVerb() { return std::make_unique<AddGcpVerb>(); }
std::unique_ptr<PatchdbVerb> MakeHarvestVerb() { return std::make_unique<HarvestVerb>(); }
std::unique_ptr<PatchdbVerb> MakeHarvestOrthoVerb() { return std::make_unique<HarvestOrthoVerb>(); }

}  // namespace orient
