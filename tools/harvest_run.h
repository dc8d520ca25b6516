// Harvests several sources into a patch database, one after another: every source with the others
// that show the same ground as witnesses.
#pragma once

#include <iosfwd>
#include <optional>
#include <string>
#include <vector>

#include "core/files/orientation_table.h"
#include "core/geometry/camera.h"
#include "core/geometry/earth_effects.h"
#include "patchdb/harvest.h"
#include "patchdb/patch_database.h"

namespace orient {

struct HarvestRun {
  std::string dem;
  std::string dsm;    // empty: none
  PatchSource about;  // date, provenance and licence of every source
  HarvestOptions options;
};

struct PhotosToHarvest {
  std::vector<std::string> paths;
  Camera camera;
  OrientationTable orientation;
  std::string orientation_path;
  std::string interior_folder;         // empty: a digital camera
  EarthMode earth = EarthMode::kAuto;  // what the orientation was made with
};

// What the database tells this file from others by: kind, name and content.
PatchSource SourceOfFile(SourceKind kind, const std::string& path, const PatchSource& about);

// Every source is one transaction; those in the database already are left alone, but give evidence.
// Prints what came of it. Throw InputError where an input is wrong: before anything is stored where
// that can be known.
void HarvestPhotos(PatchDatabase& database, const HarvestRun& run, const PhotosToHarvest& photos,
                   std::ostream& out);
void HarvestOrthophotos(PatchDatabase& database, const HarvestRun& run,
                        const std::vector<std::string>& paths, std::ostream& out);

}  // namespace orient
