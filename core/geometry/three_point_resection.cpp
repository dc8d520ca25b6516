// The minimal case of resection.h, in closed form. Reference: B. M. Haralick, C.-N. Lee,
// K. Ottenberg, M. Noelle, "Review and analysis of solutions of the three point perspective pose
// estimation problem", IJCV 13(3), 1994: Grunert's quartic in v = s3 / s1.
#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>

#include "core/geometry/collinearity.h"
#include "core/geometry/resection.h"

namespace orient {
namespace {

// Triangles thinner than this (height / longest side) have no pose.
constexpr double kThinTriangle = 1e-9;
// Solutions whose distances agree to this fraction are one (double root, on the danger cylinder).
constexpr double kSameSolution = 1e-6;
constexpr double kReproduced_mm = 1e-9;
// A projection centre this close to a point (share of the farthest distance) coincides with it:
// this solves the equations, but is no pose of a camera.
constexpr double kOnPoint = 1e-4;

struct Triangle {
  double a2, b2, c2;                      // squared sides: P2 P3, P1 P3, P1 P2
  double cos_alpha, cos_beta, cos_gamma;  // angles between the rays: 2-3, 1-3, 1-2
};

Eigen::Matrix<double, 5, 1> GrunertQuartic(const Triangle& t) {
  const double ca = t.cos_alpha, cb = t.cos_beta, cg = t.cos_gamma;
  const double p = (t.a2 - t.c2) / t.b2, q = (t.a2 + t.c2) / t.b2;
  const double a = t.a2 / t.b2, c = t.c2 / t.b2;
  Eigen::Matrix<double, 5, 1> coefficients;  // of v^0 ... v^4
  coefficients[4] = (p - 1) * (p - 1) - 4 * c * ca * ca;
  coefficients[3] = 4 * (p * (1 - p) * cb - (1 - q) * ca * cg + 2 * c * ca * ca * cb);
  coefficients[2] = 2 * (p * p - 1 + 2 * p * p * cb * cb + 2 * (1 - c) * ca * ca -
                         4 * q * ca * cb * cg + 2 * (1 - a) * cg * cg);
  coefficients[1] = 4 * (-p * (1 + p) * cb + 2 * a * cg * cg * cb - (1 - q) * ca * cg);
  coefficients[0] = (1 + p) * (1 + p) - 4 * a * cg * cg;
  return coefficients;
}

// Real parts of the roots that are real or, for a double root, nearly so. Weierstrass' iteration
// for all roots at once; the distances are polished afterwards.
std::vector<double> NearlyRealRoots(const Eigen::Matrix<double, 5, 1>& coefficients) {
  using Complex = std::complex<double>;
  std::size_t degree = 4;
  const double largest = coefficients.cwiseAbs().maxCoeff();
  while (degree > 0 && std::abs(coefficients[static_cast<int>(degree)]) <= 1e-13 * largest)
    --degree;
  if (!(largest > 0) || degree == 0) return {};
  const Eigen::Matrix<double, 5, 1> monic = coefficients / coefficients[static_cast<int>(degree)];
  std::vector<Complex> roots;
  for (std::size_t i = 0; i < degree; ++i)
    roots.push_back(std::pow(Complex(0.4, 0.9), static_cast<double>(i)));
  constexpr int kMaxIterations = 80;
  double change = 1;
  for (int iteration = 0; iteration < kMaxIterations && change > 1e-13; ++iteration) {
    change = 0;
    for (std::size_t i = 0; i < degree; ++i) {
      Complex value = 1, others = 1;
      for (std::size_t j = degree; j-- > 0;) value = value * roots[i] + monic[static_cast<int>(j)];
      for (std::size_t j = 0; j < degree; ++j)
        if (j != i) others *= roots[i] - roots[j];
      const Complex step = value / others;
      if (!std::isfinite(step.real()) || !std::isfinite(step.imag())) continue;
      roots[i] -= step;
      change = std::max(change, std::abs(step) / (1 + std::abs(roots[i])));
    }
  }
  std::vector<double> real;
  for (const Complex& root : roots)
    if (std::abs(root.imag()) < 1e-3 * (1 + std::abs(root.real()))) real.push_back(root.real());
  return real;
}

// Newton's iteration on the three cosine laws; false where it does not come to a positive solution.
bool PolishDistances(const Triangle& t, Eigen::Vector3d* s) {
  const double size = t.a2 + t.b2 + t.c2;
  double best = std::numeric_limits<double>::infinity();
  bool converged = false;
  for (int i = 0; i < 50; ++i) {
    const double s1 = (*s)[0], s2 = (*s)[1], s3 = (*s)[2];
    const Eigen::Vector3d error(s2 * s2 + s3 * s3 - 2 * s2 * s3 * t.cos_alpha - t.a2,
                                s1 * s1 + s3 * s3 - 2 * s1 * s3 * t.cos_beta - t.b2,
                                s1 * s1 + s2 * s2 - 2 * s1 * s2 * t.cos_gamma - t.c2);
    const double norm = error.norm();
    const double limit = 1e-11 * (size + s->squaredNorm() * 1e-3);
    converged = norm <= limit;
    if (converged && norm >= 0.5 * best) break;
    best = std::min(best, norm);
    Eigen::Matrix3d slope;
    slope << 0, 2 * (s2 - s3 * t.cos_alpha), 2 * (s3 - s2 * t.cos_alpha),  //
        2 * (s1 - s3 * t.cos_beta), 0, 2 * (s3 - s1 * t.cos_beta),         //
        2 * (s1 - s2 * t.cos_gamma), 2 * (s2 - s1 * t.cos_gamma), 0;
    const Eigen::Vector3d step = slope.fullPivLu().solve(error);
    if (!(step.norm() <= 0.5 * s->norm())) break;  // singular, or diverging
    *s -= step;
  }
  return converged && s->minCoeff() > kOnPoint * s->maxCoeff();
}

void AddIfNew(const Eigen::Vector3d& s, std::vector<Eigen::Vector3d>* solutions) {
  for (const Eigen::Vector3d& known : *solutions)
    if ((s - known).norm() < kSameSolution * known.norm()) return;
  solutions->push_back(s);
}

// Distances from the projection centre to the three points.
std::vector<Eigen::Vector3d> Distances(const Triangle& t) {
  std::vector<Eigen::Vector3d> solutions;
  for (const double v : NearlyRealRoots(GrunertQuartic(t))) {
    const double denominator = 1 + v * v - 2 * v * t.cos_beta;
    if (!(v > 0) || !(denominator > 0)) continue;
    const double s1 = std::sqrt(t.b2 / denominator);
    // u from the cosine law of P1 P2. Grunert's own formula for u divides by zero in symmetrical
    // cases; of the two roots here, the wrong one fails in Newton's iteration or leads to a known
    // solution.
    const double under = t.cos_gamma * t.cos_gamma - 1 + t.c2 / t.b2 * denominator;
    const double root = std::sqrt(std::max(under, 0.0));
    for (const double u : {t.cos_gamma + root, t.cos_gamma - root}) {
      Eigen::Vector3d s = s1 * Eigen::Vector3d(1, u, v);
      if (u > 0 && PolishDistances(t, &s)) AddIfNew(s, &solutions);
    }
  }
  return solutions;
}

// Right-handed axes of a triangle: along its first side, normal, and their product.
Eigen::Matrix3d TriangleAxes(const Eigen::Matrix3d& points) {
  const Eigen::Vector3d along = (points.col(1) - points.col(0)).normalized();
  const Eigen::Vector3d normal = along.cross(points.col(2) - points.col(0)).normalized();
  Eigen::Matrix3d axes;
  axes << along, normal, along.cross(normal);
  return axes;
}

// Computed - measured of the three image points, with derivatives; empty where one is not seen.
struct Misfit {
  Eigen::Matrix<double, 6, 1> error;
  Eigen::Matrix<double, 6, 6> by_pose;
};

std::optional<Misfit> MisfitOf(const Camera& camera, const Pose& pose,
                               const std::array<ControlObservation, 3>& observations) {
  Misfit misfit;
  const PosedCamera posed(camera, pose);
  for (Eigen::Index i = 0; i < 3; ++i) {
    const ControlObservation& observation = observations[static_cast<std::size_t>(i)];
    const auto projected = posed.PhotoFromGroundWithDerivatives(observation.ground_m);
    if (!projected) return std::nullopt;
    misfit.error.segment<2>(2 * i) = projected->photo_mm - observation.photo_mm;
    misfit.by_pose.middleRows<2>(2 * i) = projected->by_pose;
  }
  return misfit;
}

// Effect of rounding of the ground coordinates on the photo coordinates, mm.
double Rounding(const Camera& camera, const Pose& pose, const Eigen::Vector3d& ground_m) {
  return 16 * std::numeric_limits<double>::epsilon() * ground_m.norm() *
         camera.principal_distance_mm / (ground_m - pose.position_m).norm();
}

// Newton's iteration on the pose: removes rounding errors of the distances (thin triangles).
// False if the pose does not reproduce the three image points.
bool PolishPose(const Camera& camera, const std::array<ControlObservation, 3>& observations,
                Pose* pose) {
  auto misfit = MisfitOf(camera, *pose, observations);
  for (int i = 0; i < 3 && misfit; ++i) {
    if (misfit->error.norm() < 0.1 * kReproduced_mm) break;
    const Vector6d step = misfit->by_pose.partialPivLu().solve(misfit->error);
    const Pose better = Pose::FromVector(pose->AsVector() - step);
    const auto smaller = step.allFinite() ? MisfitOf(camera, better, observations) : std::nullopt;
    if (!smaller || !(smaller->error.norm() < misfit->error.norm())) break;
    *pose = better;
    misfit = smaller;
  }
  if (!misfit) return false;
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d& ground_m = observations[static_cast<std::size_t>(i)].ground_m;
    if (misfit->error.segment<2>(2 * i).norm() > kReproduced_mm + Rounding(camera, *pose, ground_m))
      return false;
  }
  for (double& angle : pose->opk_rad) angle = NormalizeAngle(angle);
  return true;
}

}  // namespace

