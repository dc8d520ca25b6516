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
  std::optional<Vector6d> sigma;  // x y z [m] omega phi kappa [rad]
  // False: kappa is unknown and set to zero; omega and phi are zero where the table omits them.
  bool attitude_known = true;
  // Z was computed from a flying height: its sigma is at least this, whatever is stated elsewhere.
  double least_height_sigma_m = 0;
  std::optional<std::string> date = {};  // of the exposure, ISO 8601 (1961, 1961-07-30)
  std::string camera = {};               // that the column "camera" names, where there is one
};

struct OrientationTable {
  std::vector<OrientationRow> rows;
  std::optional<Crs> crs;              // from the .prj, where there is one
  std::set<std::string> cameras = {};  // that its rows name
  // Of approximations: photos whose x or y is empty, which have no row, and columns, as they are
  // written, that seem to hold angles but none that Orient reads.
  std::vector<std::string> without_position = {};
  std::vector<std::string> ignored_angles = {};

  const OrientationRow* Find(const std::string& photo) const;  // null where absent
};

// What a table may omit, by a missing column or an empty cell. kNone: nothing. For approximations,
// kAngles: the angles (kappa is then unknown, omega and phi zero to 3 degrees); kAnglesAndHeights:
// also z, which is NaN then. Columns of sigmas may be missing, and their cells empty, where the
// value's are. A photo's position may be omitted, too (see without_position).
enum class OpenCells { kNone, kAngles, kAnglesAndHeights };

// A column `date` is read where there is one; its cells may be empty. Throws InputError naming
// file, line, column and value; a photo named twice is an error.
OrientationTable ReadOrientationTable(const std::string& path, OpenCells open = OpenCells::kNone);

// With sigma columns where any row has sigmas (empty cells for the others). Writes `path` and its
// .prj beside and renames.
void WriteOrientationTable(const std::string& path, const OrientationTable& table);

// "dir/4711.tif" -> "4711": the photo's name in every table and result.
std::string PhotoName(const std::string& path);

}  // namespace orient
