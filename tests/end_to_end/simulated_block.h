// Simulated blocks for end-to-end tests: made, harvested, and their truth read back.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/files/camera_file.h"
#include "core/files/results.h"
#include "core/geometry/pose.h"
#include "tools/simulate/simulate.h"

namespace orient {

// Where a ground point truly lies in a scan.
struct SeenPoint {
  Eigen::Vector3d ground_m;
  Eigen::Vector2d pixel;
};

struct TruePhoto {
  std::string name;
  Pose pose;
  int width = 0, height = 0;
  double pixel_size_mm = 0;
  std::vector<SeenPoint> seen;
};

std::vector<TruePhoto> ReadTruth(const std::string& block_folder);

// Fills `database` with patches of the block's old photos.
void HarvestOldPhotos(const std::string& block, const std::string& database,
                      int max_per_photo = 400);

// Film photos on bare ground, quick to orient.
SimulationOptions QuickFilm(int photos);

// The block, and in its folder patches.gpkg of its old photos.
SimulationSummary MakeBlock(const SimulationOptions& options, const std::string& folder);

// RMS distance in the scan between where ground points truly lie and where interior and exterior
// orientation together put them; NaN where one of them is missing.
double ProjectionRms(const CameraFile& camera, const InteriorResult& interior,
                     const ExteriorResult& exterior, const std::vector<SeenPoint>& seen);

}  // namespace orient
