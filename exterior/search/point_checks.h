// How far the others check one of the ground points that were measured in a photo.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/terrain/pixel_derivatives.h"
#include "exterior/search/measured_point.h"

namespace orient::exterior {

// Covariance of the measurement plus that of the projected ground coordinates, px^2.
Eigen::Matrix2d ObservedCovariance(const MeasuredPoint& point, const PixelDerivatives& derivatives);

// Significance level of the tests of a set of points.
inline constexpr double kPointSignificance = 1e-4;

// Limit of a point's chi-square that is exceeded by a point in one of ten thousand sets of `points`
// correct points.
double PointChiSquareLimit(std::size_t points);

struct PointCheck {
  // Chi-square of the residual with its own covariance: the observation's minus the pose's share.
  // Directions without redundancy are left out; infinite behind the camera.
  double chi2 = 0;
  // The pose moved by the point's smallest errors that this test detects in four of five cases
  // (Baarda's external reliability), as a sum of dyads over two directions.
  Matrix6d hidden = Matrix6d::Zero();
};

// `view` has the pose of an adjustment of `points` such points, `covariance` is the adjustment's of
// stated sigmas.
PointCheck CheckPoint(const PhotoView& view, const Matrix6d& covariance, const MeasuredPoint& point,
                      std::size_t points);

// PointCheck::hidden where an adjustment of more than this photo tells the pose's covariance and
// the redundancy of the image coordinates (0..1, mean of both); the point's sigmas must be scaled
// as that adjustment's covariance is.
Matrix6d HiddenBy(const PhotoView& view, const Matrix6d& covariance, const MeasuredPoint& point,
                  std::size_t points, double redundancy);

// By how much an error of one point, the smallest that its test detects in four of five cases, may
// displace the projection in the frame's worst corner, pixels.
double HiddenDisplacement(const PointPose& pose, const PhotoView& view, double height_m);

}  // namespace orient::exterior
