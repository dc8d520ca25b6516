#include "core/geometry/lens.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace orient {
namespace {

constexpr double kTolerance_mm = 1e-12;
constexpr int kMaxIterations = 60;

// ---- Brown -------------------------------------------------------------------------------------

Eigen::Vector2d BrownAt(const BrownDistortion& lens, const Eigen::Vector2d& q) {
  const double x = q.x(), y = q.y(), r2 = q.squaredNorm();
  const double radial = r2 * (lens.k[0] + r2 * (lens.k[1] + r2 * lens.k[2]));
  return {x * radial + lens.p[0] * (r2 + 2 * x * x) + 2 * lens.p[1] * x * y,
          y * radial + lens.p[1] * (r2 + 2 * y * y) + 2 * lens.p[0] * x * y};
}

Eigen::Matrix2d BrownJacobian(const BrownDistortion& lens, const Eigen::Vector2d& q) {
  const double x = q.x(), y = q.y(), r2 = q.squaredNorm();
  const double radial = r2 * (lens.k[0] + r2 * (lens.k[1] + r2 * lens.k[2]));
  const double slope = 2 * (lens.k[0] + r2 * (2 * lens.k[1] + r2 * 3 * lens.k[2]));
  const double mixed = slope * x * y + 2 * (lens.p[0] * y + lens.p[1] * x);
  Eigen::Matrix2d j;
  j << radial + slope * x * x + 6 * lens.p[0] * x + 2 * lens.p[1] * y, mixed,  //
      mixed, radial + slope * y * y + 6 * lens.p[1] * y + 2 * lens.p[0] * x;
  return j;
}

// d(r + dr)/dr of the radial part, as a polynomial in t = r^2.
double BrownSlope(const BrownDistortion& lens, double t) {
  return 1 + t * (3 * lens.k[0] + t * (5 * lens.k[1] + t * 7 * lens.k[2]));
}

// True if the radial part increases all the way from the centre to the radius sqrt(t).
bool BrownGrowsTo(const BrownDistortion& lens, double t) {
  if (!(BrownSlope(lens, t) > 0)) return false;
  // The extremes of the slope: 3 k1 + 10 k2 t + 21 k3 t^2 = 0.
  const double a = 21 * lens.k[2], b = 10 * lens.k[1], c = 3 * lens.k[0];
  const double discriminant = b * b - 4 * a * c;
  if (discriminant < 0) return true;
  const double q = -0.5 * (b + std::copysign(std::sqrt(discriminant), b));
  for (const double extreme : {a != 0 ? q / a : -1, q != 0 ? c / q : -1})
    if (extreme > 0 && extreme < t && !(BrownSlope(lens, extreme) > 0)) return false;
  return true;
}

// Newton's iteration for q + delta(q) = measured; empty unless it finds an unfolded solution.
std::optional<Eigen::Vector2d> BrownNewton(const BrownDistortion& lens, Eigen::Vector2d q,
                                           const Eigen::Vector2d& measured) {
  const double limit =
      std::max(kTolerance_mm, 8 * std::numeric_limits<double>::epsilon() * measured.norm());
  double best = std::numeric_limits<double>::infinity();
  for (int i = 0; i < kMaxIterations; ++i) {
    const Eigen::Vector2d error = q + BrownAt(lens, q) - measured;
    const Eigen::Matrix2d slope = Eigen::Matrix2d::Identity() + BrownJacobian(lens, q);
    const double size = error.norm();
    // Converged: another step would only change the last digit.
    if (size <= limit && size >= 0.5 * best) {
      const bool unfolded =
          slope.determinant() > 0 && slope.trace() > 0 && BrownGrowsTo(lens, q.squaredNorm());
      return unfolded ? std::optional<Eigen::Vector2d>(q) : std::nullopt;
    }
    best = std::min(best, size);
    const Eigen::Vector2d step = slope.inverse() * error;
    if (!step.allFinite()) return std::nullopt;
    q -= step;
  }
  return std::nullopt;
}

// The radius at which the radial part reaches `measured_r` before it folds, by bisection; the fold
// itself if it does not reach it.
double BrownStartRadius(const BrownDistortion& lens, double measured_r) {
  double low = 0, high = measured_r;
  const auto beyond = [&](double r) {
    const double t = r * r;
    return !BrownGrowsTo(lens, t) ||
           r * (1 + t * (lens.k[0] + t * (lens.k[1] + t * lens.k[2]))) > measured_r;
  };
  while (!beyond(high)) high *= 2;
  for (int i = 0; i < 40; ++i) {
    const double middle = 0.5 * (low + high);
    (beyond(middle) ? high : low) = middle;
  }
  return low;
}

std::optional<Eigen::Vector2d> UndistortBrown(const BrownDistortion& lens,
                                              const Eigen::Vector2d& measured) {
  if (const auto ideal = BrownNewton(lens, measured, measured)) return ideal;
  const double radius = measured.norm();
  if (!(radius > 0) || !std::isfinite(radius)) return std::nullopt;
  // Strong distortion: the measured point itself may lie beyond the fold.
  return BrownNewton(lens, measured * (BrownStartRadius(lens, radius) / radius), measured);
}

// ---- Radial table ------------------------------------------------------------------------------

void CheckTable(const RadialTable& lens) {
  if (lens.radius_mm.empty() || lens.radius_mm.size() != lens.dr_um.size())
    throw std::invalid_argument("a radial table needs one dr for each radius");
}

// The table's row below r (the last row beyond the table).
std::size_t RowBelow(const RadialTable& lens, double r) {
  const auto above = std::upper_bound(lens.radius_mm.begin(), lens.radius_mm.end(), r);
  return above == lens.radius_mm.begin()
             ? 0
             : static_cast<std::size_t>(above - lens.radius_mm.begin()) - 1;
}

double TableSlope(const RadialTable& lens, std::size_t row) {
  if (row + 1 >= lens.radius_mm.size()) return 0;
  return 1e-3 * (lens.dr_um[row + 1] - lens.dr_um[row]) /
         (lens.radius_mm[row + 1] - lens.radius_mm[row]);
}

double TableAt(const RadialTable& lens, double r) {
  const std::size_t row = RowBelow(lens, r);
  return 1e-3 * lens.dr_um[row] + TableSlope(lens, row) * (r - lens.radius_mm[row]);
}

Eigen::Matrix2d TableJacobian(const RadialTable& lens, const Eigen::Vector2d& q) {
  const double r = q.norm();
  const double slope = TableSlope(lens, RowBelow(lens, r));
  if (r == 0) return slope * Eigen::Matrix2d::Identity();
  const Eigen::Vector2d u = q / r;
  const Eigen::Matrix2d outward = u * u.transpose();
  return slope * outward + TableAt(lens, r) / r * (Eigen::Matrix2d::Identity() - outward);
}

bool TableGrowsTo(const RadialTable& lens, double r) {
  for (std::size_t row = 0; row < lens.radius_mm.size() && lens.radius_mm[row] < r; ++row)
    if (!(TableSlope(lens, row) > -1)) return false;
  return true;
}

// Linear pieces can be inverted directly: the first piece from the centre that reaches the radius.
std::optional<Eigen::Vector2d> UndistortTable(const RadialTable& lens,
                                              const Eigen::Vector2d& measured) {
  const double target = measured.norm();
  if (target == 0) return measured;
  for (std::size_t row = 0; row < lens.radius_mm.size(); ++row) {
    const double slope = TableSlope(lens, row);
    if (!(slope > -1)) return std::nullopt;
    const double start = lens.radius_mm[row];
    const double r = start + (target - start - 1e-3 * lens.dr_um[row]) / (1 + slope);
    if (!(r >= 0)) return std::nullopt;
    const bool last = row + 1 == lens.radius_mm.size();
    if (last || r <= lens.radius_mm[row + 1]) return Eigen::Vector2d(measured * (r / target));
  }
  return std::nullopt;
}

// The table's own radii and two hundred others (on film, a millimetre apart).
RadialTable TablePlus(const RadialTable& table, const std::array<double, 3>& k, double reach_mm) {
  constexpr int kPieces = 200;
  std::vector<double> radii = table.radius_mm;
  for (int i = 0; i <= kPieces; ++i) radii.push_back(reach_mm * i / kPieces);
  std::sort(radii.begin(), radii.end());
  radii.erase(std::unique(radii.begin(), radii.end()), radii.end());
  RadialTable sum;
  for (const double r : radii) {
    const double r2 = r * r;
    sum.radius_mm.push_back(r);
    sum.dr_um.push_back(
        1e3 * (DistortionAt(table, {r, 0}).x() + r * r2 * (k[0] + r2 * (k[1] + r2 * k[2]))));
  }
  return sum;
}

}  // namespace

