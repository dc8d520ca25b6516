#include "core/terrain/ground_accuracy.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

#include "core/base/median.h"
#include "core/terrain/pixel_derivatives.h"

namespace orient {
namespace {

constexpr int kAngles = 500;  // of a quadrant: the other three are alike

// cos^2 and sin^2 of the middles of the angles.
struct Squares {
  std::array<double, kAngles> cosine, sine;
};

const Squares& SquaresOfAngles() {
  static const Squares kSquares = [] {
    Squares squares{};
    for (std::size_t i = 0; i < kAngles; ++i) {
      const double angle = 0.5 * std::numbers::pi * (static_cast<double>(i) + 0.5) / kAngles;
      squares.cosine[i] = std::cos(angle) * std::cos(angle);
      squares.sine[i] = std::sin(angle) * std::sin(angle);
    }
    return squares;
  }();
  return kSquares;
}

struct Within {
  double probability, density;  // of a point within the radius, and its derivative by the radius
};

// For sigmas a >= b > 0: the density integrated in polar coordinates, along the radius in closed
// form, over the angle by the midpoint rule, which for a periodic function converges faster than
// any power of the step.
Within ProbabilityWithin(double r, double a, double b) {
  const Squares& squares = SquaresOfAngles();
  double probability = 0, density = 0;
  for (std::size_t i = 0; i < kAngles; ++i) {
    const double g = squares.cosine[i] / (a * a) + squares.sine[i] / (b * b);
    const double tail = std::exp(-0.5 * r * r * g);
    probability += (1 - tail) / g;
    density += r * tail;
  }
  return {probability / (kAngles * a * b), density / (kAngles * a * b)};
}

}  // namespace

double CircularError90(const Eigen::Matrix2d& covariance) {
  const Eigen::Vector2d variances =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(covariance, Eigen::EigenvaluesOnly)
          .eigenvalues();
  constexpr double kFlattest = 0.01;  // flatter ellipses make no difference
  const double a = std::sqrt(std::max(variances.y(), 0.0));
  if (!(a > 0)) return 0;
  const double b = std::max(kFlattest * a, std::sqrt(std::max(variances.x(), 0.0)));
  // From below, where the probability's slope falls, Newton's steps do not overshoot. The radius is
  // 1.645 sigma on a line, 2.146 sigma on a circle.
  double radius = 1.6 * a;
  for (int i = 0; i < 6; ++i) {
    const Within within = ProbabilityWithin(radius, a, b);
    radius += (0.9 - within.probability) / within.density;
  }
  return radius;
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
      // A displacement in the photo by errors of pose or height is equivalent to one of the ground
      // position.
      const Eigen::Matrix2d ground_by_pixel = by->by_ground.leftCols<2>().inverse();
      const Eigen::Matrix<double, 2, 6> by_pose = ground_by_pixel * by->by_pose;
      const Eigen::Vector2d by_height = height_sigma_m * (ground_by_pixel * by->by_ground.col(2));
      errors.push_back(CircularError90(by_pose * covariance * by_pose.transpose() +
                                       by_height * by_height.transpose()));
    }
  if (errors.empty()) return std::nullopt;
  return GroundAccuracy{Median(errors), *std::max_element(errors.begin(), errors.end())};
}

}  // namespace orient
