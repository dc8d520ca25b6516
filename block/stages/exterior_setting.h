// What all photos of a run of exterior orientations share.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/files/camera_file.h"
#include "core/files/inputs.h"
#include "core/files/orientation_table.h"
#include "core/files/results.h"
#include "core/geometry/bounds.h"
#include "core/geometry/resection.h"
#include "core/measurements/measurements.h"
#include "core/terrain/crs.h"
#include "core/terrain/earth_effects.h"
#include "core/terrain/ground_surface.h"
#include "interior/marks/mark_drawing.h"
#include "patchdb/regions/control_patches.h"

namespace orient::block {

struct ExteriorRunOptions {
  std::vector<std::string> photos;  // paths
  std::string camera;
  std::string approximations;             // of a file; empty: none, or `table`
  std::optional<OrientationTable> table;  // instead of what the file says
  std::optional<double> flying_height_m;  // above the ground, of positions without heights
  Measurements measurements;              // what people said of the photos
  std::string dem;
  std::string patchdb;  // or a folder of them (patchdb/regions/region_index.h)
  std::string out;
  bool alone = false;  // refused where another program writes into `out`; a block sees to that
  std::optional<std::string> pictures;  // folder of <photo>.patches.png; otherwise `out`
  std::optional<std::string> interior;  // folder of <photo>.interior.json; film cameras need it
  std::optional<Crs> crs;               // of the block; otherwise the patch database's
  // One sigma, for photos whose approximation has no sigma columns; default 10 m and 3 degrees.
  std::optional<double> position_sigma_m;
  std::optional<double> attitude_sigma_rad;
  std::optional<double> kappa_sigma_rad;  // where kappa is known worse than omega and phi
  std::optional<std::string> date;        // of exposures without one in the table, ISO 8601
  // Accuracy on the ground (one sigma, anywhere in the frame) that makes a photo ok; otherwise
  // exterior::DefaultTarget.
  std::optional<double> target_m;
  // Whether sigmas, including the table's, were stated by the user: a pose that contradicts them is
  // then weak.
  bool accuracy_is_stated = true;
  // More patches than the database's that lie in a photo's uncertain footprint; called from several
  // threads.
  std::function<std::vector<patchdb::Patch>(const std::string& photo, const Bounds& footprint)>
      further_patches;
  // Which photos to orient next (indices) and with which approximations, asked before the first and
  // whenever those asked for are done; none: the end. Results that are not there yet have no
  // photo's name. All at once otherwise.
  std::function<std::vector<std::size_t>(const std::vector<ExteriorResult>& so_far,
                                         OrientationTable* table)>
      next_photos;
  // What all photos' results are made from, as a block knows it. Empty: `orient exterior`, which
  // finds out by itself.
  Inputs inputs;
  EarthMode earth = EarthMode::kAuto;  // curvature and refraction
  std::optional<double> earth_k1;      // what they are, where that is decided already (0: none)
  // One sigma of the camera file's principal distance, which each photo then estimates for itself;
  // otherwise it is taken as true.
  std::optional<double> principal_distance_sigma_mm;
  bool learn = false;           // record in the patch database what matched
  bool leave_to_learn = false;  // leave it to a later run to record
  // With `resume`, those that do not say what they were made from, too (set by a run alone).
  bool keep_unstated = false;
  bool resume = false;  // keep results that are there
  int jobs = 0;         // photos at a time; 0: one per core

  std::optional<std::string> Check() const;  // what is wrong with the options, if anything
};

// What all photos of a run share; read before the first photo starts.
struct ExteriorSetting {
  const ExteriorRunOptions& options;
  CameraFile camera;           // with curvature and refraction in its lens
  double earth_k1 = 0;         // of it, what this run added to the camera file's lens
  interior::MarkShapes marks;  // a film camera's; empty for a digital one
  OrientationTable approximations;
  Crs crs;
  GroundSurface surface;
  // Of a folder of databases: its list, read once.
  std::optional<patchdb::ControlPatches> regions = {};
};

// Throws InputError naming both where the database's CRS is another one, or it cannot be read.
void RequireCrsOfPatches(const std::string& patchdb, const Crs& crs);

// Throws InputError or UsageError for what concerns all photos: camera, tables, DEM, database, CRS.
ExteriorSetting PrepareExterior(const ExteriorRunOptions& options);

// Curvature and refraction as the run puts them into its camera's lens, 0 where they are not wanted
// or do not matter. Reads camera, table and DEM and throws as PrepareExterior does; needs no
// database where the options or the table name the CRS.
double EarthK1OfRun(const ExteriorRunOptions& options);

// Where a photo with this prior may lie: the area whose patches are used, at kStatedSigmas, or
// widely (exterior::Widened) at kWideSigmas.
inline constexpr double kStatedSigmas = 3, kWideSigmas = 2;
Bounds AreaOf(const ExteriorSetting& setting, const PosePrior& prior, double sigmas);

// Changes with what the patch database offers the run's photos (patchdb::ContentOf); for a folder
// of regions, only with the regions in which the photos, searched for widely, may lie.
std::string PatchContentOfRun(const ExteriorRunOptions& options);

}  // namespace orient::block