std::vector<Pose> ResectThreePoints(const Camera& camera,
                                    const std::array<ControlObservation, 3>& observations) {
  Eigen::Matrix3d ground, rays;
  const Eigen::Vector3d origin = observations[0].ground_m;
  for (Eigen::Index i = 0; i < 3; ++i) {
    const ControlObservation& observation = observations[static_cast<std::size_t>(i)];
    const auto ideal =
        UndistortPoint(camera.lens, observation.photo_mm - camera.principal_point_mm);
    if (!ideal) return {};
    ground.col(i) = observation.ground_m - origin;
    rays.col(i) =
        Eigen::Vector3d(ideal->x(), ideal->y(), -camera.principal_distance_mm).normalized();
  }
  const Triangle triangle = {(ground.col(1) - ground.col(2)).squaredNorm(),
                             ground.col(2).squaredNorm(),
                             ground.col(1).squaredNorm(),
                             rays.col(1).dot(rays.col(2)),
                             rays.col(0).dot(rays.col(2)),
                             rays.col(0).dot(rays.col(1))};
  const double longest2 = std::max({triangle.a2, triangle.b2, triangle.c2});
  if (!(ground.col(1).cross(ground.col(2)).norm() > kThinTriangle * longest2)) return {};

  std::vector<Pose> poses;
  for (const Eigen::Vector3d& s : Distances(triangle)) {
    const Eigen::Matrix3d photo = rays * s.asDiagonal();
    const Eigen::Matrix3d ground_from_photo =
        TriangleAxes(ground) * TriangleAxes(photo).transpose();
    Pose pose;
    pose.opk_rad = OpkFromRotation(ground_from_photo);
    pose.position_m = origin + (ground - pose.GroundFromPhoto() * photo).rowwise().mean();
    if (PolishPose(camera, observations, &pose)) poses.push_back(pose);
  }
  return poses;
}

}  // namespace orient
