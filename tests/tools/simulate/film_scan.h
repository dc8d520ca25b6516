// The scan of one film frame without a photographed block: what interior orientation looks at. The
// picture is an invented pattern of fields, roads and grain, and only what lies near marks and
// border is drawn; the rest of the file is sparse (black), so that a scan of 11000 x 11000 px takes
// a second.
#pragma once

#include <string>

#include "tools/simulate/photo_making.h"

namespace orient::simulation {

struct FilmScanOptions {
  float mark_tone = 0.92f;  // of the marks on a positive; the rebate around them has 0.06
  bool rgb = false;         // three bands, of a warm tint
};

// Brightness (0 to 1) of the invented picture at a place of the film.
float PictureTone(std::uint32_t seed, const Eigen::Vector2d& photo_mm);

// A tiled TIFF with resolution tags. `options` as for MakePhoto; the truth is
// TrueInterior(camera, plan). Throws InputError naming the path.
void WriteFilmScan(const std::string& path, const SimulationOptions& options,
                   const FilmScanOptions& film, const SimulatedCamera& camera,
                   const PhotoPlan& plan);

}  // namespace orient::simulation
