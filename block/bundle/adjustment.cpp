#include "block/bundle/adjustment.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>

#include "block/bundle/adjusted_findings.h"
#include "block/bundle/calibration.h"
#include "block/bundle/connected_parts.h"
#include "block/bundle/data_snooping.h"
#include "block/bundle/equations.h"
#include "block/bundle/gnss_shift.h"
#include "block/bundle/normal_equations.h"
#include "block/bundle/outcome.h"
#include "block/bundle/shared_errors.h"
#include "block/bundle/solver.h"
#include "block/bundle/variance_components.h"
#include "core/geometry/intersection.h"

namespace orient::block {
namespace {

constexpr double kCauchyScale = 2;
// At the robust solution, where residuals concentrate in few observations, only those beyond the
// limit by this factor (in chi-square) are rejected.
constexpr double kCaution = 2;
// Photos that move by more than this share of the largest move in a direction that nothing fixes.
constexpr double kMovesAlong = 0.05;
constexpr int kMostFactorRounds = 3;

class Stopwatch {
 public:
  explicit Stopwatch(double* seconds) : seconds_(seconds) {}
  ~Stopwatch() {
    *seconds_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
  }
  Stopwatch(const Stopwatch&) = delete;
  Stopwatch& operator=(const Stopwatch&) = delete;

 private:
  double* seconds_;
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

class Adjustment {
 public:
  Adjustment(const BlockToAdjust& block, const BlockOptions& options, BlockResult* result);
  void Run();

 private:
  void FindFirstPoints();
  void RobustStart();
  void Rounds();
  bool Determine(double cauchy_scale);
  bool NobodyIsLeft() const;
  std::vector<bool> Connecting(bool dismissed_too) const;
  bool DismissWithoutDatum();
  bool DismissUndetermined();
  void Dismiss(std::size_t photo, PhotoState state);
  bool Solve(BlockLoss loss, double tolerance, int iterations);
  BlockTests Test();
  std::unique_ptr<BlockNormals> StatedNormals();
  bool CalibrationChanges();
  void FillResult();
  void Finish();

