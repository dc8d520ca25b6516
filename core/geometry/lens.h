// Lens distortion: measured = ideal + delta(ideal), all in mm relative to the principal point.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <variant>
#include <vector>

namespace orient {

// Brown: dx = x (k1 r^2 + k2 r^4 + k3 r^6) + p1 (r^2 + 2 x^2) + 2 p2 x y,
//        dy = y (k1 r^2 + k2 r^4 + k3 r^6) + p2 (r^2 + 2 y^2) + 2 p1 x y.
struct BrownDistortion {
  std::array<double, 3> k = {0, 0, 0};  // per mm^2, mm^4, mm^6
  std::array<double, 2> p = {0, 0};     // per mm
};

// Radial displacement, positive outwards, linear between the radii, constant beyond the last.
struct RadialTable {
  std::vector<double> radius_mm;  // strictly increasing, from 0
  std::vector<double> dr_um;
};

using LensDistortion = std::variant<std::monostate, BrownDistortion, RadialTable>;

// delta at an ideal point.
Eigen::Vector2d DistortionAt(const LensDistortion& lens, const Eigen::Vector2d& ideal_mm);

// d delta / d ideal. At a radius of a table the slope of the piece outside.
Eigen::Matrix2d DistortionJacobian(const LensDistortion& lens, const Eigen::Vector2d& ideal_mm);

Eigen::Vector2d DistortPoint(const LensDistortion& lens, const Eigen::Vector2d& ideal_mm);

// True where the radial part grows all the way from the principal point to this ideal point.
// Beyond, the model has folded over: it would show the point inside the photo, where it never was.
bool InsideFold(const LensDistortion& lens, const Eigen::Vector2d& ideal_mm);

// The lens with k[0] r^3 + k[1] r^5 + k[2] r^7 added to its radial distortion (mm; r from the
// principal point). A radial table is made dense enough to follow the curve, and extends to
// `reach_mm` at least.
LensDistortion WithRadial(const LensDistortion& lens, const std::array<double, 3>& k,
                          double reach_mm);

// The exact inverse of DistortPoint by Newton iteration (to 1e-12 mm). Empty where the model folds
// over and no ideal point belongs to the measured one.
std::optional<Eigen::Vector2d> UndistortPoint(const LensDistortion& lens,
                                              const Eigen::Vector2d& measured_mm);

}  // namespace orient
