// What is known of photos before they are oriented.
#pragma once

#include <optional>
#include <string>

#include "core/files/orientation_table.h"
#include "core/geometry/rotation.h"

namespace orient::block {

// Assumed accuracy of an approximation where it is not stated.
inline constexpr double kPositionSigma_m = 10;
inline const double kAttitudeSigma_rad = RadFromDeg(3);

// The row's own, otherwise these, otherwise the above; kappa is unknown where the row says so.
Vector6d SigmaOfApproximation(const OrientationRow& row, std::optional<double> position_m,
                              std::optional<double> attitude_rad,
                              std::optional<double> kappa_rad = std::nullopt);

// Whether ReadApproximations takes this for a table of the photos (CSV), not for a flight index.
bool IsOrientationTable(const std::string& path);

// Whether points of a vector file may lack heights, which are NaN then.
enum class Heights { kRequired, kMayBeAbsent };

// One of
//   an OPK CSV (see ReadOrientationTable);
//   a CSV without the columns omega, phi and kappa: positions alone (GNSS, a flight report);
//   points of any vector file that GDAL reads (GeoJSON, shapefile, GeoPackage: a flight index), in
//   `crs` afterwards whatever theirs is; the photo's name is the column filename, photo, image,
//   name or id, the first that is there, and the height the point's own, or else the column z,
//   height, altitude, alt or flying_height (m).
// Where attitudes are absent, photos are taken for nearly vertical and kappa for unknown
// (OrientationRow::attitude_known). Throws InputError naming the file and what is missing.
OrientationTable ReadApproximations(const std::string& path, const Crs& crs,
                                    Heights heights = Heights::kRequired);

}  // namespace orient::block
