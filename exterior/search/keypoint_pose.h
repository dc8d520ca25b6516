// A rough pose of a photo, without any prior knowledge, from keypoints that it shares with
// oriented photos: their ground points are where the rays of the oriented photos meet the
// surface. An approximation for the loop (orient_photo.h), never a result: keypoints are rough,
// repetitive texture deceives them, and trees and houses do not lie on the surface.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "exterior/steps/photo_to_orient.h"

namespace orient::exterior {

struct SharedKeypoint {
  Eigen::Vector2d pixel;     // of the photo's scan
  Eigen::Vector3d ground_m;  // as one oriented photo shows it; several may show the same keypoint
  // Where in that photo's frame. A keypoint at the same place of both frames, in whichever position
  // of the film, is not ground but something in all photos (crosses, marks, dirt) and left out: it
  // would give the photo the other one's pose, which patches cut from that one would confirm.
  std::optional<Eigen::Vector2d> lender_mm;
  double weight = 1;  // how often it is drawn into samples, against others
};

struct KeypointPoseOptions {
  double sigma_px = 1;  // of a keypoint, one coordinate, scan pixels
  // Places of the photo, some 24 sigma_px apart: keypoints closer together have correlated errors.
  int min_supporters = 12;
  double max_log10_false_alarms = -6;
  // Where another pose has this share of the best one's supporters, none is believed.
  double rival_share = 0.5;
  double max_tilt_rad = 0.35;
  int samples = 4000;
  // Area of the scan in which a shared keypoint may lie, as far as is known; 0: the whole scan.
  double area_px2 = 0;
  int searches = 1;  // number made; the first pose not due to chance is accepted
  std::uint32_t seed = 1;
};

struct KeypointPose {
  Pose pose;
  Matrix6d covariance;       // honest for an approximation: supporters close together count once
  int supporters = 0;        // keypoints
  std::size_t position = 0;  // index into the photo's film positions
  // log10 of how many poses chance is expected to let so many agree on.
  double log10_false_alarms = 0;
  double rms_px = 0;  // of the supporters
};

// RANSAC over three-point resections (Fischler & Bolles 1981), then least squares. `scan_px`: width
// and height of the scan. Empty: too few keypoints agree, they lie on a line, chance could make as
// many agree, or two poses contend.
std::optional<KeypointPose> PoseFromKeypoints(const Camera& camera,
                                              const std::vector<FilmPosition>& positions,
                                              const Eigen::Vector2i& scan_px,
                                              const std::vector<SharedKeypoint>& shared,
                                              const KeypointPoseOptions& options = {});

}  // namespace orient::exterior
