// Block files (TOML): what belongs to one block and how well it is known beforehand.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/files/flight_plan.h"
#include "core/files/results.h"
#include "core/geometry/gnss.h"
#include "core/geometry/transform2d.h"
#include "core/terrain/crs.h"
#include "core/terrain/earth_effects.h"

namespace orient {

// Block adjustment, after every photo has been oriented on its own.
struct BlockAdjustmentChoice {
  bool ties = true;               // measure tie points and adjust all photos together
  double check_share = 0;         // of the control patches, held out to check the result
  bool self_calibration = false;  // of principal distance, principal point and lens
  bool pose_covariance = false;   // written for all poses together
  int sub_block_photos = 10'000;  // a larger block is adjusted in sub-blocks of so many at most
};

// Observed projection centres.
struct GnssChoice {
  std::string positions;          // a table or flight index; empty: none
  std::optional<double> sigma_m;  // one sigma of each coordinate, where the table has none
  GnssModel model = GnssModel::kShift;
};

// Orthophotos after the block's run.
struct OrthoChoice {
  std::optional<double> gsd_m;  // empty: what the photos' pixels show
  double dem_sigma_m = 0;       // accuracy of the heights
  bool mosaic = true;
  bool weak = false;              // also of photos that are weak
  bool least_difference = false;  // the mosaic's seamlines run where the photos differ least
  bool balance = false;           // the photos have one tone in the mosaic
};

// Images of known ground from which the run makes its patch database: orthophotos, or photos with
// their camera, orientation table and, for film, folder of interior orientations.
struct ControlChoice {
  std::vector<std::string> orthophotos, photos;
  std::string camera, orientation, interior;
  std::string dsm;                    // empty: none
  std::optional<double> dem_sigma_m;  // empty: a tenth of the DEM's cell
  std::optional<std::string> date;    // of the images, ISO 8601
  std::optional<int> chip_px;         // side of a chip, odd
};

// A photo named in the block file that cannot be used: only that photo fails, not the run.
struct UnusablePhoto {
  std::string name, reason;
};

struct BlockFile {
  Crs crs;
  std::string dem = {};      // paths are resolved against the block file's folder
  std::string patchdb = {};  // or a folder of them; with `control` the run makes and names it
  std::optional<ControlChoice> control = {};
  std::string camera = {};                   // or a name of the camera library
  std::vector<std::string> photos = {};      // globs expanded, sorted, without duplicates
  std::vector<UnusablePhoto> unusable = {};  // not there, or several files of one name
  std::string approximations = {};           // empty: from the photos' files and the strips
  FlightPlan flight = {};                    // empty: nothing is said of strips
  // One sigma of approximations without sigma columns; empty where it is not stated.
  std::optional<double> position_sigma_m = {};
  std::optional<double> attitude_sigma_rad = {};
  std::optional<std::string> date = {};  // of photos without one in the table, ISO 8601
  std::optional<double> target_m = {};   // accuracy on the ground that makes a photo ok
  bool observe_approximations = false;   // as observations of the adjustment, too
  std::optional<double> pixel_size_um = {};
  std::optional<Polarity> polarity = {};            // empty: auto
  std::optional<ScanOrientation> orientation = {};  // empty: auto
  EarthMode earth = EarthMode::kAuto;               // curvature and refraction
  std::string measurements = {};  // folder of what people measured and decided; empty: none
  std::string output_directory = {};
  // By image measurements alone: neither photos nor a patch database.
  bool ByMeasurementsAlone() const { return patchdb.empty(); }
  std::vector<std::string> formats = {};  // of exports, as orient convert --to takes them
  BlockAdjustmentChoice adjustment = {};
  GnssChoice gnss = {};
  std::optional<OrthoChoice> ortho = {};  // empty: none are made
};

// Throws InputError: wrong keys, a photo in two strips, a glob that matches nothing, no photo that
// can be worked on.
BlockFile ReadBlockFile(const std::string& path);

// Globs ("scans/*.tif"), plain paths and "@FILE", a file with one of these a line, relative to
// `base`; a pattern without a match throws InputError. /vsi paths pass through.
std::vector<std::string> ExpandPhotos(const std::vector<std::string>& patterns,
                                      const std::string& base);

}  // namespace orient
