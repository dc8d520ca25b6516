// The OPK CSV that orthorectifiers read: filename,x,y,z,omega,phi,kappa in metres and degrees, the
// CRS beside it as WKT in a .prj of the same name.
#pragma once

#include <optional>
#include <set>
#include <string>
#include <vector>

#include "core/geometry/pose.h"
#include "core/terrain/crs.h"

namespace orient {

struct OrientationRow {
  std::string photo;  // file name without its extension
  Pose pose;
  std::optional<Vector6d> sigma;         // x y z [m] omega phi kappa [rad]
  bool attitude_known = true;            // false: the angles are zero and say nothing of kappa
  std::optional<std::string> date = {};  // of the exposure, ISO 8601 (1961, 1961-07-30)
};

struct OrientationTable {
  std::vector<OrientationRow> rows;
  std::optional<Crs> crs;              // from the .prj, where there is one
  std::set<std::string> cameras = {};  // that its column "camera" names, where there is one

  const OrientationRow* Find(const std::string& photo) const;  // null where absent
};

// Whether a table may lack its three columns of angles (positions alone; with sigma_x, sigma_y and
// sigma_z only, omega and phi are taken to be good to 3 degrees and kappa for unknown).
enum class Attitudes { kRequired, kMayBeAbsent };

// A column `date` is read where there is one; its cells may be empty. Throws InputError naming
// file, line, column and value; a photo named twice is an error.
OrientationTable ReadOrientationTable(const std::string& path,
                                      Attitudes attitudes = Attitudes::kRequired);

// With sigma columns where any row has sigmas (empty cells for the others). Writes `path` and its
// .prj beside and renames.
void WriteOrientationTable(const std::string& path, const OrientationTable& table);

// "dir/4711.tif" -> "4711": the photo's name in every table and result.
std::string PhotoName(const std::string& path);

}  // namespace orient
