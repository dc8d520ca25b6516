#include "core/geometry/resection.h"

#include <ceres/ceres.h>

#include <Eigen/Dense>
#include <cmath>
#include <memory>
#include <stdexcept>

#include "core/geometry/collinearity.h"
#include "core/geometry/dense_solvers.h"

namespace orient {
namespace {

// Normal matrices with a unit diagonal whose smallest eigenvalue lies below this are singular.
constexpr double kSingular = 1e-13;
// An adjustment has converged when the next step would move the pose by less than this part of its
// own standard deviation.
constexpr double kConverged = 1e-4;
// With many gross errors the robust minimisation may stall; restarted from there it converges.
constexpr int kAttempts = 4;

using RowMajor26 = Eigen::Matrix<double, 2, 6, Eigen::RowMajor>;

// The unknowns are of the order of 1: (position - start) / distance to the ground, and the angles'
// differences from the start. Large ground coordinates do not enter the adjustment.
struct Unknowns {
  Pose start;
  double scale_m = 1;

  Vector6d Scales() const {
    return (Vector6d() << Eigen::Vector3d::Constant(scale_m), Eigen::Vector3d::Ones()).finished();
  }
  // The pose with the start's position as the origin.
  Pose Local(const double* u) const {
    const Eigen::Map<const Vector6d> unknowns(u);
    return {unknowns.head<3>() * scale_m, start.opk_rad + unknowns.tail<3>()};
  }
};

Eigen::Matrix2d Whitening(const Eigen::Matrix2d& covariance) {
  const Eigen::LLT<Eigen::Matrix2d> cholesky(covariance);
  if (cholesky.info() != Eigen::Success || !covariance.allFinite())
    throw std::invalid_argument("the covariance of a control observation is not positive definite");
  return cholesky.matrixL().solve(Eigen::Matrix2d::Identity());
}

// Normalised residual of an image point: (computed - measured), whitened.
class ImageCost : public ceres::SizedCostFunction<2, 6> {
 public:
  ImageCost(const Camera& camera, const Unknowns& unknowns, const ControlObservation& observation)
      : camera_(camera),
        unknowns_(unknowns),
        offset_m_(observation.ground_m - unknowns.start.position_m),
        photo_mm_(observation.photo_mm),
        whitening_(Whitening(observation.covariance_mm2)) {}

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    const auto projected =
        PhotoFromGroundWithDerivatives(camera_, unknowns_.Local(parameters[0]), offset_m_);
    if (!projected) return false;
    Eigen::Map<Eigen::Vector2d> residual(residuals);
    residual = whitening_ * (projected->photo_mm - photo_mm_);
    if (jacobians != nullptr && jacobians[0] != nullptr) {
      Eigen::Map<RowMajor26> jacobian(jacobians[0]);
      jacobian = whitening_ * projected->by_pose * unknowns_.Scales().asDiagonal();
    }
    return true;
  }

  const Eigen::Matrix2d& whitening() const { return whitening_; }

 private:
  const Camera& camera_;
  const Unknowns& unknowns_;
  Eigen::Vector3d offset_m_;
  Eigen::Vector2d photo_mm_;
  Eigen::Matrix2d whitening_;
};

// Normalised residual of the prior: (computed - prior), whitened.
class PriorCost : public ceres::SizedCostFunction<6, 6> {
 public:
  PriorCost(const PosePrior& prior, const Unknowns& unknowns) {
    const Eigen::LLT<Matrix6d> cholesky(prior.covariance);
    if (cholesky.info() != Eigen::Success || !prior.covariance.allFinite())
      throw std::invalid_argument("the covariance of the pose prior is not positive definite");
    const Matrix6d whitening = cholesky.matrixL().solve(Matrix6d::Identity());
    Vector6d offset;
    offset.head<3>() = unknowns.start.position_m - prior.pose.position_m;
    for (int i = 0; i < 3; ++i)
      offset[3 + i] = NormalizeAngle(unknowns.start.opk_rad[i] - prior.pose.opk_rad[i]);
    at_start_ = whitening * offset;
    slope_ = whitening * unknowns.Scales().asDiagonal();
  }

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    const Eigen::Map<const Vector6d> unknowns(parameters[0]);
    Eigen::Map<Vector6d> residual(residuals);
    residual = at_start_ + slope_ * unknowns;
    if (jacobians != nullptr && jacobians[0] != nullptr) {
      Eigen::Map<Eigen::Matrix<double, 6, 6, Eigen::RowMajor>> jacobian(jacobians[0]);
      jacobian = slope_;
    }
    return true;
  }

