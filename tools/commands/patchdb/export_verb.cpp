// orient patchdb export: GeoJSON, CSV, chips as GeoTIFF, or a part as a database of its own.

#include <CLI/CLI.hpp>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <ostream>
#include <sstream>

#include "core/base/error.h"
#include "core/base/new_file.h"
#include "patchdb/maintenance/merge.h"
#include "tools/commands/patchdb/filter_options.h"
#include "tools/commands/patchdb/geotiff.h"
#include "tools/commands/patchdb/spare_databases.h"
#include "tools/commands/patchdb/summary_csv.h"
#include "tools/commands/patchdb/verb.h"
#include "tools/commands/shared_options.h"

namespace orient {
namespace {

namespace fs = std::filesystem;

// Written beside and renamed, line by line, whatever its length.
class TextFile {
 public:
  explicit TextFile(const std::string& path) : file_(path) {}
  std::ostream& Stream() { return text_; }
  void EndLine() {
    constexpr std::streamoff kMuch = 1 << 20;
    text_ << "\n";
    if (text_.tellp() > kMuch) Flush();
  }
  void Finish() {
    Flush();
    file_.Keep();
  }

 private:
  void Flush() {
    file_.Write(text_.str());
    text_.str("");
  }

  NewFile file_;
  std::ostringstream text_;
};

nlohmann::json Properties(const patchdb::PatchSummary& patch) {
  nlohmann::json json = {{"id", patch.id},
                         {"x", patch.ground_m.x()},
                         {"y", patch.ground_m.y()},
                         {"z", patch.ground_m.z()},
                         {"gsd_m", patch.gsd_m},
                         {"source", patch.source_name},
                         {"state", Name(patch.life)},
                         {"views", patch.views},
                         {"success", patch.Belief().Mean()}};
  json["date"] = patch.source_date ? nlohmann::json(*patch.source_date) : nlohmann::json();
  json["quality"] = patch.quality ? nlohmann::json(*patch.quality) : nlohmann::json();
  json["distinctness"] =
      patch.distinctness ? nlohmann::json(*patch.distinctness) : nlohmann::json();
  json["retired_reason"] =
      patch.retired_reason.empty() ? nlohmann::json() : nlohmann::json(patch.retired_reason);
  return json;
}

std::string Dumped(const nlohmann::json& json) {
  return json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

class ExportVerb : public PatchdbVerb {
 public:
  CLI::App* Declare(CLI::App& app) override {
    CLI::App* verb = app.add_subcommand("export", "Export patches for other programs");
    verb->add_option("DB", path_, "Patch database")->required();
    verb->add_option("--geojson", geojson_, "File to write: points in longitude, latitude");
    verb->add_option("--csv", csv_, "File to write: the columns of 'list'");
    verb->add_option("--chips", chips_, "Folder to write: <id>.tif, one GeoTIFF per chip");
    verb->add_option("--subset", subset_, "Patch database to create from the chosen patches");
    choice_.DeclarePlace(*verb);
    choice_.DeclareRules(*verb);
    choice_.DeclareState(*verb);
    AddOverwriteOption(*verb, &overwrite_);
    return verb;
  }
  void Run(std::ostream& out) override {
    if (geojson_.empty() && csv_.empty() && chips_.empty() && subset_.empty())
      throw UsageError("export needs --geojson, --csv, --chips or --subset");
    std::vector<std::string> files;
    for (const std::string& file : {geojson_, csv_})
      if (!file.empty()) files.push_back(file);
    if (files.size() == 2 && fs::weakly_canonical(files[0]) == fs::weakly_canonical(files[1]))
      throw UsageError("--geojson and --csv name the same file, " + csv_);
    RefuseToOverwrite(files, overwrite_);
    RefuseToReplaceDatabase(files);
    const patchdb::PatchDatabase database =
        patchdb::PatchDatabase::Open(path_, patchdb::PatchDatabase::Mode::kRead);
    const patchdb::PatchFilter filter = choice_.Filter(database);
    if (!csv_.empty()) WriteCsv(database, filter, out);
    if (!geojson_.empty()) WriteGeoJson(database, filter, out);
    if (!chips_.empty()) WriteChips(database, filter, out);
    if (!subset_.empty()) WriteSubset(database, filter, out);
  }

 private:
  void WriteCsv(const patchdb::PatchDatabase& database, const patchdb::PatchFilter& filter,
                std::ostream& out) const {
    TextFile file(csv_);
    PrintSummaryHeader(file.Stream());
    file.EndLine();
    int count = 0;
    patchdb::VisitPatches(database, filter, [&](const patchdb::PatchSummary& patch) {
      PrintSummary(patch, file.Stream());
      file.EndLine();
      ++count;
    });
    file.Finish();
    out << csv_ << ": " << count << " patches\n";
  }

  void WriteGeoJson(const patchdb::PatchDatabase& database, const patchdb::PatchFilter& filter,
                    std::ostream& out) const {
    const auto degrees = CoordinateTransform::Between("EPSG:4326", database.GroundCrs().Wkt());
    TextFile file(geojson_);
    file.Stream() << "{\"type\":\"FeatureCollection\",\"features\":[";
    int count = 0;
    patchdb::VisitPatches(database, filter, [&](const patchdb::PatchSummary& patch) {
      const auto place = degrees(patch.ground_m.head<2>());
      if (!place) return;
      const nlohmann::json feature = {
          {"type", "Feature"},
          {"geometry",
           {{"type", "Point"}, {"coordinates", {place->x(), place->y(), patch.ground_m.z()}}}},
          {"properties", Properties(patch)}};
      if (count++ > 0) file.Stream() << ",";
      file.EndLine();
      file.Stream() << Dumped(feature);
    });
    file.Stream() << "\n]}\n";
    file.Finish();
    out << geojson_ << ": " << count << " patches\n";
  }

  void WriteChips(const patchdb::PatchDatabase& database, const patchdb::PatchFilter& filter,
                  std::ostream& out) const {
    const std::vector<std::int64_t> ids = patchdb::ChooseIds(database, filter);
    std::vector<std::string> files;
    files.reserve(ids.size());
    for (const std::int64_t id : ids)
      files.push_back((fs::path(chips_) / (std::to_string(id) + ".tif")).string());
    RefuseToOverwrite(files, overwrite_);
    MakeOutputDirectory(chips_);
    for (std::size_t i = 0; i < ids.size(); ++i) {
      const auto patch = database.ReadPatch(ids[i]);
      if (!patch) continue;
      GeoTiff chip;
      chip.width = patch->chip.width;
      chip.height = patch->chip.height;
      chip.bits = patch->bits;
      chip.bands = patch->colour.empty() ? std::vector<Image>{patch->chip} : patch->colour;
      chip.pixel_m = patch->gsd_m;
      chip.origin_m = patch->ground_m.head<2>() +
                      0.5 * patch->gsd_m * Eigen::Vector2d(-chip.width, chip.height);
      WriteGeoTiff(files[i], chip, database.GroundCrs());
    }
    out << chips_ << ": " << ids.size() << " chips\n";
  }

  void WriteSubset(const patchdb::PatchDatabase& database, const patchdb::PatchFilter& filter,
                   std::ostream& out) const {
    patchdb::MergeOptions options;
    options.policy = patchdb::MergePolicy::kCopy;
    options.filter = filter;
    patchdb::MergeResult result;
    patchdb::PatchDatabase::Create(subset_, database.GroundCrs(),
                                   [&](patchdb::PatchDatabase& subset) {
                                     result = patchdb::MergeDatabase(subset, database, options);
                                   });
    out << subset_ << ": " << result.added << " patches of " << result.sources << " sources, "
        << result.attempts << " attempts\n";
  }

  std::string path_, geojson_, csv_, chips_, subset_;
  bool overwrite_ = false;
  FilterOptions choice_{"all"};
};

}  // namespace

std::unique_ptr<PatchdbVerb> MakeExportVerb() { return std::make_unique<ExportVerb>(); }

}  // namespace orient
