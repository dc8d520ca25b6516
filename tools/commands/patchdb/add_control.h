// Ground control points added to a patch database.
#pragma once

#include <iosfwd>
#include <string>

#include "block/stages/harvest_stage.h"

namespace orient {

struct ControlToAdd {
  std::string table;
  std::string dem;
  patchdb::PatchSource about;
  int chip_px = 61;
};
// Stores points measured in these photos as one source of kind gcp that bears the table's name, in
// one transaction. Prints which ones were refused and why. Throws InputError: a wrong table, a
// photo that was not given, no point left, a table added before.
void AddControlPoints(patchdb::PatchDatabase& database, const ControlToAdd& control,
                      const block::PhotosToHarvest& photos, std::ostream& out);

}  // namespace orient
