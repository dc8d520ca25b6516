// export.json and verification.csv: what `orient convert` leaves beside another program's files, so
// that they can be checked and read back.
#pragma once

#include <Eigen/Core>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "core/terrain/crs.h"

namespace orient {

// What is in the lens of one of the files' cameras of curvature and refraction, and what had to be
// taken out of it because the file's ground system is curved itself: k1 times the principal
// distance squared, which is the same whatever unit the file's cameras are in.
struct EarthRecord {
  double in_lens = 0, taken_out = 0;
};

// export.json. Everything is empty where there is no such file.
struct ExportRecord {
  std::string format;
  std::optional<Crs> crs;                            // of the block
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  // subtracted from ground coordinates
  double geoid_m = 0;
  std::optional<double> ground_height_m;  // mean, of the block
  std::vector<EarthRecord> earth;         // of each camera, in the order of the file's
  // Photos' true names by the files', of those that differ: see program_names.h.
  std::map<std::string, std::string> names = {};
  // What the export consists of, relative to its folder, in which other programs may work.
  std::set<std::string> files = {};
};
void WriteExportRecord(const std::string& directory, const ExportRecord& record);
ExportRecord ReadExportRecord(const std::string& directory);

// One line of verification.csv: a ground point and where Orient's own collinearity puts it.
struct VerificationRow {
  std::string image;
  Eigen::Vector3d block_m = Eigen::Vector3d::Zero();  // in the block's CRS
  Eigen::Vector3d file_m = Eigen::Vector3d::Zero();   // in the file's ground system
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();    // Orient's: the first pixel's centre is 0.5
  // The same without distortion, relative to the principal point, y up; mm.
  Eigen::Vector2d reduced_mm = Eigen::Vector2d::Zero();
  double principal_distance_mm = 0, pixel_mm = 0;
};
void WriteVerification(const std::string& directory, const std::vector<VerificationRow>& rows);
std::string VerificationPath(const std::string& directory);
// Throws InputError naming file, line and value.
std::vector<VerificationRow> ReadVerification(const std::string& path);

}  // namespace orient
