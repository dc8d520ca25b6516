// A camera file for a camera that the library does not have, from scans on which a person clicked
// the fiducial marks: what the marks look like, and where they are.
#pragma once

#include <Eigen/Core>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "block/roll/mark_layout.h"
#include "core/files/camera_file.h"
#include "core/files/results.h"
#include "core/raster/raster.h"
#include "interior/constellation/interior_options.h"

namespace orient::block {

struct ClickedScan {
  std::string photo;
  Raster raster;
  std::vector<interior::MarkClick> clicks;
};

// A calibrated position, as the report states it.
struct StatedPosition {
  std::string mark;
  Eigen::Vector2d position_mm = Eigen::Vector2d::Zero();
};

struct StatedDistance {
  std::string from, to;
  double distance_mm = 0, sigma_mm = 0.01;
};

struct NewCameraOptions {
  std::string name;
  double principal_distance_mm = 0;
  std::optional<Eigen::Vector2d> frame_mm;             // empty: the marks' extent
  std::vector<StatedPosition> positions;               // of all marks, or empty
  std::vector<StatedDistance> distances;               // used where there are no positions
  std::optional<double> pixel_size_um;                 // needed where there are neither
  ScanOrientation orientation = ScanOrientation::kR0;  // of the scans; positions determine it
  Polarity polarity = Polarity::kPositive;
  bool photogrammetric = false;   // the scanner: its errors are below 20 um, else 150 um
  double template_radius_mm = 2;  // of marks that no drawing describes
};

struct NewMark {
  std::string id, drawing;
  double correlation = 0;  // of its drawing with the scans, mean; 0 for a picture on one scan
  int scans = 0;           // that show it
  std::optional<Eigen::Vector2d> first_place;  // on the first scan, pixels, where it was clicked
};

struct NewCamera {
  CameraFile file;                           // pictures of marks have no path yet
  std::map<std::string, Image> pictures;     // by drawing: bright on a positive, 0 to 255
  std::vector<NewMark> marks;                // in the order of the file's fiducials
  std::vector<double> distance_residual_mm;  // stated - adjusted, of the options' distances
  double pixel_size_um = 0;                  // of the first scan
  Eigen::Matrix2d first_mm_from_pixel = Eigen::Matrix2d::Identity();  // linear part, of that scan
};

// Marks that look alike have one drawing of elements (interior/marks/drawing_fit.h), the others a
// picture, cut out and averaged over the scans. Throws InputError naming the mark and the remedy:
// fewer than three marks, clicks that contradict the stated positions or distances, marks at the
// scan's edge, a scale that nothing tells.
NewCamera MakeCamera(const std::vector<ClickedScan>& scans, const NewCameraOptions& options);

}  // namespace orient::block
