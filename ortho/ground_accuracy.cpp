#include "ortho/ground_accuracy.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "core/base/median.h"
#include "core/terrain/pixel_derivatives.h"

namespace orient::ortho {
namespace {

// The probability of a point within the radius r, for sigmas a >= b > 0: the density integrated in
// polar coordinates, along the radius in closed form, over the angle by the trapezoidal rule, which
// for a periodic function converges faster than any power of the step.
double ProbabilityWithin(double r, double a, double b) {
  constexpr int kAngles = 2000;
  double sum = 0;
  for (int i = 0; i < kAngles; ++i) {
    const double angle = 2 * std::numbers::pi * i / kAngles;
    const double c = std::cos(angle) / a, s = std::sin(angle) / b;
    const double g = c * c + s * s;
    sum += -std::expm1(-0.5 * r * r * g) / g;
  }
  return sum / (kAngles * a * b);
}

}  // namespace

double CircularError90(const Eigen::Matrix2d& covariance) {
  const Eigen::Vector2d variances =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(covariance, Eigen::EigenvaluesOnly)
          .eigenvalues();
  constexpr double kFlattest = 0.01;  // flatter ellipses differ from it by nothing
  const double a = std::sqrt(std::max(variances.y(), 0.0));
  if (!(a > 0)) return 0;
  const double b = std::max(kFlattest * a, std::sqrt(std::max(variances.x(), 0.0)));
  double low = 1.6 * a, high = 2.2 * a;  // 1.645 sigma on a line, 2.146 sigma on a circle
  for (int i = 0; i < 40; ++i) {
    const double middle = 0.5 * (low + high);
    (ProbabilityWithin(middle, a, b) < 0.9 ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

std::optional<GroundAccuracy> AccuracyOf(const PhotoView& view, const Matrix6d& covariance,
                                         const GroundSurface& surface, double height_sigma_m) {
  constexpr int kPlaces = 7;
  std::vector<double> errors;
  for (int i = 0; i < kPlaces; ++i)
    for (int j = 0; j < kPlaces; ++j) {
      const Eigen::Vector2d unit(i / (kPlaces - 1.0) - 0.5, j / (kPlaces - 1.0) - 0.5);
      const auto ray =
          GroundRayFromPhoto(view.camera, view.pose,
                             view.camera.frame_centre_mm + unit.cwiseProduct(view.camera.frame_mm));
      const auto ground = ray ? surface.Intersect(*ray) : std::nullopt;
      const auto by = ground ? PixelFromGroundWithDerivatives(view, *ground) : std::nullopt;
      if (!by) continue;
      // What an error of the pose or of the height moves in the photo, the place on the map makes
      // good.
      const Eigen::Matrix2d ground_by_pixel = by->by_ground.leftCols<2>().inverse();
      const Eigen::Matrix<double, 2, 6> by_pose = ground_by_pixel * by->by_pose;
      const Eigen::Vector2d by_height = height_sigma_m * (ground_by_pixel * by->by_ground.col(2));
      errors.push_back(CircularError90(by_pose * covariance * by_pose.transpose() +
                                       by_height * by_height.transpose()));
    }
  if (errors.empty()) return std::nullopt;
  return GroundAccuracy{Median(errors), *std::max_element(errors.begin(), errors.end())};
}

}  // namespace orient::ortho
