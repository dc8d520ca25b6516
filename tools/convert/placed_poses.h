// Whether poses can really be in the CRS that is given for them.
#pragma once

#include <string>

#include "core/files/orientation_table.h"
#include "tools/convert/foreign_block.h"
#include "tools/convert/ground_frame.h"

namespace orient {

// Throws InputError naming `input` and what to do where the mean projection centre lies far outside
// the area of the CRS, or, of geocentric poses, far from the earth's surface: the files lack their
// origin. The block is still in its file's system.
void RequirePlaced(const ForeignBlock& foreign, const GroundFrame& frame, const Crs& crs,
                   const std::string& input);

// The same of a table that is in the CRS: degrees, another zone, an easting without its zone.
void RequireInArea(const OrientationTable& table, const Crs& crs, const std::string& path);

}  // namespace orient
