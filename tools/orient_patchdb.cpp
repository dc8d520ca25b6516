// orient patchdb: make and fill the database of control patches; what looks after it is in
// tools/patchdb/.

#include <CLI/CLI.hpp>
#include <filesystem>
#include <ostream>

#include "core/error.h"
#include "core/files/block_file.h"
#include "core/files/camera_file.h"
#include "core/files/orientation_table.h"
#include "patchdb/harvest.h"
#include "patchdb/patch_database.h"
#include "patchdb/source_view.h"
#include "tools/commands.h"
#include "tools/patchdb/verb.h"
#include "tools/photo_interior.h"
#include "tools/progress.h"
#include "tools/shared_options.h"
#include "tools/summary_table.h"

namespace orient {
namespace {

std::string FileName(const std::string& path) {
  return std::filesystem::path(path).filename().string();
}

// What both kinds of harvest print, a row a source.
class HarvestTable {
 public:
  HarvestTable() : table_(Header()) {}
  void Add(const std::string& name, const HarvestResult& harvest) {
    std::vector<std::string> cells = {name, std::to_string(harvest.patches.size()),
                                      Fixed(harvest.gsd_m, 3)};
    for (const Refusal refusal : kAllRefusals)
      cells.push_back(std::to_string(harvest.Refused(refusal)));
    table_.AddRow(cells);
    patches_ += harvest.patches.size();
  }
  void AddKnown(const std::string& name) {
    std::vector<std::string> cells(Header().size(), "-");
    cells[0] = name + " (in the database already)";
    table_.AddRow(cells);
  }
  void Print(std::ostream& out) const {
    table_.Print(out);
    out << patches_ << " patches added; the columns after gsd count refused candidates\n";
  }

 private:
  static std::vector<std::string> Header() {
    std::vector<std::string> header = {"source", "patches", "gsd [m]"};
    for (const Refusal refusal : kAllRefusals) header.emplace_back(Name(refusal));
    return header;
  }
  SummaryTable table_;
  std::size_t patches_ = 0;
};

struct HarvestArguments {
  std::string dem;
  std::string date;
  HarvestOptions options;

  void Declare(CLI::App& app, const std::string& max_option) {
    app.add_option("--dem", dem, "Ground heights: any raster GDAL reads, any projected CRS")
        ->required();
    app.add_option("--date", date, "Date of the images, ISO 8601 (1961, 1961-07-30)");
    app.add_option("--chip-px", options.chip_px, "Side of a chip in pixels, odd");
    app.add_option("--spacing-px", options.spacing_px,
                   "Distance between patches in source pixels; otherwise from " + max_option);
    app.add_option(max_option, options.max_count,
                   "Grid cells, so about the most patches, a source");
    app.add_option("--dem-sigma-m", options.dem_sigma_m,
                   "Precision of the DEM's heights in metres; otherwise a tenth of its cell");
    app.add_option(
        "--orientation-sigma-px", options.orientation_sigma_px,
        "Precision of the source's orientation in its pixels, where no sigmas are given");
    app.add_option("--min-distinctness", options.min_distinctness,
                   "Refuse what fits nearly as well at a second place: 0 nothing, 1 everything");
  }
  void Check() const {
    if (const auto wrong = options.Check()) throw UsageError(*wrong);
  }
  PatchSource Source(SourceKind kind, const std::string& name) const {
    PatchSource source;
    source.kind = kind;
    source.name = name;
    if (!date.empty()) source.date = date;
    return source;
  }
};

void Store(PatchDatabase& database, PatchSource source, HarvestResult& harvest) {
  source.gsd_m = harvest.gsd_m;
  database.AddSource(source, harvest.patches);
}

HarvestProgress ShowOn(std::unique_ptr<Progress>& progress, const std::string& name) {
  return [&progress, name](std::string_view stage, int done, int total) {
    if (done == 1) progress = std::make_unique<Progress>(name + ", " + std::string(stage), total);
    progress->Advance();
  };
}

class CreateVerb : public PatchdbVerb {
 public:
  CLI::App* Declare(CLI::App& app) override {
    CLI::App* verb = app.add_subcommand("create", "Make an empty patch database");
    verb->add_option("DB", path_, "GeoPackage to make")->required();
    verb->add_option("--crs", crs_, "Ground CRS: EPSG:32635, WKT, a PROJ string, or a .prj file")
        ->required();
    return verb;
  }
  void Run(std::ostream& out) override {
    std::error_code error;  // WKT is longer than any file's name may be
    const bool is_file = std::filesystem::is_regular_file(crs_, error);
    const Crs crs = is_file ? Crs::FromFile(crs_) : Crs::Parse(crs_, "--crs");
    PatchDatabase::Create(path_, crs);
    out << path_ << " made, CRS " << crs.Name() << "\n";
  }

