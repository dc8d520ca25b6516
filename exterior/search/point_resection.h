// A photo's pose from ground points that a person measured in it: wrong ones are found and named,
// and never part of the pose.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "core/files/finding.h"
#include "exterior/steps/photo_to_orient.h"

namespace orient::exterior {

struct MeasuredPoint {
  std::string name;
  Eigen::Vector3d ground_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d sigma_m = Eigen::Vector3d::Zero();
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  double sigma_px = 1;  // of each coordinate
  bool control = true;  // false: compared with the pose, and no part of it
};

struct PointPose {
  FilmPosition position;  // the one of the photo's that explains the points best
  Pose pose;
  Matrix6d covariance = Matrix6d::Zero();  // of the stated sigmas, larger where residuals are
  std::vector<bool> used = {};             // of every point
  // Measured - computed, of every point; NaN behind the camera.
  std::vector<Eigen::Vector2d> residuals_px = {};
  std::vector<Matrix6d> hidden = {};  // of each used point, PointCheck::hidden
  int Used() const;
};

struct PointResection {
  std::optional<PointPose> found;  // empty: why, is the only finding
  Findings findings;               // wrong points by name
  bool with_prior = false;         // the prior is in the pose
};

// Without `prior` four points at least; five, to find a wrong one. With it three, and four. It is
// asked only where the points alone do not tell which of them are wrong. Sets of points are
// tested as a whole and point by point (chi-square, one right set in ten thousand by either): among
// many, one wrong point hardly shows in the whole. Of several that pass without so many points, the
// best is taken if it is beyond doubt, and none otherwise.
PointResection ResectByPoints(const Camera& camera, const std::vector<FilmPosition>& positions,
                              const std::optional<PosePrior>& prior,
                              const std::vector<MeasuredPoint>& points);

// How many points make a photo ok without patches.
inline constexpr int kLeastPointsAlone = 6;

// By how much an error of one point, the smallest that its test detects in four of five cases, may
// displace the projection in the frame's worst corner, pixels.
double HiddenDisplacement(const PointPose& pose, const PhotoView& view, double height_m);

// By points alone, where no patch tells more: ok with enough of them that check one another
// (`hidden_px`: HiddenDisplacement), at most a quarter of all named as `wrong`, and a pose precise
// to `target_px` all over the frame
// (`worst_sigma_px`); otherwise weak.
Finding JudgePointsAlone(int points, int wrong, double worst_sigma_px, double hidden_px,
                         double target_px);

// Which points lie elsewhere under a pose found by other means; absent: none does.
std::optional<Finding> JudgePointsUnder(const PhotoView& view, const Matrix6d& covariance,
                                        const std::vector<MeasuredPoint>& points);

}  // namespace orient::exterior
