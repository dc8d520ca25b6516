#include "tools/commands/exterior_options.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>

#include "block/inputs/block_files.h"
#include "core/base/error.h"
#include "core/files/adjustment_result.h"
#include "core/files/orientation_table.h"
#include "tools/commands/shared_options.h"

namespace orient {
namespace {

// The table of a resumed run is of its own photos.
void RefuseOtherPhotos(const std::string& table, const std::vector<std::string>& photos) {
  if (!std::filesystem::exists(table)) return;
  for (const OrientationRow& row : ReadOrientationTable(table).rows)
    if (std::none_of(photos.begin(), photos.end(),
                     [&](const std::string& photo) { return PhotoName(photo) == row.photo; }))
      throw UsageError(table + " also has the photo " + row.photo +
                       ", and would be replaced; name all of its photos, choose another folder, "
                       "or give --overwrite");
}

}  // namespace

void ExteriorOptions::Setup(CLI::App& app) {
  const auto add = [&](CLI::Option* option) { asked_.push_back(option); };
  add(app.add_option("--approximations", options_.approximations,
                     "Approximate orientations (OPK CSV with its .prj beside it); required where "
                     "no ground points are measured"));
  add(app.add_option("--patchdb", options_.patchdb, "Patch database"));
  add(app.add_option("--interior", options_.interior,
                     "Folder with the results of 'orient interior'; required for film photos"));
  add(app.add_option("--position-sigma-m", options_.position_sigma_m,
                     "One sigma of approximate positions without sigma columns, metres "
                     "(default 10)"));
  add(app.add_option("--attitude-sigma-deg", attitude_sigma_deg_,
                     "One sigma of approximate angles without sigma columns, degrees "
                     "(default 3)"));
  add(app.add_option(
      "--kappa-sigma-deg", kappa_sigma_deg_,
      "One sigma of approximate kappas without sigma columns, if it differs from that "
      "of omega and phi; 180: unknown"));
  add(AddEarthOption(app, &options_.earth));
  add(app.add_option("--principal-distance-sigma-mm", options_.principal_distance_sigma_mm,
                     "Estimate the principal distance with each photo's pose; one sigma of the "
                     "camera file's, mm"));
  add(app.add_option(
      "--target-m", options_.target_m,
      "Accuracy on the ground that makes a photo ok: one sigma anywhere in its frame, "
      "metres (default: a pixel of the photo or half a pixel of the patches, "
      "whichever is larger)"));
  add(app.add_option("--date", options_.date,
                     "Date of exposure of photos without one in the table of approximations, "
                     "ISO 8601 (1961, 1961-07-30)"));
}

bool ExteriorOptions::AnyTold() const {
  return std::any_of(asked_.begin(), asked_.end(),
                     [](const CLI::Option* option) { return option->count() > 0; });
}

block::ExteriorRunOptions ExteriorOptions::For(const Measurements& measurements) const {
  block::ExteriorRunOptions options = options_;
  options.measurements = measurements;
  if (options.approximations.empty()) {
    if (measurements.image_points.empty())
      throw UsageError("--approximations is required where no ground points are measured");
    options.table = OrientationTable();
  }
  if (attitude_sigma_deg_) options.attitude_sigma_rad = RadFromDeg(*attitude_sigma_deg_);
  if (kappa_sigma_deg_) options.kappa_sigma_rad = RadFromDeg(*kappa_sigma_deg_);
  return options;
}

void RefuseToReplace(const block::ExteriorRunOptions& options, bool overwrite) {
  const auto path = [&](const char* file) {
    return (std::filesystem::path(options.out) / file).string();
  };
  const std::string table = path("orientation.csv");
  std::vector<std::string> results = {table};
  for (const std::string& photo : options.photos)
    results.push_back(ExteriorResultPath(options.out, PhotoName(photo)));
  RefuseToOverwrite(results, overwrite || options.resume, "--resume");
  if (options.resume && !overwrite) RefuseOtherPhotos(table, options.photos);
  RefuseToOverwrite(
      {AdjustmentResultPath(options.out), path(block::kQuicklookFile), path(block::kSeamsFile),
       path(block::kCalibratedCameraFile), path(block::kPoseCovarianceFile)},
      overwrite);
}

}  // namespace orient
