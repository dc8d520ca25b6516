// A large patch database divided into regions (patchdb/regions/region_index.h).
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "patchdb/regions/region_index.h"
#include "patchdb/store/patch_database.h"

namespace orient::patchdb {

// Told of regions done and in all.
using DivideProgress = std::function<void(int done, int total)>;

// Copies every patch of `database`, retired ones too, with source and history, into the database of
// the square cell it lies in: folder/x<west>_y<south>.gpkg, and lists these. The cells' corners are
// multiples of cell_m, and belong to the cells north and east of them. An interrupted division goes
// on when it is started again. What a patch of one cell was superseded by in another one is not
// kept. Throws InputError: the folder is not empty and holds no interrupted division of this
// database, a patch whose place is damaged, no patches at all, a database that is changed
// meanwhile; UsageError: more than 100,000 cells.
RegionIndex DivideDatabase(const PatchDatabase& database, const std::string& folder, double cell_m,
                           const DivideProgress& progress = {});

}  // namespace orient::patchdb
