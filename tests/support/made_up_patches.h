// Patch databases with synthetic patches, for tests of their maintenance.
#pragma once

#include <random>
#include <string>
#include <vector>

#include "patchdb/store/patch_database.h"

namespace orient {

inline Crs MadeUpCrs() { return Crs::Parse("EPSG:32635", "test"); }

// A patch with a chip of 31 px, whose texture depends on `seed`.
inline patchdb::Patch MadeUpPatch(double x_m, double y_m, unsigned seed, double gsd_m = 0.5) {
  std::mt19937 random(seed);
  patchdb::Patch patch;
  patch.ground_m = {x_m, y_m, 120};
  patch.covariance_m2 = Eigen::Vector3d(0.04, 0.04, 0.25).asDiagonal();
  patch.gsd_m = gsd_m;
  patch.chip = Image(31, 31);
  for (float& value : patch.chip.values) value = static_cast<float>(random() % 256);
  patch.heights = {3, 20 * gsd_m, std::vector<float>(9, 120)};
  patch.quality = 0.75;
  return patch;
}

// `columns` x `rows` patches, `step_m` apart, the first at (west, south): ids row by row.
inline std::vector<patchdb::Patch> MadeUpPatches(int columns, int rows, double step_m,
                                                 double west_m = 500000, double south_m = 5000000) {
  std::vector<patchdb::Patch> patches;
  for (int row = 0; row < rows; ++row)
    for (int col = 0; col < columns; ++col)
      patches.push_back(MadeUpPatch(west_m + col * step_m, south_m + row * step_m,
                                    static_cast<unsigned>(row * columns + col)));
  return patches;
}

inline patchdb::PatchSource MadeUpSource(const std::string& name,
                                         const std::optional<std::string>& date = {}) {
  return {0, patchdb::SourceKind::kPhoto, name, date, 0.5, {}, {}, {}};
}

inline patchdb::PatchDatabase MadeUpDatabase(const std::string& path, int columns, int rows,
                                             double step_m = 100) {
  patchdb::PatchDatabase database = patchdb::PatchDatabase::Create(path, MadeUpCrs());
  patchdb::PatchSource source = MadeUpSource("1990.tif", "1990-07-01");
  std::vector<patchdb::Patch> patches = MadeUpPatches(columns, rows, step_m);
  database.AddSource(source, patches);
  return database;
}

inline patchdb::MatchAttempt MadeUpAttempt(std::int64_t patch, const std::string& photo,
                                           bool matched, const std::string& photo_status = "ok") {
  patchdb::MatchAttempt attempt;
  attempt.patch_id = patch;
  attempt.photo = photo;
  attempt.state = matched ? "matched" : "not_found";
  attempt.photo_status = photo_status;
  return attempt;
}

}  // namespace orient
