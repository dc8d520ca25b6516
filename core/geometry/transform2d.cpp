#include "core/geometry/transform2d.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "core/geometry/dense_solvers.h"

namespace orient {
namespace {

// Sources whose spread across is smaller than this part of their spread along are collinear.
constexpr double kCollinear = 1e-9;

constexpr std::array<std::string_view, 8> kNames = {"r0", "r90", "r180", "r270",
                                                    "m0", "m90", "m180", "m270"};

struct Centred {
  Eigen::Vector2d centre;  // weighted mean of the sources
  double scale;            // root mean square distance from it
  double thinness;         // spread across / spread along
};

Centred CentreOf(const std::vector<PointPair2d>& pairs) {
  Centred c{Eigen::Vector2d::Zero(), 0, 0};
  double weights = 0;
  for (const PointPair2d& pair : pairs) {
    if (!(pair.sigma > 0))
      throw std::invalid_argument("the sigma of a point pair must be positive");
    const double weight = 1 / (pair.sigma * pair.sigma);
    c.centre += weight * pair.source;
    weights += weight;
  }
  c.centre /= weights;
  double along = 0, square_sum = 0;
  Eigen::Vector2d axis = Eigen::Vector2d::UnitX();  // towards the source farthest from the centre
  for (const PointPair2d& pair : pairs) {
    const Eigen::Vector2d offset = pair.source - c.centre;
    square_sum += offset.squaredNorm();
    if (offset.norm() <= along) continue;
    along = offset.norm();
    axis = offset / along;
  }
  c.scale = std::sqrt(square_sum / static_cast<double>(pairs.size()));
  double across = 0;
  for (const PointPair2d& pair : pairs) {
    const Eigen::Vector2d offset = pair.source - c.centre;
    across = std::max(across, std::abs(axis.x() * offset.y() - axis.y() * offset.x()));
  }
  // Sources far from the origin are rounded accordingly; a spread below this is only rounding.
  const double rounding = 1e-14 * c.centre.norm();
  c.thinness = along > rounding ? across / along : -1;
  return c;
}

// The two rows of d(target)/d(parameters) at a source point.
Eigen::MatrixXd AffineRows(const Eigen::Vector2d& s) {
  Eigen::MatrixXd rows(2, 6);
  rows << s.x(), s.y(), 0, 0, 1, 0,  //
      0, 0, s.x(), s.y(), 0, 1;
  return rows;
}

Eigen::MatrixXd SimilarityRows(const Eigen::Vector2d& s, bool mirrored) {
  Eigen::MatrixXd rows(2, 4);
  if (mirrored)
    rows << s.x(), s.y(), 1, 0, -s.y(), s.x(), 0, 1;
  else
    rows << s.x(), -s.y(), 1, 0, s.y(), s.x(), 0, 1;
  return rows;
}

Affine2d AffineOf(const Eigen::VectorXd& p) {
  Affine2d transform;
  transform.A << p[0], p[1], p[2], p[3];
  transform.t << p[4], p[5];
  return transform;
}

Affine2d SimilarityOf(const Eigen::VectorXd& p, bool mirrored) {
  Affine2d transform;
  if (mirrored)
    transform.A << p[0], p[1], p[1], -p[0];
  else
    transform.A << p[0], -p[1], p[1], p[0];
  transform.t << p[2], p[3];
  return transform;
}

// Least squares in centred and scaled sources s' = (s - centre) / scale, then back:
// the linear parameters are divided by the scale, and t = t' - A centre.
template <class Rows, class Make>
TransformFit Adjust(const std::vector<PointPair2d>& pairs, const Centred& centred, Rows rows,
                    Make make) {
  const Eigen::Index unknowns = rows(centred.centre).cols();
  const Eigen::Index linear = unknowns - 2;
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(unknowns, unknowns);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(unknowns);
  for (const PointPair2d& pair : pairs) {
    const Eigen::MatrixXd a = rows((pair.source - centred.centre) / centred.scale) / pair.sigma;
    normal += a.transpose() * a;
    right += a.transpose() * (pair.target / pair.sigma);
  }
  const Eigen::MatrixXd inverse =
      SolveNormal(normal, Eigen::MatrixXd::Identity(unknowns, unknowns));
  Eigen::MatrixXd back = Eigen::MatrixXd::Identity(unknowns, unknowns);
  back.topLeftCorner(linear, linear) /= centred.scale;
  back.bottomLeftCorner(2, linear) = -rows(centred.centre).leftCols(linear) / centred.scale;

  TransformFit fit;
  fit.transform = make(Eigen::VectorXd(back * SolveNormal(normal, right)));
  fit.redundancy = static_cast<int>(2 * pairs.size()) - static_cast<int>(unknowns);
  double square_sum = 0;
  for (const PointPair2d& pair : pairs) {
    fit.residuals.push_back(pair.target - fit.transform * pair.source);
    square_sum += (fit.residuals.back() / pair.sigma).squaredNorm();
  }
  fit.covariance = back * inverse * back.transpose();
  if (fit.redundancy > 0) {
    fit.sigma0 = std::sqrt(square_sum / fit.redundancy);
    fit.covariance *= fit.sigma0 * fit.sigma0;
  }
  return fit;
}

}  // namespace

bool Affine2d::IsInvertible() const {
  const double determinant = A.determinant();
  return std::isnormal(determinant) && std::abs(determinant) > 1e-14 * A.squaredNorm();
}

Affine2d Affine2d::Inverse() const {
  if (!IsInvertible()) throw std::invalid_argument("a singular affine transform has no inverse");
  Affine2d inverse;
  inverse.A = A.inverse();
  inverse.t = -(inverse.A * t);
  return inverse;
}

Eigen::Matrix2d TransformFit::CovarianceAt(const Eigen::Vector2d& source) const {
  const bool mirrored = transform.A.determinant() < 0;
  const Eigen::MatrixXd rows =
      covariance.rows() == 6 ? AffineRows(source) : SimilarityRows(source, mirrored);
  return rows * covariance * rows.transpose();
}

std::optional<TransformFit> FitAffine(const std::vector<PointPair2d>& pairs) {
  if (pairs.size() < 3) return std::nullopt;
  const Centred centred = CentreOf(pairs);
  if (centred.thinness < kCollinear) return std::nullopt;
  return Adjust(pairs, centred, AffineRows, AffineOf);
}

std::optional<TransformFit> FitSimilarity(const std::vector<PointPair2d>& pairs, bool mirrored) {
  if (pairs.size() < 2) return std::nullopt;
  const Centred centred = CentreOf(pairs);
  if (centred.thinness < 0) return std::nullopt;
  return Adjust(
      pairs, centred, [mirrored](const Eigen::Vector2d& s) { return SimilarityRows(s, mirrored); },
      [mirrored](const Eigen::VectorXd& p) { return SimilarityOf(p, mirrored); });
}

std::string_view Name(ScanOrientation orientation) {
  return kNames.at(static_cast<std::size_t>(orientation));
}

std::optional<ScanOrientation> ScanOrientationFromName(std::string_view name) {
  for (const ScanOrientation orientation : kAllScanOrientations)
    if (Name(orientation) == name) return orientation;
  return std::nullopt;
}

bool IsMirrored(ScanOrientation orientation) { return orientation >= ScanOrientation::kM0; }

Eigen::Matrix2d PhotoFromPixelAxes(ScanOrientation orientation) {
  // Seen with y up, the scan shows Rot(angle) * Mirror * photo; a pixel's row runs down.
  const Eigen::Matrix2d up_from_down = Eigen::Vector2d(1, -1).asDiagonal();
  Eigen::Matrix2d quarter_turn_back;
  quarter_turn_back << 0, 1, -1, 0;
  Eigen::Matrix2d axes = up_from_down;
  for (int i = 0; i < static_cast<int>(orientation) % 4; ++i) axes = quarter_turn_back * axes;
  if (IsMirrored(orientation)) axes.row(0) *= -1;
  return axes;
}

ScanOrientation NearestScanOrientation(const Affine2d& photo_from_pixel) {
  ScanOrientation nearest = ScanOrientation::kR0;
  double best = -1;
  for (const ScanOrientation orientation : kAllScanOrientations) {
    const double likeness = PhotoFromPixelAxes(orientation).cwiseProduct(photo_from_pixel.A).sum();
    if (likeness <= best) continue;
    best = likeness;
    nearest = orientation;
  }
  return nearest;
}

}  // namespace orient
