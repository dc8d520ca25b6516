// Options of a simulated block.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "core/files/results.h"
#include "core/geometry/transform2d.h"
#include "core/terrain/earth_effects.h"

namespace orient {

// kDemo: 6 cm film; kRc10, kRc30, kLmk: 23 cm film with 4, 8 and 4 marks; kUmk: 13 x 18 cm; kP31
// and kReseau: thin crosses in the picture; kDigital: a digital frame.
enum class CameraPreset { kDemo, kRc10, kRc30, kLmk, kUmk, kP31, kReseau, kDigital };

struct SimulationOptions {
  std::uint32_t seed = 1;

  // The block.
  int photos = 3;                // new photos, to be oriented
  int strips = 1;                // in which they lie
  double gsd_m = 0.25;           // of the new photos at the ground's mean height
  double forward_overlap = 0.6;  // share of a photo
  double side_overlap = 0.3;
  double kappa_deg = 12;  // of the first strip; every other strip is flown back
  double tilt_deg = 1.2;  // sigma of omega and phi
  double relief_m = 60;   // highest minus lowest ground
  double hills_m = 1400;  // their longest wave; mountains are longer
  double dem_cell_m = 5;
  std::string crs = "EPSG:32635";
  EarthMode earth = EarthMode::kAuto;  // curvature and refraction in the photos
  double change = 0.2;                 // share of the parcels that look different on the new photos
  double inverted = 0.5;               // share of those whose contrast is inverted
  bool objects = true;                 // buildings and trees, which are not in the DEM

  // The new photos' camera and scans.
  CameraPreset camera = CameraPreset::kDemo;
  std::optional<double> pixel_size_um;  // of the scan; default: the preset's
  // Empty: another one for every photo.
  std::optional<ScanOrientation> orientation = ScanOrientation::kR0;
  Polarity polarity = Polarity::kPositive;
  int bits = 8;
  double scan_rotation_deg = 0.5;  // sigma of the film's rotation on the scanner
  double film_shrink_ppm = 300;    // sigma of the affine film deformation
  double film_bend_um = 2;         // the smooth rest of it, root mean square over the frame
  double grain = 3;                // sigma in grey values of 8 bit
  double blur_px = 0.6;            // sigma of the scanner's point spread
  int missing_marks = 0;           // in every photo
  int dirty_marks = 0;
  bool mark_symbols = false;  // lines beside the marks: 1, 2, 3, ...

  // The old photos.
  bool old_film = false;          // scanned film instead of digital frames
  double old_gsd_ratio = 1.15;    // old pixel on the ground / new pixel
  double old_height_ratio = 1.5;  // old flying height above ground / new
  double old_kappa_deg = 97;      // of the old photos relative to the new ones'
  bool ortho = false;             // also an orthophoto of the old date

  // What is known beforehand: sigma of the approximations' errors.
  double position_error_m = 10;
  double attitude_error_deg = 3;

  bool overwrite = false;

  // What is wrong with the options, if anything.
  std::optional<std::string> Check() const;
};

}  // namespace orient