 private:
  std::string path_, crs_;
};

class HarvestVerb : public PatchdbVerb {
 public:
  CLI::App* Declare(CLI::App& app) override {
    CLI::App* verb = app.add_subcommand("harvest", "Cut patches from oriented photos");
    verb->add_option("DB", path_, "Patch database")->required();
    AddPhotosOption(*verb, &photos_);
    verb->add_option("--camera", camera_, "Camera file")->required();
    verb->add_option("--orientation", orientation_, "Orientation table (OPK CSV)")->required();
    verb->add_option("--interior", interior_, "Folder of interior orientations (film cameras)");
    arguments_.Declare(*verb, "--max-per-photo");
    return verb;
  }
  void Run(std::ostream& out) override {
    arguments_.Check();
    PatchDatabase database = PatchDatabase::Open(path_, PatchDatabase::Mode::kWrite);
    const Camera camera = ReadCameraFile(camera_).camera;
    const OrientationTable table = ReadOrientationTable(orientation_);
    if (table.crs && !table.crs->SameAs(database.GroundCrs()))
      throw InputError(orientation_ + " is in " + table.crs->Name() + ", " + path_ + " in " +
                       database.GroundCrs().Name() + "; both must be in one CRS");
    const auto photos = ExpandPhotos(photos_, "");
    for (const std::string& photo : photos) RowOf(table, photo);
    HarvestTable summary;
    for (const std::string& photo : photos) HarvestOne(database, camera, table, photo, summary);
    summary.Print(out);
  }

 private:
  const OrientationRow& RowOf(const OrientationTable& table, const std::string& photo) const {
    const OrientationRow* row = table.Find(PhotoName(photo));
    if (row == nullptr)
      throw InputError(orientation_ + " has no row for photo '" + PhotoName(photo) +
                       "'; add its orientation or leave the photo out");
    return *row;
  }

  void HarvestOne(PatchDatabase& database, const Camera& camera, const OrientationTable& table,
                  const std::string& photo, HarvestTable& summary) const {
    const std::string name = FileName(photo);
    if (database.HasSource(SourceKind::kPhoto, name)) return summary.AddKnown(name);
    const OrientationRow& row = RowOf(table, photo);
    const Raster raster = Raster::Open(photo);
    const PhotoInterior interior = PhotoInteriorOf(raster, camera, interior_);
    const PhotoView view{camera, interior.photo_from_pixel, row.pose, interior.film_correction};
    const auto footprint = FootprintBounds(camera, row.pose, kLowestGround_m, kHighestGround_m);
    if (!footprint)
      throw InputError(orientation_ + ": photo '" + row.photo + "' does not look at the ground; " +
                       "check its height and angles");
    const GroundSurface surface =
        GroundSurface::FromFile(arguments_.dem, database.GroundCrs(), footprint);
    std::optional<Matrix6d> covariance;
    if (row.sigma) covariance = Matrix6d(row.sigma->cwiseAbs2().asDiagonal());
    std::unique_ptr<Progress> progress;
    HarvestResult harvest =
        HarvestPhoto(raster, view, covariance, surface, arguments_.options, ShowOn(progress, name));
    Store(database, arguments_.Source(SourceKind::kPhoto, name), harvest);
    summary.Add(name, harvest);
  }

