// What is known of photos before they are oriented.
#pragma once

#include <optional>
#include <set>
#include <string>
#include <vector>

#include "core/files/finding.h"
#include "core/files/flight_plan.h"
#include "core/files/orientation_table.h"
#include "core/geometry/rotation.h"
#include "core/terrain/ground_surface.h"

namespace orient::block {

// Assumed accuracy of an approximation where it is not stated.
inline constexpr double kPositionSigma_m = 10;
inline const double kAttitudeSigma_rad = RadFromDeg(3);

// The row's sigmas, else the arguments, else the defaults above; kappa unknown if the row says so.
Vector6d SigmaOfApproximation(const OrientationRow& row, std::optional<double> position_m,
                              std::optional<double> attitude_rad,
                              std::optional<double> kappa_rad = std::nullopt);

// Whether ReadApproximations takes this for a table of the photos (CSV), not for a flight index.
bool IsOrientationTable(const std::string& path);

// Whether positions may lack heights, which are NaN then (see CompleteHeights).
enum class Heights { kRequired, kMayBeAbsent };

// One of
//   an OPK CSV (see ReadOrientationTable), in which columns and cells of angles may be missing:
//   without any, positions alone (GNSS, a flight report);
//   points of any vector file that GDAL reads (GeoJSON, shapefile, GeoPackage: a flight index), in
//   `crs` afterwards whatever theirs is; the photo's name is the column filename, photo, image,
//   name or id, the first that is there, and the height the point's own, or else the column z,
//   height, altitude, alt or flying_height (m).
// Where attitudes are absent, photos are taken for nearly vertical and kappa for unknown
// (OrientationRow::attitude_known). Throws InputError naming the file and what is missing.
OrientationTable ReadApproximations(const std::string& path, const Crs& crs,
                                    Heights heights = Heights::kRequired);

// Throws InputError naming the file where its .prj says another CRS than the block's.
void RequireCrs(const Crs& crs, const OrientationTable& table, const std::string& path);

// The first five, as a message names them.
std::string Listed(const std::vector<std::string>& names);

// What a person should know of a table read so: columns of angles and rows that are not used.
Findings RemarksOn(const OrientationTable& table, const std::string& path);

// Names the photos of such rows that are none of `photos`, the block's, in `remarks`; and those of
// a table, whose scans may be missing, in `not_there`, too: a flight index shows the whole flight,
// of which a block may be a part.
void NameOtherPhotos(const std::vector<OrientationRow>& rows, const std::string& path,
                     const std::set<std::string>& photos, Findings* remarks,
                     std::vector<std::string>* not_there);

// Names the photos of strips that are none of `photos`, the block's.
void NameAbsentOfStrips(const FlightPlan& flight, const std::set<std::string>& photos,
                        Findings* remarks);

// Throws InputError where the table says that these photos were taken with several cameras: what
// is done with one camera file would be wrong for some of them.
void RequireOneCamera(const OrientationTable& table, const std::string& path,
                      const std::set<std::string>& photos);

// The ground under these positions and within `reach_m` of them.
GroundSurface SurfaceAround(const std::string& dem, const Crs& crs,
                            const std::vector<OrientationRow>& rows, double reach_m);

// Height of the ground at this place; where the DEM has a hole there, the median of those within
// reach, and the surface's mean only where there are none.
double GroundAround(const GroundSurface& surface, const Eigen::Vector3d& place, double reach_m);

// One sigma of the photos' flying heights above the ground, as a share of the flight's.
inline constexpr double kFlyingHeightSpread = 0.05;

// Z of a photo at `place`, `flying_height_m` above ground; the surface must reach as far around it.
double HeightOver(const GroundSurface& surface, const Eigen::Vector3d& place,
                  double flying_height_m);

// Sets z of rows where it is NaN to the flying height above the DEM, with sigmas, stated or not,
// that are not below the spread of heights within a flight. Returns the photos of these rows.
std::set<std::string> CompleteHeights(const std::string& dem, const Crs& crs,
                                      double flying_height_m, std::vector<OrientationRow>* rows);

}  // namespace orient::block
