// Where the film lies on a scanner bed much larger than it.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/raster/raster.h"

namespace orient::interior {

// A part of the scan, pixels.
struct ScanRegion {
  Eigen::Vector2d centre_px = Eigen::Vector2d::Zero();
  Eigen::Vector2d size_px = Eigen::Vector2d::Zero();
};

ScanRegion WholeScan(const Eigen::Vector2i& scan_px);

// Rectangles that stand out against the bed, the largest first; those that fill nearly all of the
// scan, or less than a fiftieth of its longer side, are left out. The bed, white, black or grey, is
// the grey value that the scan's outermost pixels have most often; where they have none in common
// there is no bed and no rectangle. On a bed of the rebate's own tone the exposed frame is found in
// place of the film: both have one centre, to a few millimetres.
//
// Looks at an overview of at most about 500 pixels, which the raster averages strip by strip (or
// takes from the file's own overviews): the whole scan is never in memory.
std::vector<ScanRegion> FindFilmOnBed(const Raster& scan);

// The same on an overview.
std::vector<ScanRegion> FindFilmOnBed(const ImageWindow& overview);

}  // namespace orient::interior
