#include "block/bundle/solver.h"

#include <ceres/ceres.h>

#include <vector>

namespace orient::block {
namespace {

// With few photos the reduced equations are dense anyway.
constexpr int kDensePhotos = 30;

ceres::Problem::Options Ownership() {
  ceres::Problem::Options options;
  options.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.enable_fast_removal = true;
  options.disable_all_safety_checks = true;
  return options;
}

}  // namespace

struct BlockSolver::Problem {
  ceres::LossFunctionWrapper loss{nullptr, ceres::TAKE_OWNERSHIP};
  ceres::Problem problem{Ownership()};
  std::vector<ceres::ResidualBlockId> ids;  // of each row; null: not in the problem
};

BlockSolver::BlockSolver(BlockSystem* system)
    : system_(system), problem_(std::make_unique<Problem>()) {
  for (Vector6d& group : system->groups) problem_->problem.AddParameterBlock(group.data(), 6);
  for (Eigen::Vector3d& point : system->points)
    problem_->problem.AddParameterBlock(point.data(), 3);
  problem_->ids.assign(system->rows.size(), nullptr);
  Synchronise();
}

BlockSolver::~BlockSolver() = default;

void BlockSolver::Synchronise() {
  for (std::size_t i = 0; i < system_->rows.size(); ++i) {
    const BlockRows& row = system_->rows[i];
    ceres::ResidualBlockId& id = problem_->ids[i];
    if (row.active == (id != nullptr)) continue;
    if (!row.active) {
      problem_->problem.RemoveResidualBlock(id);
      id = nullptr;
      continue;
    }
    std::array<double*, 4> unknowns = {};
    int count = 0;
    for (const double* unknown : system_->Unknowns(row))
      // The unknowns belong to the system, which was passed to this object to be changed.
      if (unknown != nullptr)
        unknowns.at(static_cast<std::size_t>(count++)) = const_cast<double*>(unknown);  // NOLINT
    ceres::LossFunction* loss = IsUnknown(row.kind) ? nullptr : &problem_->loss;
    id = problem_->problem.AddResidualBlock(row.cost.get(), loss, unknowns.data(), count);
  }
}

bool BlockSolver::Solve(const BlockSolve& how, BlockTimings* timings) {
  Synchronise();
  if (how.loss == BlockLoss::kNone)
    problem_->loss.Reset(nullptr, ceres::TAKE_OWNERSHIP);
  else if (how.loss == BlockLoss::kHuber)
    problem_->loss.Reset(new ceres::HuberLoss(how.loss_scale), ceres::TAKE_OWNERSHIP);
  else
    problem_->loss.Reset(new ceres::CauchyLoss(how.loss_scale), ceres::TAKE_OWNERSHIP);
  ceres::Solver::Options options;
  options.linear_solver_type =
      system_->pose_groups <= kDensePhotos ? ceres::DENSE_SCHUR : ceres::SPARSE_SCHUR;
  options.linear_solver_ordering = std::make_shared<ceres::ParameterBlockOrdering>();
  for (Eigen::Vector3d& point : system_->points)
    options.linear_solver_ordering->AddElementToGroup(point.data(), 0);
  for (Vector6d& group : system_->groups)
    options.linear_solver_ordering->AddElementToGroup(group.data(), 1);
  // Undamped Gauss-Newton steps near the solution, so that weak block deformations converge, too.
  if (how.loss == BlockLoss::kNone) options.initial_trust_region_radius = 1e10;
  options.max_num_iterations = how.max_iterations;
  options.function_tolerance = how.tolerance;
  options.gradient_tolerance = 1e-14;
  options.parameter_tolerance = 1e-12;
  options.num_threads = system_->options.threads;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem_->problem, &summary);
  timings->ceres += summary.total_time_in_seconds;
  timings->iterations += static_cast<int>(summary.iterations.size());
  ++timings->solves;
  // IsSolutionUsable() would also accept a run that was stopped early.
  return summary.termination_type == ceres::CONVERGENCE;
}

}  // namespace orient::block
