// Plane transforms and their estimation; the eight scan orientations of a film.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string_view>
#include <vector>

namespace orient {

// target = A * source + t.
struct Affine2d {
  Eigen::Matrix2d A = Eigen::Matrix2d::Identity();
  Eigen::Vector2d t = Eigen::Vector2d::Zero();

  Eigen::Vector2d operator*(const Eigen::Vector2d& source) const { return A * source + t; }
  // (a * b) applies b first.
  Affine2d operator*(const Affine2d& other) const { return {A * other.A, A * other.t + t}; }
  // Whether A has an inverse that a double can hold.
  bool IsInvertible() const;
  // Throws std::invalid_argument where it is not.
  Affine2d Inverse() const;
};

struct PointPair2d {
  Eigen::Vector2d source;
  Eigen::Vector2d target;
  double sigma = 1.0;  // of one target coordinate, relative weights only
};

struct TransformFit {
  Affine2d transform;
  // Of the estimated parameters, scaled with sigma0^2 where the redundancy is positive, otherwise
  // with the pairs' own sigma. Affine: (a11 a12 a21 a22 t1 t2); similarity: (a b t1 t2).
  Eigen::MatrixXd covariance;
  // Target-side residuals: measured - computed.
  std::vector<Eigen::Vector2d> residuals;
  double sigma0 = 0;  // sqrt(v'Pv / redundancy); 0 where the redundancy is 0
  int redundancy = 0;
  // Covariance of the transformed point (target units) at a source point.
  Eigen::Matrix2d CovarianceAt(const Eigen::Vector2d& source) const;
};

// Least-squares affine (six parameters), at least 3 pairs. Empty when there are fewer or when the
// sources are collinear.
std::optional<TransformFit> FitAffine(const std::vector<PointPair2d>& pairs);

// Least-squares similarity (four parameters), at least 2 distinct pairs; with `mirrored` the
// transform has a negative determinant: A = [[a, b], [b, -a]], otherwise A = [[a, -b], [b, a]].
std::optional<TransformFit> FitSimilarity(const std::vector<PointPair2d>& pairs, bool mirrored);

// r90: the scan shows the positive rotated counter-clockwise by 90 degrees. m90: first mirrored
// left-right, then rotated.
enum class ScanOrientation { kR0, kR90, kR180, kR270, kM0, kM90, kM180, kM270 };

inline constexpr std::array<ScanOrientation, 8> kAllScanOrientations = {
    ScanOrientation::kR0, ScanOrientation::kR90, ScanOrientation::kR180, ScanOrientation::kR270,
    ScanOrientation::kM0, ScanOrientation::kM90, ScanOrientation::kM180, ScanOrientation::kM270};

std::string_view Name(ScanOrientation orientation);  // "r0" ... "m270"
std::optional<ScanOrientation> ScanOrientationFromName(std::string_view name);
bool IsMirrored(ScanOrientation orientation);

// The linear part of photo_from_pixel for a unit pixel size: a signed permutation with, for r0,
// diag(1, -1).
Eigen::Matrix2d PhotoFromPixelAxes(ScanOrientation orientation);

// The orientation whose axes are nearest to a photo_from_pixel transform.
ScanOrientation NearestScanOrientation(const Affine2d& photo_from_pixel);

}  // namespace orient
