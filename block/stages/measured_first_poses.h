// First poses of a block of which only image measurements are given.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "block/bundle/bundle.h"
#include "core/files/camera_file.h"
#include "core/files/finding.h"
#include "core/files/orientation_table.h"
#include "core/measurements/measurements.h"

namespace orient::block {

// What was measured in each photo, its marks and image points only.
using MeasuredPhotos = std::map<std::string, Measurements>;
MeasuredPhotos ByPhoto(const Measurements& measured);

// In the photo system, mm.
Eigen::Vector2d InPhoto(const BlockPhoto& photo, const ImagePointMeasurement& point);

// `sigma_mm`: by how much the camera may displace an image point.
struct StartingCamera {
  const Camera& camera;
  double sigma_mm = 0;
};

// Poses and ground points that follow from one another: resection from surveyed points, and from
// those that photos oriented before intersect; then approximations.
class FirstPoses {
 public:
  // Stores the poses as the photos' approximations.
  FirstPoses(const StartingCamera& camera, const std::vector<GroundPoint>& surveyed,
             const std::vector<OrientationRow>& approximations, MeasuredPhotos* measured,
             std::vector<BlockPhoto>* photos);

  bool Oriented(std::size_t photo) const { return oriented_[photo]; }
  // Findings of the photo's resection: wrong points, or why there is no pose.
  const Findings& Of(const std::string& photo) { return findings_[photo]; }

 private:
  bool Resect(std::size_t i);
  void Intersect();
  void TakeApproximations(const std::vector<OrientationRow>& approximations);
  std::vector<std::optional<double>> KappasOf(const std::vector<std::size_t>& placed) const;
  const std::vector<ImagePointMeasurement>& PointsIn(std::size_t photo) const {
    return measured_.at(photos_[photo].name).image_points;
  }

  StartingCamera camera_;
  MeasuredPhotos& measured_;
  std::vector<BlockPhoto>& photos_;
  std::vector<bool> oriented_;
  std::map<std::string, GroundPoint> known_;
  std::map<std::string, Findings> findings_;
};

}  // namespace orient::block
