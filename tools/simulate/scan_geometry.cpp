#include "tools/simulate/scan_geometry.h"

#include <Eigen/LU>
#include <numbers>

#include "tools/simulate/noise.h"

namespace orient::simulation {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

// What happens to the positive on its way into the scan, in words of the conventions: "the scan
// shows the positive turned counter-clockwise by that angle", "first mirrored left-right".
struct Handling {
  bool mirrored;
  double turn_deg;
};

Handling HandlingOf(ScanOrientation orientation) {
  switch (orientation) {
    case ScanOrientation::kR0:
      return {false, 0};
    case ScanOrientation::kR90:
      return {false, 90};
    case ScanOrientation::kR180:
      return {false, 180};
    case ScanOrientation::kR270:
      return {false, 270};
    case ScanOrientation::kM0:
      return {true, 0};
    case ScanOrientation::kM90:
      return {true, 90};
    case ScanOrientation::kM180:
      return {true, 180};
    case ScanOrientation::kM270:
      return {true, 270};
  }
  return {false, 0};
}

Matrix2d CounterClockwise(double angle_rad) {
  const double c = std::cos(angle_rad), s = std::sin(angle_rad);
  return (Matrix2d() << c, -s, s, c).finished();
}

Vector2d Bend(const Eigen::Matrix<double, 2, 7>& bend, const Vector2d& n) {
  const double u = n.x(), v = n.y();
  const Eigen::Matrix<double, 7, 1> terms = (Eigen::Matrix<double, 7, 1>() << u * u, u * v, v * v,
                                             u * u * u, u * u * v, u * v * v, v * v * v)
                                                .finished();
  return bend * terms;
}

template <typename Visit>
void ForFrameGrid(double half_frame_mm, Visit visit) {
  constexpr int kSteps = 10;
  for (int i = -kSteps; i <= kSteps; ++i)
    for (int j = -kSteps; j <= kSteps; ++j) visit(Vector2d(i, j) * (half_frame_mm / kSteps));
}

// Root mean square length of the residual vectors.
double Rms(const std::vector<Vector2d>& residuals) {
  double sum = 0;
  for (const Vector2d& residual : residuals) sum += residual.squaredNorm();
  return std::sqrt(sum / static_cast<double>(residuals.size()));
}

}  // namespace

bool LiesAcross(ScanOrientation orientation) {
  const double turn_deg = HandlingOf(orientation).turn_deg;
  return turn_deg == 90 || turn_deg == 270;
}

ScanGeometry::ScanGeometry(const ScanSetup& setup) : setup_(setup) {
  const Handling handling = HandlingOf(setup.orientation);
  const double turn = handling.turn_deg * std::numbers::pi / 180 + setup.rotation_rad;
  Matrix2d mirror = Matrix2d::Identity();
  if (handling.mirrored) mirror(0, 0) = -1;
  film_from_scan_ = (CounterClockwise(turn) * mirror).inverse();
  std::vector<PointPair2d> pairs;
  ForFrameGrid(setup.half_frame_mm, [&](const Vector2d& photo) {
    const Vector2d pixel = PixelFromPhoto(photo);
    pairs.push_back({pixel, PhotoFromPixel(pixel), 1.0});
  });
  const std::optional<TransformFit> fit = FitAffine(pairs);
  affine_ = fit.value().transform;
  bend_rms_mm_ = Rms(fit->residuals);
}

Vector2d ScanGeometry::PhotoFromPixel(const Vector2d& pixel) const {
  const double p = setup_.pixel_size_mm;
  const Vector2d scan_mm((pixel.x() - 0.5 * setup_.width) * p,
                         (0.5 * setup_.height - pixel.y()) * p);
  const Vector2d film = film_from_scan_ * (scan_mm - setup_.shift_mm);
  return setup_.stretch * film + Bend(setup_.bend, film / setup_.half_frame_mm);
}

Vector2d ScanGeometry::PixelFromPhoto(const Vector2d& photo_mm) const {
  // The bend is micrometres: repeated substitution gains four digits a round.
  const Matrix2d shrink = setup_.stretch.inverse();
  Vector2d film = shrink * photo_mm;
  for (int round = 0; round < 8; ++round)
    film = shrink * (photo_mm - Bend(setup_.bend, film / setup_.half_frame_mm));
  const Vector2d scan_mm = film_from_scan_.inverse() * film + setup_.shift_mm;
  return {0.5 * setup_.width + scan_mm.x() / setup_.pixel_size_mm,
          0.5 * setup_.height - scan_mm.y() / setup_.pixel_size_mm};
}

Eigen::Matrix<double, 2, 7> RandomBend(double half_frame_mm, double rms_um, std::uint64_t seed) {
  RandomStream random(seed);
  Eigen::Matrix<double, 2, 7> bend;
  for (Eigen::Index i = 0; i < 14; ++i) bend(i % 2, i / 2) = random.Gaussian();
  std::vector<PointPair2d> pairs;
  ForFrameGrid(half_frame_mm, [&](const Vector2d& film) {
    pairs.push_back({film, film + Bend(bend, film / half_frame_mm), 1.0});
  });
  const std::optional<TransformFit> fit = FitAffine(pairs);
  return bend * (rms_um * 1e-3 / Rms(fit.value().residuals));
}

}  // namespace orient::simulation