 private:
  Vector6d at_start_;
  Matrix6d slope_;
};

struct Adjustment {
  Unknowns unknowns;
  std::vector<std::unique_ptr<ImageCost>> image;
  std::unique_ptr<PriorCost> prior;
  std::unique_ptr<ceres::LossFunction> loss;
  Vector6d solution = Vector6d::Zero();
};

std::optional<double> DistanceToGround(const Camera& camera, const Pose& start,
                                       const std::vector<ControlObservation>& observations) {
  double sum = 0;
  for (const ControlObservation& observation : observations) {
    if (!PhotoFromGround(camera, start, observation.ground_m)) return std::nullopt;
    sum += (observation.ground_m - start.position_m).norm();
  }
  return observations.empty() ? 1.0 : sum / static_cast<double>(observations.size());
}

void Minimise(Adjustment* adjustment, int max_iterations) {
  ceres::Problem::Options ownership;
  ownership.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ownership.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::Problem problem(ownership);
  double* unknowns = adjustment->solution.data();
  for (const auto& cost : adjustment->image)
    problem.AddResidualBlock(cost.get(), adjustment->loss.get(), unknowns);
  if (adjustment->prior) problem.AddResidualBlock(adjustment->prior.get(), nullptr, unknowns);
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.max_num_iterations = max_iterations;
  options.function_tolerance = 1e-15;
  options.gradient_tolerance = 1e-15;
  options.parameter_tolerance = 1e-13;
  options.num_threads = 1;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
}

// The weighted normal equations at the solution, and what each image point contributes.
struct Normal {
  Matrix6d matrix = Matrix6d::Zero();
  Vector6d gradient = Vector6d::Zero();
  double square_sum = 0;  // v'Pv with the robust weights
  std::vector<RowMajor26> rows;
  std::vector<double> weights;
};

bool BuildNormal(const Adjustment& adjustment, Normal* normal) {
  const double* unknowns = adjustment.solution.data();
  for (const auto& cost : adjustment.image) {
    Eigen::Vector2d residual;
    RowMajor26 row;
    double* jacobian = row.data();
    if (!cost->Evaluate(&unknowns, residual.data(), &jacobian)) return false;
    double rho[3] = {0, 1, 0};
    if (adjustment.loss) adjustment.loss->Evaluate(residual.squaredNorm(), rho);
    normal->matrix += rho[1] * row.transpose() * row;
    normal->gradient += rho[1] * row.transpose() * residual;
    normal->square_sum += rho[1] * residual.squaredNorm();
    normal->rows.push_back(row);
    normal->weights.push_back(rho[1]);
  }
  if (!adjustment.prior) return true;
  Vector6d residual;
  Eigen::Matrix<double, 6, 6, Eigen::RowMajor> row;
  double* jacobian = row.data();
  adjustment.prior->Evaluate(&unknowns, residual.data(), &jacobian);
  normal->matrix += row.transpose() * row;
  normal->gradient += row.transpose() * residual;
  normal->square_sum += residual.squaredNorm();
  return true;
}

// The inverse of a normal matrix; empty where it is singular.
std::optional<Matrix6d> InverseNormal(const Matrix6d& matrix) {
  const Vector6d diagonal = matrix.diagonal();
  if (!(diagonal.minCoeff() > 0) || !matrix.allFinite()) return std::nullopt;
  const Vector6d scale = diagonal.cwiseSqrt().cwiseInverse();
  const Matrix6d scaled = scale.asDiagonal() * matrix * scale.asDiagonal();
  const SymmetricEigen eigen = EigenOfSymmetric(scaled);
  if (!(eigen.values[0] > kSingular * eigen.values[5])) return std::nullopt;
  const Matrix6d half = eigen.vectors * eigen.values.cwiseSqrt().cwiseInverse().asDiagonal();
  const Matrix6d inverse = half * half.transpose();
  return Matrix6d(scale.asDiagonal() * inverse * scale.asDiagonal());
}

