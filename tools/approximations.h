// What is known of photos before they are oriented.
#pragma once

#include <string>

#include "core/files/orientation_table.h"

namespace orient {

// One of
//   an OPK CSV (see ReadOrientationTable);
//   a CSV without the columns omega, phi and kappa: positions alone (GNSS, a flight report);
//   points of any vector file that GDAL reads (GeoJSON, shapefile, GeoPackage: a flight index), in
//   `crs` afterwards whatever theirs is; the photo's name is the column filename, photo, image,
//   name or id, the first that is there, and the height the point's own, or else the column z,
//   height, altitude, alt or flying_height (m).
// Where attitudes are absent, photos are taken for nearly vertical and kappa for unknown
// (OrientationRow::attitude_known). Throws InputError naming the file and what is missing.
OrientationTable ReadApproximations(const std::string& path, const Crs& crs);

}  // namespace orient
