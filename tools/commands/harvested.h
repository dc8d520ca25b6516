// What harvests from the command line and from a block file have in common.
#pragma once

#include <iosfwd>
#include <string>
#include <vector>

#include "block/stages/harvest_stage.h"
#include "patchdb/store/patch_database.h"

namespace orient {

// A row per source, and how many candidates were refused for which reason.
void PrintHarvest(const std::vector<block::HarvestedSource>& sources, bool has_surface_model,
                  std::ostream& out);

// Fills `photos`, whose orientation_path and earth are given. Throws UsageError where the
// orientation is not true with the camera, InputError where it is in another CRS than the database.
void ReadPhotosToHarvest(const std::string& camera, const std::vector<std::string>& patterns,
                         const std::string& database_path, const patchdb::PatchDatabase& database,
                         block::PhotosToHarvest* photos);

}  // namespace orient
