#include "tools/commands/harvested.h"

#include <array>
#include <numeric>
#include <ostream>

#include "block/inputs/block_camera.h"
#include "core/base/error.h"
#include "core/files/block_file.h"
#include "core/files/camera_file.h"
#include "core/files/orientation_table.h"
#include "tools/commands/shared_options.h"
#include "tools/commands/summary_table.h"

namespace orient {

void PrintHarvest(const std::vector<block::HarvestedSource>& sources, bool has_surface_model,
                  std::ostream& out) {
  SummaryTable table({"source", "patches", "good", "seen twice", "refused", "gsd [m]"});
  std::array<int, patchdb::kAllRefusals.size()> refused = {};
  std::ptrdiff_t patches = 0, seen_once = 0;
  for (const block::HarvestedSource& source : sources) {
    if (source.known) {
      table.AddRow({source.name + " (in the database already)", "-", "-", "-", "-", "-"});
      continue;
    }
    for (std::size_t i = 0; i < refused.size(); ++i) refused[i] += source.refused[i];
    const int all = std::accumulate(source.refused.begin(), source.refused.end(), 0);
    table.AddRow({source.name, std::to_string(source.patches), std::to_string(source.good),
                  std::to_string(source.seen_twice), std::to_string(all), Fixed(source.gsd_m, 3)});
    patches += source.patches;
    seen_once += source.patches - source.seen_twice;
  }
  table.Print(out);
  SummaryTable reasons({"refused because", "candidates"});
  bool any = false;
  for (const patchdb::Refusal refusal : patchdb::kAllRefusals)
    if (const int count = refused[static_cast<std::size_t>(refusal)]; count > 0) {
      reasons.AddRow({std::string(Name(refusal)), std::to_string(count)});
      any = true;
    }
  if (any) {
    out << "\n";
    reasons.Print(out);
    out << "\n";
  }
  out << patches << " patches added\n";
  if (!has_surface_model && seen_once > 0)
    out << "note    without --dsm roofs and trees cannot be distinguished from the ground in the "
        << seen_once << " of them that only one source shows\n";
}

void ReadPhotosToHarvest(const std::string& camera, const std::vector<std::string>& patterns,
                         const std::string& database_path, const patchdb::PatchDatabase& database,
                         block::PhotosToHarvest* photos) {
  block::RefuseBlockCamera(camera, photos->earth);
  block::RequireCameraOfPoses(camera, photos->orientation_path);
  photos->camera = ReadCameraFile(camera);
  photos->orientation = ReadOrientationTable(photos->orientation_path);
  const auto& crs = photos->orientation.crs;
  if (crs && !crs->SameAs(database.GroundCrs()))
    throw InputError(photos->orientation_path + " is in " + crs->Name() + ", " + database_path +
                     " in " + database.GroundCrs().Name() + "; both must be in one CRS");
  photos->paths = PhotosOf(patterns);
}

}  // namespace orient