Eigen::Vector2d DistortionAt(const LensDistortion& lens, const Eigen::Vector2d& ideal_mm) {
  if (const auto* brown = std::get_if<BrownDistortion>(&lens)) return BrownAt(*brown, ideal_mm);
  if (const auto* table = std::get_if<RadialTable>(&lens)) {
    CheckTable(*table);
    const double r = ideal_mm.norm();
    if (r == 0) return Eigen::Vector2d::Zero();
    return ideal_mm * (TableAt(*table, r) / r);
  }
  return Eigen::Vector2d::Zero();
}

Eigen::Matrix2d DistortionJacobian(const LensDistortion& lens, const Eigen::Vector2d& ideal_mm) {
  if (const auto* brown = std::get_if<BrownDistortion>(&lens))
    return BrownJacobian(*brown, ideal_mm);
  if (const auto* table = std::get_if<RadialTable>(&lens)) {
    CheckTable(*table);
    return TableJacobian(*table, ideal_mm);
  }
  return Eigen::Matrix2d::Zero();
}

Eigen::Vector2d DistortPoint(const LensDistortion& lens, const Eigen::Vector2d& ideal_mm) {
  return ideal_mm + DistortionAt(lens, ideal_mm);
}

bool InsideFold(const LensDistortion& lens, const Eigen::Vector2d& ideal_mm) {
  if (const auto* brown = std::get_if<BrownDistortion>(&lens))
    return BrownGrowsTo(*brown, ideal_mm.squaredNorm());
  if (const auto* table = std::get_if<RadialTable>(&lens))
    return TableGrowsTo(*table, ideal_mm.norm());
  return true;
}

LensDistortion WithRadial(const LensDistortion& lens, const std::array<double, 3>& k,
                          double reach_mm) {
  if (const auto* table = std::get_if<RadialTable>(&lens)) return TablePlus(*table, k, reach_mm);
  BrownDistortion brown;
  if (const auto* own = std::get_if<BrownDistortion>(&lens)) brown = *own;
  for (std::size_t i = 0; i < k.size(); ++i) brown.k.at(i) += k.at(i);
  return brown;
}

std::optional<Eigen::Vector2d> UndistortPoint(const LensDistortion& lens,
                                              const Eigen::Vector2d& measured_mm) {
  if (const auto* brown = std::get_if<BrownDistortion>(&lens))
    return UndistortBrown(*brown, measured_mm);
  if (const auto* table = std::get_if<RadialTable>(&lens)) {
    CheckTable(*table);
    return UndistortTable(*table, measured_mm);
  }
  return measured_mm;
}

}  // namespace orient
