// A camera file for a camera that the library does not have, from scans on which a person clicked
// the fiducial marks: what the marks look like, and where they are.
#pragma once

#include <Eigen/Core>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "block/roll/new_camera_inputs.h"
#include "core/files/camera_file.h"
#include "core/raster/image.h"

namespace orient::block {

struct NewMark {
  std::string id, drawing;
  double correlation = 0;  // of its drawing with the scans, mean; 0 for a picture
  int scans = 0;           // that show it
  std::optional<Eigen::Vector2d> first_place;  // on the first scan, pixels, where it was clicked
};

struct NewCamera {
  CameraFile file;                           // pictures of marks have no path yet
  std::map<std::string, Image> pictures;     // by drawing: bright on a positive, 0 to 255
  std::vector<NewMark> marks;                // in the order of the file's fiducials
  std::vector<double> distance_residual_mm;  // stated - adjusted, of the options' distances
  double pixel_size_um = 0;                  // of the first scan
  std::string scale_from;                    // ClickedScale::from of the first scan
  bool origin_known = true;                  // see MarkLayout
  double scale_difference = 0;               // see MarkLayout; 0 where positions are stated
  Eigen::Matrix2d first_mm_from_pixel = Eigen::Matrix2d::Identity();  // linear part, of that scan
};

// Marks that look alike have one drawing of elements (mark_looks.h), the others a picture, cut out
// and averaged over the scans. Throws InputError naming photo, mark and remedy: fewer than three
// marks, clicks beside the scan or at one place, clicks that contradict one another, the stated
// positions or the distances, marks too near the scan's edge for a picture, a scale that nothing
// tells.
NewCamera MakeCamera(const std::vector<ClickedScan>& scans, const NewCameraOptions& options);

}  // namespace orient::block