ResectionResult Evaluate(const Adjustment& adjustment, const Normal& normal,
                         const Matrix6d& inverse, const Camera& camera,
                         const std::vector<ControlObservation>& observations) {
  ResectionResult result;
  const Pose local = adjustment.unknowns.Local(adjustment.solution.data());
  result.pose.position_m = adjustment.unknowns.start.position_m + local.position_m;
  for (int i = 0; i < 3; ++i) result.pose.opk_rad[i] = NormalizeAngle(local.opk_rad[i]);
  const Vector6d scales = adjustment.unknowns.Scales();
  result.covariance = scales.asDiagonal() * inverse * scales.asDiagonal();
  for (std::size_t i = 0; i < observations.size(); ++i) {
    const Eigen::Vector3d offset = observations[i].ground_m - adjustment.unknowns.start.position_m;
    result.residuals_mm.push_back(observations[i].photo_mm -
                                  PhotoFromGround(camera, local, offset).value());
    const RowMajor26& row = normal.rows[i];
    result.redundancy.push_back(2 - normal.weights[i] * (row * inverse * row.transpose()).trace());
  }
  result.degrees_of_freedom =
      static_cast<int>(2 * observations.size()) - (adjustment.prior ? 0 : 6);
  if (result.degrees_of_freedom > 0)
    result.sigma0 = std::sqrt(normal.square_sum / result.degrees_of_freedom);
  result.converged = true;
  return result;
}

}  // namespace

std::vector<Eigen::Index> StatedElements(const PosePrior& prior) {
  std::vector<Eigen::Index> stated;
  for (Eigen::Index i = 0; i < 6; ++i) {
    const double open = i < 3 ? kOpenPosition_m : kOpenAttitude_rad;
    if (!(prior.covariance(i, i) >= open * open)) stated.push_back(i);
  }
  return stated;
}

std::optional<std::string> ResectionOptions::Check() const {
  if (!(robust_scale >= 0)) return "robust_scale must be 0 (none) or positive";
  if (max_iterations < 1) return "max_iterations must be at least 1";
  return std::nullopt;
}

std::optional<ResectionResult> Resect(const Camera& camera,
                                      const std::vector<ControlObservation>& observations,
                                      const Pose& start, const ResectionOptions& options) {
  if (const auto wrong = options.Check()) throw std::invalid_argument(*wrong);
  if (!options.prior && observations.size() < 3) return std::nullopt;
  const auto distance_m = DistanceToGround(camera, start, observations);
  if (!distance_m || !(*distance_m > 0)) return std::nullopt;

  Adjustment adjustment;
  adjustment.unknowns = {start, *distance_m};
  for (const ControlObservation& observation : observations)
    adjustment.image.push_back(
        std::make_unique<ImageCost>(camera, adjustment.unknowns, observation));
  if (options.prior)
    adjustment.prior = std::make_unique<PriorCost>(*options.prior, adjustment.unknowns);
  if (options.robust_scale > 0)
    adjustment.loss = std::make_unique<ceres::CauchyLoss>(options.robust_scale);
  for (int attempt = 0; attempt < (adjustment.loss ? kAttempts : 1); ++attempt) {
    Minimise(&adjustment, options.max_iterations);
    Normal normal;
    if (!BuildNormal(adjustment, &normal)) return std::nullopt;
    const auto inverse = InverseNormal(normal.matrix);
    if (!inverse) return std::nullopt;
    const double next_step = std::sqrt(normal.gradient.dot(*inverse * normal.gradient));
    if (next_step < kConverged) return Evaluate(adjustment, normal, *inverse, camera, observations);
  }
  return std::nullopt;
}

}  // namespace orient
