// The residuals of a block adjustment as Ceres wants them, with analytic derivatives. Unknowns are
// differences from first values: three a ground point, six of everything else (poses, film, lens,
// GNSS of a strip, height errors), so that Ceres' Schur elimination meets one size only. Residuals
// are computed - measured, whitened. Private to block.
#pragma once

#include <ceres/cost_function.h>

#include <Eigen/Core>
#include <array>
#include <memory>

#include "core/geometry/camera.h"
#include "core/geometry/pose.h"
#include "core/geometry/resection.h"

namespace orient::block {

// Which of c, x, y, k1, k2, k3 are unknowns, and what one unit of each unknown is: mm for the first
// three; k such that one unit moves a point at the frame's corner by a millimetre.
struct LensUnknowns {
  std::array<bool, 6> active = {};
  Vector6d unit = Vector6d::Ones();
};

// What a photo's image points share. Poses and points are relative to the block's origin.
struct ImageOfPhoto {
  const Camera* camera = nullptr;
  Pose start;
  const LensUnknowns* lens = nullptr;  // null: no self-calibration
  // Square root of the covariance of photo_from_pixel (6 x 6); zero rows for digital cameras.
  Matrix6d film_root = Matrix6d::Zero();
  bool has_film = false;
};

struct ImageMeasurement {
  Eigen::Vector2d pixel, photo_mm;
  Eigen::Matrix2d covariance_mm2;
};

// Unknowns: point, pose[, film][, lens]. `weight` multiplies the whitened residuals (one over the
// square root of the group's variance factor); not owned, as are photo and point.
std::unique_ptr<ceres::CostFunction> MakeImageCost(const ImageOfPhoto& photo,
                                                   const Eigen::Vector3d& start_m,
                                                   const ImageMeasurement& measured,
                                                   const double* weight);

// A place in a group of six unknowns; group -1: none.
struct HeightUnknown {
  int group = -1, element = 0;
};

struct ControlTerm {
  Eigen::Vector3d offset_m;  // first value - control
  Eigen::Matrix3d whitening;
  Eigen::Vector3d effect_m;                    // per unit of either height unknown
  int common_element = -1, cell_element = -1;  // -1: no height errors
};

// Unknowns: point[, common height errors, those of its cell]. Two residuals each, as an image point
// has: the first two rows, then the third and a zero.
std::unique_ptr<ceres::CostFunction> MakeControlCost(const ControlTerm& term, bool third_row,
                                                     const double* weight);

// Unknowns: pose. Of a prior that states something.
std::unique_ptr<ceres::CostFunction> MakePosePriorCost(const PosePrior& prior, const Pose& start,
                                                       const double* weight);

struct GnssTerm {
  Eigen::Vector3d offset_m;  // first value - GNSS
  Eigen::Matrix3d whitening;
  bool has_shift = false;
  double time = 0;  // -1..1 along the strip
};

// Unknowns: pose[, shift and drift of the strip].
std::unique_ptr<ceres::CostFunction> MakeGnssCost(const GnssTerm& term, const double* weight);

// unknown / sigma, six of them.
std::unique_ptr<ceres::CostFunction> MakeZeroCost(const Vector6d& sigma, const double* weight);

// W with W' W = covariance^-1. Throws std::invalid_argument where it is not positive definite.
Eigen::MatrixXd WhiteningOf(const Eigen::MatrixXd& covariance, const char* what);

}  // namespace orient::block
