// What the fiducial marks of a new camera look like, from scans on which a person clicked them.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/files/camera_file.h"
#include "core/raster/image.h"
#include "interior/marks/drawing_fit.h"

namespace orient::block {

// A mark on one scan.
struct Sighting {
  size_t scan = 0;
  std::string photo;
  interior::SeenMark seen;
  ImageWindow window;  // of seen.image on the scan, without pixels of its own
  Eigen::Vector2d place = Eigen::Vector2d::Zero();  // on the scan: clicked, then measured
};

struct MarkSeen {
  std::string id;
  std::vector<Sighting> sightings;  // one or more
  size_t look = 0;                  // index of what it looks like
  double correlation = 0;           // of its drawing with the scans, mean; 0 for a picture
};

// What one or more marks look like: elements, or a picture (bright on a positive, 0 to 255).
struct Look {
  std::string name;
  std::vector<MarkElement> elements;
  MarkBackground background = MarkBackground::kDark;
  Image picture;
  double pixel_mm = 0;                                  // of the picture
  Eigen::Vector2d centre_px = Eigen::Vector2d::Zero();  // of the mark in the picture
};

// Marks that look alike have one drawing of elements; those that no drawing explains have a picture
// each, `picture_radius_mm` to a side, cut out where the first scan was clicked and averaged with
// the others. Sets every mark's look, and measures its place on all scans. Throws InputError naming
// photo and mark where a picture would reach beyond the scan.
std::vector<Look> FindLooks(double picture_radius_mm, std::vector<MarkSeen>* marks);

}  // namespace orient::block