  BlockResult* result_;
  BlockSystem system_;
  BlockJudgement judgement_;
  std::unique_ptr<BlockSolver> solver_;
  std::unique_ptr<BlockNormals> normals_;
  BlockTests tests_;
  bool dismissed_ = false;  // whether a photo was dismissed in this round
};

Adjustment::Adjustment(const BlockToAdjust& block, const BlockOptions& options, BlockResult* result)
    : result_(result), system_(block, options), judgement_(&system_) {
  result->photos.resize(block.photos.size());
  result->points.resize(block.points.size());
  result->observations.resize(block.observations.size());
  for (LensUnknowns& lens : system_.lens) lens.active.fill(false);
  FindFirstPoints();
  solver_ = std::make_unique<BlockSolver>(&system_);
}

void Adjustment::FindFirstPoints() {
  for (std::size_t i = 0; i < system_.points.size(); ++i) {
    const BlockPoint& point = system_.block.points[i];
    if (point.control || point.approximate_m) continue;
    std::vector<Ray> rays;
    for (const std::size_t row : system_.image_rows_of_point[i]) {
      bool valid = false;
      const Ray ray = system_.LocalRay(row, &valid);
      if (valid) rays.push_back(ray);
    }
    if (const auto place = IntersectRays(rays))
      system_.SetStart(i, *place);
    else
      judgement_.GiveUp(i);
  }
}

void Adjustment::Dismiss(std::size_t photo, PhotoState state) {
  judgement_.Dismiss(photo);
  result_->photos[photo].state = state;
  dismissed_ = true;
}

// Flags active observations; for the final result also those of photos dismissed together.
std::vector<bool> Adjustment::Connecting(bool dismissed_too) const {
  std::vector<bool> connecting(system_.block.observations.size());
  for (std::size_t i = 0; i < connecting.size(); ++i)
    connecting[i] = system_.IsActive(i) ||
                    (dismissed_too && judgement_.states()[i] == ObservationState::kUnusable);
  return connecting;
}

bool Adjustment::DismissWithoutDatum() {
  bool any = false;
  std::vector<int> seen(system_.block.photos.size(), 0);
  for (std::size_t i = 0; i < system_.block.observations.size(); ++i)
    if (system_.IsActive(i)) ++seen[system_.block.observations[i].photo];
  for (std::size_t i = 0; i < seen.size(); ++i)
    if (judgement_.takes_part()[i] && seen[i] == 0) {
      Dismiss(i, PhotoState::kUndetermined);
      any = true;
    }
  for (const BlockPart& part : FindParts(system_, Connecting(false), judgement_.takes_part())) {
    if (part.has_datum) continue;
    for (const std::size_t photo : part.photos)
      if (judgement_.takes_part()[photo]) {
        Dismiss(photo, PhotoState::kNoDatum);
        any = true;
      }
  }
  return any;
}

// Dismisses photos that move in a direction that the normal equations leave open.
bool Adjustment::DismissUndetermined() {
  const BlockCholesky& cholesky = normals_->cholesky();
  std::vector<bool> moves(system_.block.photos.size(), false);
  for (std::size_t i = 0; i < cholesky.Open().size(); ++i) {
    const Eigen::VectorXd direction = cholesky.OpenDirection(i);
    Eigen::VectorXd moved(static_cast<Eigen::Index>(moves.size()));
    for (std::size_t k = 0; k < moves.size(); ++k)
      moved[static_cast<Eigen::Index>(k)] =
          direction.segment<6>(6 * static_cast<Eigen::Index>(system_.pose_group[k])).norm();
    for (std::size_t k = 0; k < moves.size(); ++k)
      if (moved[static_cast<Eigen::Index>(k)] > kMovesAlong * moved.maxCoeff()) moves[k] = true;
  }
  bool any = false;
  for (std::size_t k = 0; k < moves.size(); ++k)
    if (moves[k] && judgement_.takes_part()[k]) {
      Dismiss(k, PhotoState::kUndetermined);
      any = true;
    }
  return any;
}

// Leaves regular equations in normals_, dismissing what cannot be determined; false if nothing
// is left to adjust.
bool Adjustment::Determine(double cauchy_scale) {
  const Stopwatch watch(&result_->timings.snooping);
  for (;;) {
    judgement_.Screen();
    if (DismissWithoutDatum()) continue;
    if (NobodyIsLeft()) return false;
    normals_ = std::make_unique<BlockNormals>(system_, cauchy_scale);
    for (const std::size_t point : normals_->weak_points()) judgement_.GiveUp(point);
    if (!normals_->weak_points().empty()) continue;
    if (normals_->cholesky().Open().empty()) return true;
    if (!DismissUndetermined()) throw std::logic_error("equations open without an open photo");
  }
}

bool Adjustment::NobodyIsLeft() const {
  const auto& takes_part = judgement_.takes_part();
  return std::none_of(takes_part.begin(), takes_part.end(), [](bool takes) { return takes; });
}

// Returns whether the solution converged.
bool Adjustment::Solve(BlockLoss loss, double tolerance, int iterations) {
  const Stopwatch watch(&result_->timings.solve);
  BlockSolve how;
  how.loss = loss;
  how.loss_scale = kCauchyScale;
  how.tolerance = tolerance;
  how.max_iterations = iterations;
  return solver_->Solve(how, &result_->timings);
}

BlockTests Adjustment::Test() {
  const Stopwatch watch(&result_->timings.snooping);
  return normals_->Test();
}

void Adjustment::RobustStart() {
  Solve(BlockLoss::kHuber, 1e-4, 30);
  FactorsFromResiduals(&system_);
  StartCalibration(&system_);
  Solve(BlockLoss::kCauchy, 1e-5, 30);
  const double before = system_.Factor(RowKind::kTieImage);
  FactorsFromResiduals(&system_);
  if (std::abs(system_.Factor(RowKind::kTieImage) / before - 1) > 0.2)
    Solve(BlockLoss::kCauchy, 1e-5, 20);
  if (!system_.options.snooping || !Determine(kCauchyScale)) return;
  tests_ = Test();
  judgement_.Apply(tests_, kCaution);
}

void Adjustment::Rounds() {
  bool clean = false;
  int factor_rounds = 0;
  for (int round = 0; round < system_.options.max_rounds; ++round) {
    dismissed_ = false;
    const bool converged = Solve(BlockLoss::kNone, 1e-9, system_.options.max_iterations);
    if (!Determine(0)) return;
    if (dismissed_) continue;
    tests_ = Test();
    // Variance factors from medians as long as gross errors may remain, afterwards from sums.
    const bool reweighted = !clean && FactorsFromMedians(&system_, &tests_);
    const BlockChanges changes =
        system_.options.snooping ? judgement_.Apply(tests_, 1) : BlockChanges{};
    // Positions wrong by metres are few of the observations, but make up most of their kind's sum.
    clean = clean ||
            (changes.poses == 0 && changes.points <= static_cast<int>(tests_.of_row.size() / 1000));
    // Image and ground of control seen only once share one discrepancy: their factors creep, and
    // nothing else changes with them.
    const bool factors = clean && changes.poses == 0 && factor_rounds < kMostFactorRounds &&
                         FactorsFromSums(tests_, &system_);
    factor_rounds += factors ? 1 : 0;
    if (!converged || changes.All() > 0 || factors || reweighted) continue;
    if (HoldCommonGnssShiftIfInsignificant(tests_, *normals_, judgement_.takes_part(), &system_)) {
      factor_rounds = 0;
      continue;
    }
    if (system_.options.self_calibration && CalibrationChanges()) continue;
    result_->converged = true;
    return;
  }
  result_->findings.push_back({.reason = Reason::kAdjustmentNotConverged});
}

// Normals for the covariances (also sets the points' in tests_); null if as weighted.
std::unique_ptr<BlockNormals> Adjustment::StatedNormals() {
  const StatedPrecision stated(&system_);
  if (!stated.Matters()) return nullptr;
  auto normals = std::make_unique<BlockNormals>(system_, 0);
  tests_.point_covariance = normals->Test().point_covariance;
  return normals;
}

bool Adjustment::CalibrationChanges() {
  const auto stated = StatedNormals();
  return TestCalibration(stated ? *stated : *normals_, &system_, &result_->calibration);
}

void Adjustment::FillResult() {
  // Without convergence, the unknowns may have changed since their equations were checked.
  const auto stated = result_->converged ? StatedNormals() : nullptr;
  const BlockNormals& normals = stated ? *stated : *normals_;
  FillOutcome(system_, judgement_, normals, tests_, result_);
  FillChecks(system_.block, result_);
  // Shared errors propagate through the adjustment as it was weighted.
  AddSharedControlErrors(system_, *normals_, tests_, result_);
}

void Adjustment::Finish() {
  const Stopwatch watch(&result_->timings.covariance);
  result_->parts = FindParts(system_, Connecting(true), judgement_.takes_part());
  for (std::size_t part = 0; part < result_->parts.size(); ++part)
    for (const std::size_t i : result_->parts[part].photos)
      result_->photos[i].part = static_cast<int>(part);
  result_->cameras = CalibratedCameras(system_);
  result_->factors = {
      std::max(system_.Factor(RowKind::kControlImage), system_.Factor(RowKind::kControlGround)),
      system_.Factor(RowKind::kGnss), system_.Factor(RowKind::kPosePrior),
      system_.Factor(RowKind::kMeasuredImage), system_.Factor(RowKind::kSurveyedGround)};
  if (normals_ && !tests_.of_row.empty()) {
    FillResult();
  } else {
    for (std::size_t i = 0; i < result_->photos.size(); ++i)
      result_->photos[i].pose = system_.block.photos[i].approximate;
    for (std::size_t i = 0; i < result_->observations.size(); ++i)
      result_->observations[i].state = judgement_.states()[i];
  }
  const Findings findings = FindingsOfAdjusted(system_.block, system_.options, *result_);
  result_->findings.insert(result_->findings.end(), findings.begin(), findings.end());
}

void Adjustment::Run() {
  if (Determine(0)) {
    if (system_.options.robust_start)
      RobustStart();
    else
      StartCalibration(&system_);
    Rounds();
  }
  if (NobodyIsLeft()) tests_ = {};
  Finish();
}

}  // namespace

BlockResult AdjustBlock(const BlockToAdjust& block, const BlockOptions& options) {
  if (const auto wrong = options.Check()) throw std::invalid_argument(*wrong);
  BlockResult result;
  std::unique_ptr<Adjustment> adjustment;
  {
    const Stopwatch watch(&result.timings.setup);
    adjustment = std::make_unique<Adjustment>(block, options, &result);
  }
  adjustment->Run();
  return result;
}

}  // namespace orient::block