  std::string path_, camera_, orientation_, interior_;
  std::vector<std::string> photos_;
  HarvestArguments arguments_;
};

class HarvestOrthoVerb : public PatchdbVerb {
 public:
  CLI::App* Declare(CLI::App& app) override {
    CLI::App* verb = app.add_subcommand("harvest-ortho", "Cut patches from orthophotos");
    verb->add_option("DB", path_, "Patch database")->required();
    verb->add_option("--ortho", orthos_, "Orthophotos or globs, any projected CRS")->required();
    arguments_.options = OrthoHarvestOptions();
    arguments_.Declare(*verb, "--max-per-ortho");
    return verb;
  }
  void Run(std::ostream& out) override {
    arguments_.Check();
    PatchDatabase database = PatchDatabase::Open(path_, PatchDatabase::Mode::kWrite);
    HarvestTable summary;
    for (const std::string& ortho : ExpandPhotos(orthos_, "")) HarvestOne(database, ortho, summary);
    summary.Print(out);
  }

 private:
  void HarvestOne(PatchDatabase& database, const std::string& ortho, HarvestTable& summary) const {
    const std::string name = FileName(ortho);
    if (database.HasSource(SourceKind::kOrthophoto, name)) return summary.AddKnown(name);
    const Raster raster = Raster::Open(ortho);
    const Crs& crs = database.GroundCrs();
    const GroundSurface surface =
        GroundSurface::FromFile(arguments_.dem, crs, OrthoFootprint(raster, crs));
    std::unique_ptr<Progress> progress;
    HarvestResult harvest =
        HarvestOrtho(raster, crs, surface, arguments_.options, ShowOn(progress, name));
    Store(database, arguments_.Source(SourceKind::kOrthophoto, name), harvest);
    summary.Add(name, harvest);
  }

  std::string path_;
  std::vector<std::string> orthos_;
  HarvestArguments arguments_;
};

class InfoVerb : public PatchdbVerb {
 public:
  CLI::App* Declare(CLI::App& app) override {
    CLI::App* verb = app.add_subcommand("info", "Say what a patch database holds");
    verb->add_option("DB", path_, "Patch database")->required();
    return verb;
  }
  void Run(std::ostream& out) override {
    const PatchDatabase database = PatchDatabase::Open(path_, PatchDatabase::Mode::kRead);
    const PatchDatabaseInfo info = database.Info();
    out << "CRS       " << info.crs_name << "\nschema    version " << info.schema_version
        << "\npatches   " << info.patches << "\nretired   " << info.retired << "\nattempts  "
        << info.attempts << "\nsources   " << info.sources << "\n";
    if (info.patches > 0)
      out << "extent    " << Fixed(info.extent.min_x, 1) << " " << Fixed(info.extent.min_y, 1)
          << " to " << Fixed(info.extent.max_x, 1) << " " << Fixed(info.extent.max_y, 1) << "\n";
    if (info.sources == 0) return;
    SummaryTable table({"source", "kind", "date", "gsd [m]"});
    for (const PatchSource& source : database.Sources())
      table.AddRow(
          {source.name, Name(source.kind), source.date.value_or("-"), Fixed(source.gsd_m, 3)});
    out << "\n";
    table.Print(out);
  }

 private:
  std::string path_;
};

class PatchdbCommand : public Command {
 public:
  PatchdbCommand() {
    verbs_.push_back(std::make_unique<CreateVerb>());
    verbs_.push_back(std::make_unique<HarvestVerb>());
    verbs_.push_back(std::make_unique<HarvestOrthoVerb>());
    verbs_.push_back(std::make_unique<InfoVerb>());
    for (auto& verb : MakeMaintenanceVerbs()) verbs_.push_back(std::move(verb));
  }
  std::string Name() const override { return "patchdb"; }
  std::string Summary() const override {
    return "Make, fill and look after the database of control patches";
  }
  void Setup(CLI::App& app) override {
    app.require_subcommand(1);
    parsers_.clear();
    for (const auto& verb : verbs_) parsers_.push_back(verb->Declare(app));
  }
  ExitCode Run(std::ostream& out) override {
    for (std::size_t i = 0; i < verbs_.size(); ++i)
      if (parsers_[i]->parsed()) verbs_[i]->Run(out);
    return ExitCode::kAllDone;
  }

 private:
  std::vector<std::unique_ptr<PatchdbVerb>> verbs_;
  std::vector<CLI::App*> parsers_;  // in the order of verbs_
};

}  // namespace

std::unique_ptr<Command> MakePatchdbCommand() { return std::make_unique<PatchdbCommand>(); }

}  // namespace orient
