// Orthophotos of the oriented photos, and how well they meet: a visual check.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "block/pictures/ortho_photo.h"

namespace orient::block {

// Two photos where their orthophotos meet.
struct SeamPlace {
  std::string first, second;
  Eigen::Vector3d ground_m;
  // Where the second photo's orthophoto shows what the first one shows here, in pixels of the
  // coarser photo, by matching; empty where texture is missing or leaves it open.
  std::optional<Eigen::Vector2d> shift_px;
};

struct Quicklook {
  double mosaic_gsd_m = 0;
  std::vector<SeamPlace> seams;
  std::vector<std::string> left_out;  // photos that cannot be read

  // Median length of the shifts; empty where fewer than three places could be measured.
  std::optional<double> MedianShiftPx() const;
  int Measured() const;
};

// Writes <directory>/quicklook.png, a mosaic of reduced orthophotos with its seams drawn (every
// place from the photo that sees it nearest to its middle), and <directory>/seams.png, places along
// the seams at full resolution, both photos in turn like a chequerboard: a line that is broken
// where the fields meet is an error of orientation or DEM, or stands above the ground. Photos that
// cannot be read, and `surface` where it has no height, stay white. Removes both and returns
// nothing where no photo is given or none shows the surface.
std::optional<Quicklook> WriteQuicklook(const std::string& directory,
                                        const std::vector<QuicklookPhoto>& photos,
                                        const GroundSurface& surface);

}  // namespace orient::block
