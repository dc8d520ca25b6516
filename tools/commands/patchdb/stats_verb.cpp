// orient patchdb stats: tables of sources and successes, and a map of the density.

#include <CLI/CLI.hpp>
#include <numeric>
#include <ostream>

#include "core/base/error.h"
#include "patchdb/maintenance/statistics.h"
#include "tools/commands/patchdb/geotiff.h"
#include "tools/commands/patchdb/spare_databases.h"
#include "tools/commands/patchdb/verb.h"
#include "tools/commands/shared_options.h"
#include "tools/commands/summary_table.h"

namespace orient {
namespace {

std::string Share(std::int64_t part, std::int64_t whole) {
  if (whole == 0) return "-";
  return Fixed(100.0 * static_cast<double>(part) / static_cast<double>(whole), 1);
}

void PrintSuccesses(const char* title, const std::vector<patchdb::SuccessCount>& groups,
                    std::ostream& out) {
  if (groups.empty()) return;
  SummaryTable table({title, "attempts", "matched", "matched [%]"});
  for (const patchdb::SuccessCount& group : groups)
    table.AddRow({group.group, std::to_string(group.attempts), std::to_string(group.matched),
                  Share(group.matched, group.attempts)});
  out << "\n";
  table.Print(out);
}

class StatsVerb : public PatchdbVerb {
 public:
  CLI::App* Declare(CLI::App& app) override {
    CLI::App* verb = app.add_subcommand("stats", "Count sources, successes and density");
    verb->add_option("DB", path_, "Patch database")->required();
    verb->add_option("--density", density_, "GeoTIFF to write: active patches per cell");
    verb->add_flag("--overwrite", overwrite_, "Replace the GeoTIFF if it exists");
    verb->add_option("--cell-m", cell_m_, "Side of its cells in metres")
        ->check(CLI::Range(0.01, 1e7));
    return verb;
  }
  void Run(std::ostream& out) override {
    RefuseToReplaceDatabase({density_});
    if (!density_.empty()) RefuseToOverwrite({density_}, overwrite_);
    const patchdb::PatchDatabase database =
        patchdb::PatchDatabase::Open(path_, patchdb::PatchDatabase::Mode::kRead);
    const patchdb::PatchStatistics statistics = patchdb::CountEverything(database);
    SummaryTable sources({"source", "kind", "date", "patches", "retired"});
    for (const patchdb::SourceCount& source : statistics.sources)
      sources.AddRow({source.name, source.kind, source.date.empty() ? "-" : source.date,
                      std::to_string(source.patches), std::to_string(source.retired)});
    sources.Print(out);
    PrintSuccesses("age, from", statistics.by_age, out);
    PrintSuccesses("month", statistics.by_season, out);
    if (!statistics.retired.empty()) {
      SummaryTable reasons({"retired because", "patches"});
      for (const patchdb::SuccessCount& reason : statistics.retired)
        reasons.AddRow(
            {reason.group.empty() ? "-" : reason.group, std::to_string(reason.attempts)});
      out << "\n";
      reasons.Print(out);
    }
    PrintDensity(database, out);
  }

 private:
  void PrintDensity(const patchdb::PatchDatabase& database, std::ostream& out) const {
    const patchdb::DensityGrid grid = patchdb::CountDensity(database, cell_m_);
    const auto filled =
        std::count_if(grid.counts.begin(), grid.counts.end(), [](int count) { return count > 0; });
    if (filled > 0) {
      const double patches = std::accumulate(grid.counts.begin(), grid.counts.end(), 0.0);
      out << "\n"
          << filled << " cells of " << Fixed(cell_m_, 0) << " m have active patches, "
          << Fixed(patches / static_cast<double>(filled), 1) << " each on average\n";
    }
    if (density_.empty()) return;
    if (grid.counts.empty()) throw InputError(path_ + " has no patches to map");
    GeoTiff map;
    map.width = grid.width;
    map.height = grid.height;
    map.bits = 32;
    map.origin_m = {grid.west_m, grid.north_m};
    map.pixel_m = grid.cell_m;
    map.bands = {Image(grid.width, grid.height)};
    std::transform(grid.counts.begin(), grid.counts.end(), map.bands[0].values.begin(),
                   [](int count) { return static_cast<float>(count); });
    WriteGeoTiff(density_, map, database.GroundCrs());
    out << density_ << " written\n";
  }

  std::string path_, density_;
  bool overwrite_ = false;
  double cell_m_ = 1000;
};

}  // namespace

std::unique_ptr<PatchdbVerb> MakeStatsVerb() { return std::make_unique<StatsVerb>(); }

}  // namespace orient
