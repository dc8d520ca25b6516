// A photo whose pose is to be estimated, and what is known of the pose before: what the tests of
// the estimators share.
#pragma once

#include <random>

#include "core/geometry/resection.h"
#include "core/terrain/photo_view.h"

namespace orient::exterior {

// A nearly vertical photo of a digital camera, some 4500 m above the ground.
inline PhotoView DigitalView() {
  PhotoView view;
  view.camera.kind = CameraKind::kDigital;
  view.camera.principal_distance_mm = 120;
  view.camera.frame_mm = {92, 166};
  view.camera.image_px = Eigen::Vector2i(640, 1152);
  view.photo_from_pixel = DigitalPhotoFromPixel(view.camera);
  view.pose = {{1000, 2000, 5000}, {0.01, -0.02, 0.4}};
  return view;
}

struct PriorSigma {
  double position_m, attitude_rad;
};

// Off from the truth by as much as its standard deviations say.
inline PosePrior PriorOf(const Pose& truth, const PriorSigma& of, std::mt19937& random) {
  std::normal_distribution<double> normal;
  Vector6d sigma, off;
  sigma << Eigen::Vector3d::Constant(of.position_m), Eigen::Vector3d::Constant(of.attitude_rad);
  for (int i = 0; i < 6; ++i) off[i] = sigma[i] * normal(random);
  return {Pose::FromVector(truth.AsVector() + off), sigma.cwiseAbs2().asDiagonal()};
}

}  // namespace orient::exterior
