// What a person states about a camera that the library does not have.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "core/files/results.h"
#include "core/geometry/transform2d.h"
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

}  // namespace orient::block
