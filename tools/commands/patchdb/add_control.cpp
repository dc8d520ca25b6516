#include "tools/commands/patchdb/add_control.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <ostream>

#include "block/inputs/harvest_sources.h"
#include "core/base/error.h"
#include "patchdb/harvest/control_points.h"
#include "tools/commands/patchdb/control_table.h"
#include "tools/commands/summary_table.h"

namespace orient {
namespace {

// The photos that any point is measured in, open, by the place of their path.
std::map<std::size_t, block::OpenSource> OpenMeasured(const std::vector<ControlTablePoint>& points,
                                                      const std::vector<std::string>& paths,
                                                      const block::HarvestSources& kind,
                                                      const GroundSurface& surface) {
  std::map<std::size_t, block::OpenSource> open;
  for (const ControlTablePoint& point : points)
    for (const MeasuredPoint& measured : point.measured)
      for (std::size_t i = 0; i < paths.size(); ++i)
        if (PhotoName(paths[i]) == measured.photo && !open.contains(i))
          open.emplace(i, kind.Open(i, surface, true));
  return open;
}

std::vector<patchdb::ControlSighting> SightingsOf(
    const ControlTablePoint& point, const std::vector<std::string>& paths,
    const std::map<std::size_t, patchdb::FurtherSource>& sources, const std::string& table) {
  std::vector<patchdb::ControlSighting> sightings;
  for (const MeasuredPoint& measured : point.measured) {
    const auto source = std::find_if(sources.begin(), sources.end(), [&](const auto& entry) {
      return PhotoName(paths[entry.first]) == measured.photo;
    });
    if (source == sources.end())
      throw InputError(table + ": point '" + point.point.id + "' is measured in photo '" +
                       measured.photo + "', which was not given; name it or remove the row");
    sightings.push_back({&source->second, measured.pixel});
  }
  return sightings;
}

// Evidence can only name photos that the database knows.
void NameEvidence(const patchdb::PatchDatabase& database, const std::vector<std::string>& paths,
                  const patchdb::PatchSource& about, std::vector<patchdb::Patch>* patches) {
  for (patchdb::Patch& patch : *patches) {
    std::vector<patchdb::PatchEvidence> known;
    for (patchdb::PatchEvidence evidence : patch.evidence) {
      const std::string& path = paths[static_cast<std::size_t>(evidence.source_id)];
      const auto id =
          database.FindSource(block::SourceOfFile(patchdb::SourceKind::kPhoto, path, about)).id;
      if (!id) continue;
      evidence.source_id = *id;
      known.push_back(evidence);
    }
    patch.evidence = known;
  }
}

}  // namespace

void AddControlPoints(patchdb::PatchDatabase& database, const ControlToAdd& control,
                      const block::PhotosToHarvest& photos, std::ostream& out) {
  const auto points = ReadControlTable(control.table);
  if (points.empty()) throw InputError(control.table + " holds no points");
  const patchdb::HarvestOptions options;
  const auto kind = block::PhotoSources(photos, options.orientation_sigma_px);
  Bounds bounds = Bounds::OfNothing();
  constexpr double kAround = 1000;  // m; more than a chip covers
  for (const ControlTablePoint& point : points)
    for (const double step : {-kAround, kAround})
      bounds.Include(point.point.ground_m.x() + step, point.point.ground_m.y() + step);
  const GroundSurface surface = GroundSurface::FromFile(control.dem, database.GroundCrs(), bounds);
  const auto open = OpenMeasured(points, photos.paths, *kind, surface);
  std::map<std::size_t, patchdb::FurtherSource> sources;
  for (const auto& [i, source] : open)
    sources[i] = {source.raster.get(), source.view.get(), nullptr, static_cast<int>(i)};
  std::vector<patchdb::Patch> patches;
  SummaryTable refused({"point", "refused because"});
  std::vector<double> gsds;
  for (const ControlTablePoint& point : points) {
    auto made = patchdb::MakeControlPatch(point.point,
                                          SightingsOf(point, photos.paths, sources, control.table),
                                          surface, control.chip_px);
    if (const auto* why = std::get_if<patchdb::ControlRefusal>(&made)) {
      refused.AddRow({point.point.id, std::string(Name(*why))});
      continue;
    }
    patches.push_back(std::move(std::get<patchdb::Patch>(made)));
    gsds.push_back(patches.back().gsd_m);
  }
  if (patches.size() < points.size()) refused.Print(out);
  if (patches.empty()) throw InputError(control.table + ": none of its points became a patch");
  std::sort(gsds.begin(), gsds.end());
  NameEvidence(database, photos.paths, control.about, &patches);
  patchdb::PatchSource source = control.about;
  source.kind = patchdb::SourceKind::kGcp;
  source.name = std::filesystem::path(control.table).filename().string();
  source.gsd_m = gsds[gsds.size() / 2];
  database.AddSource(source, patches);
  out << patches.size() << " of " << points.size() << " points added\n";
}

}  // namespace orient
