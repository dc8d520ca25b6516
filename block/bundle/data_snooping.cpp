#include "block/bundle/data_snooping.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <map>

#include "core/base/chi_square.h"
#include "core/geometry/intersection.h"

namespace orient::block {
namespace {

constexpr double kMinRayAngle_deg = 1.5;  // ties whose largest ray angle is smaller are not used

// A gross error affects the residuals around it. Of a photo's suspects, only those with at least
// this share of its worst one's chi-square are rejected in the same round.
constexpr double kNearlyAsBad = 0.1;
// Above this ratio of the test values of a tie's rays, it is undecided which of them is wrong.
constexpr double kNotTold = 0.8;
// Reinstated observations must test below this share of the limit, or they might go again.
constexpr double kFitsAgain = 0.8;

}  // namespace

struct BlockJudgement::Suspect {
  std::size_t point = 0;
  double score = 0;     // test over limit
  std::size_t row = 0;  // image row, unless it is the control
  bool control = false;
  bool not_told = false;  // another ray of the tie is nearly as bad
};

BlockJudgement::BlockJudgement(BlockSystem* system) : system_(system) {
  const BlockToAdjust& block = system->block;
  takes_part_.assign(block.photos.size(), true);
  given_up_.assign(block.points.size(), false);
  control_rejected_.assign(block.points.size(), false);
  control_put_back_.assign(block.points.size(), false);
  put_back_.assign(block.observations.size(), false);
  pose_put_back_.assign(system->rows.size(), false);
  states_.assign(block.observations.size(), ObservationState::kUsed);
  for (std::size_t i = 0; i < states_.size(); ++i)
    if (block.points[block.observations[i].point].held_out) states_[i] = ObservationState::kHeldOut;
  for (int dof = 1; dof < std::ssize(limits_); ++dof)
    limits_.at(static_cast<std::size_t>(dof)) = ChiSquareLimit(dof, system->options.significance);
}

void BlockJudgement::Dismiss(std::size_t photo) {
  takes_part_[photo] = false;
  for (std::size_t i = 0; i < states_.size(); ++i) {
    if (system_->block.observations[i].photo != photo) continue;
    if (states_[i] == ObservationState::kHeldOut) continue;
    states_[i] = ObservationState::kUnusable;
    system_->rows[i].active = false;
  }
  for (std::size_t i = states_.size(); i < system_->rows.size(); ++i) {
    BlockRows& row = system_->rows[i];
    if (row.OfPose() && row.source == photo) row.active = false;
  }
}

void BlockJudgement::GiveUp(std::size_t point) {
  given_up_[point] = true;
  ScreenPoint(point);
}

double BlockJudgement::LargestAngle(const std::vector<std::size_t>& rows) const {
  double largest = 0;
  std::vector<Eigen::Vector3d> directions;
  for (const std::size_t row : rows) {
    bool valid = false;
    const Ray ray = system_->LocalRay(row, &valid);
    if (!valid) continue;
    for (const Eigen::Vector3d& other : directions)
      largest = std::max(largest, other.cross(ray.direction).norm());
    directions.push_back(ray.direction);
  }
  return std::asin(std::min(largest, 1.0));
}

bool BlockJudgement::Screen() {
  bool changed = false;
  for (std::size_t i = 0; i < system_->points.size(); ++i)
    if (ScreenPoint(i)) changed = true;
  return changed;
}

bool BlockJudgement::ScreenPoint(std::size_t point) {
  std::vector<std::size_t> rows;
  for (const std::size_t row : system_->image_rows_of_point[point])
    if (states_[row] == ObservationState::kUsed || states_[row] == ObservationState::kAlone ||
        states_[row] == ObservationState::kWeakAngle)
      rows.push_back(row);
  ObservationState state = ObservationState::kUsed;
  const bool has_control = system_->control_row_of_point[point] >= 0 && !control_rejected_[point];
  if (!given_up_[point] && !has_control && rows.size() < 2)
    state = ObservationState::kAlone;
  else if (given_up_[point] || (!has_control && LargestAngle(rows) < RadFromDeg(kMinRayAngle_deg)))
    state = ObservationState::kWeakAngle;
  bool changed = false;
  for (const std::size_t row : rows) {
    changed = changed || states_[row] != state;
    states_[row] = state;
    system_->rows[row].active = state == ObservationState::kUsed;
  }
  // Control that no photo sees constrains nothing.
  system_->SetControlActive(point,
                            has_control && state == ObservationState::kUsed && !rows.empty());
  return changed;
}

double BlockJudgement::Score(const RowTest& test) const {
  return test.dof == 0 ? 0 : test.t / limits_.at(static_cast<std::size_t>(test.dof));
}

// The worst observation of every point, if it tests beyond `caution` times the limit.
std::vector<BlockJudgement::Suspect> BlockJudgement::FindSuspects(const BlockTests& tests,
                                                                  double caution) const {
  std::vector<Suspect> suspects;
  for (std::size_t point = 0; point < system_->points.size(); ++point) {
    Suspect worst{point};
    double second = 0;
    bool seen = false;
    for (const std::size_t row : system_->image_rows_of_point[point]) {
      if (!system_->rows[row].active) continue;
      const double score = Score(tests.of_row[row]);
      second = std::max(second, std::min(score, worst.score));
      // A ray that cannot be tested (no redundancy) is the suspect if only its control tests badly.
      if (!seen || score > worst.score) worst = {point, score, row, false, false};
      seen = true;
    }
    const bool has_control = system_->HasControl(point);
    // For a control patch seen once, it is undecidable whether image or ground is wrong.
    if (has_control && (system_->Rays(point) > 1 || worst.score <= caution)) {
      const double score = Score(tests.of_control[point]);
      if (score > worst.score) worst = {point, score, worst.row, system_->Rays(point) > 1, false};
    }
    // Two rays have only one discrepancy, which does not show which of them is the wrong one.
    worst.not_told = !has_control && (second > kNotTold * worst.score || system_->Rays(point) == 2);
    if (worst.score > caution) suspects.push_back(worst);
  }
  return suspects;
}

int BlockJudgement::Reject(const BlockTests& tests, double caution) {
  const std::vector<Suspect> suspects = FindSuspects(tests, caution);
  std::vector<double> worst_of_photo(takes_part_.size(), 0);
  const auto for_each_photo = [&](const Suspect& suspect, const auto& apply) {
    for (const std::size_t row : system_->image_rows_of_point[suspect.point])
      if (system_->rows[row].active && (suspect.control || suspect.not_told || row == suspect.row))
        apply(system_->block.observations[row].photo);
  };
  for (const Suspect& suspect : suspects)
    for_each_photo(suspect, [&](std::size_t photo) {
      worst_of_photo[photo] = std::max(worst_of_photo[photo], suspect.score);
    });
  int rejected = 0;
  for (const Suspect& suspect : suspects) {
    bool goes = true;
    for_each_photo(suspect, [&](std::size_t photo) {
      goes = goes && suspect.score >= kNearlyAsBad * worst_of_photo[photo];
    });
    if (!goes) continue;
    RejectAt(suspect, tests);
    ++rejected;
  }
  return rejected;
}

void BlockJudgement::RejectAt(const Suspect& suspect, const BlockTests& tests) {
  if (suspect.control) {
    control_rejected_[suspect.point] = true;
    return;
  }
  const bool both = system_->Rays(suspect.point) == 2;
  for (const std::size_t row : system_->image_rows_of_point[suspect.point]) {
    if (!system_->rows[row].active) continue;
    const bool as_bad = both || Score(tests.of_row[row]) > kNotTold * suspect.score;
    if (row != suspect.row && !(suspect.not_told && as_bad)) continue;
    states_[row] = ObservationState::kRejected;
    system_->rows[row].active = false;
  }
}

int BlockJudgement::PutBack(const BlockTests& tests) {
  int count = 0;
  for (std::size_t point = 0; point < system_->points.size(); ++point) {
    if (system_->Rays(point) == 0) continue;
    if (control_rejected_[point] && !control_put_back_[point] && tests.of_control[point].dof > 0 &&
        Score(tests.of_control[point]) < kFitsAgain) {
      control_put_back_[point] = true;
      control_rejected_[point] = false;
      ++count;
    }
    for (const std::size_t row : system_->image_rows_of_point[point]) {
      if (states_[row] != ObservationState::kRejected || put_back_[row]) continue;
      if (tests.of_row[row].dof == 0 || Score(tests.of_row[row]) >= kFitsAgain) continue;
      states_[row] = ObservationState::kUsed;
      system_->rows[row].active = true;
      put_back_[row] = true;
      ++count;
    }
  }
  return count;
}

// Reinstates ties that lost all their rays because the poses were wrong at the time.
int BlockJudgement::PutBackDissolved() {
  int count = 0;
  for (std::size_t point = 0; point < system_->points.size(); ++point) {
    if (given_up_[point] || system_->Rays(point) > 0) continue;
    std::vector<std::size_t> rows;
    bool any_rejected = false;
    for (const std::size_t row : system_->image_rows_of_point[point]) {
      const bool rejected = states_[row] == ObservationState::kRejected;
      const bool left_over =
          states_[row] == ObservationState::kAlone || states_[row] == ObservationState::kWeakAngle;
      if (!(rejected && !put_back_[row]) && !left_over) continue;
      any_rejected = any_rejected || rejected;
      rows.push_back(row);
    }
    if (!any_rejected || rows.size() < 2 || !RaysAgree(point, rows)) continue;
    for (const std::size_t row : rows) {
      states_[row] = ObservationState::kUsed;
      put_back_[row] = true;
    }
    ++count;
  }
  return count;
}

bool BlockJudgement::RaysAgree(std::size_t point, const std::vector<std::size_t>& rows) {
  std::vector<Ray> rays;
  for (const std::size_t row : rows) {
    bool valid = false;
    rays.push_back(system_->LocalRay(row, &valid));
    if (!valid) return false;
  }
  const auto place = IntersectRays(rays);
  if (!place) return false;
  system_->SetStart(point, *place);
  double t = 0;
  for (const std::size_t row : rows)
    t += system_->LinearisePoint(system_->rows[row]).residual.squaredNorm();
  const int redundancy = 2 * static_cast<int>(rows.size()) - 3;
  return t < kFitsAgain * ChiSquareLimit(redundancy, system_->options.significance) &&
         LargestAngle(rows) > RadFromDeg(kMinRayAngle_deg);
}

// Rejects GNSS positions and priors, but not their photos. A wrong one pulls its neighbours and the
// strip's shift: per round, only the worst of each kind and those nearly as bad are rejected.
int BlockJudgement::RejectPoses(const BlockTests& tests, double caution) {
  std::array<double, kVarianceGroups + 1> worst = {};
  const auto score_of = [&](std::size_t i) {
    const BlockRows& row = system_->rows[i];
    return row.OfPose() && row.active ? Score(tests.of_row[i]) : 0;
  };
  const auto worst_of_kind = [&](std::size_t i) -> double& {
    return worst.at(static_cast<std::size_t>(system_->rows[i].kind));
  };
  for (std::size_t i = states_.size(); i < system_->rows.size(); ++i)
    worst_of_kind(i) = std::max(worst_of_kind(i), score_of(i));
  int rejected = 0;
  for (std::size_t i = states_.size(); i < system_->rows.size(); ++i) {
    if (score_of(i) <= caution || score_of(i) < kNearlyAsBad * worst_of_kind(i)) continue;
    system_->rows[i].active = false;
    ++rejected;
  }
  return rejected;
}

// Rejects the rest of a strip's GNSS positions if others were rejected and the strip's shift and
// drift would fit the rest whatever it is: it is undecidable which were wrong.
int BlockJudgement::RejectUntested() {
  if (system_->options.gnss == GnssModel::kPlain && !system_->EstimatesCommonGnssShift()) return 0;
  const int least = system_->options.gnss == GnssModel::kShiftAndDrift ? 3 : 2;
  std::map<int, int> used, rejected;
  const auto strip_of = [&](std::size_t i) {
    const BlockRows& row = system_->rows[i];
    return row.kind == RowKind::kGnss && takes_part_[row.source] ? row.groups[1] : -1;
  };
  for (std::size_t i = states_.size(); i < system_->rows.size(); ++i)
    if (strip_of(i) >= 0) ++(system_->rows[i].active ? used : rejected)[strip_of(i)];
  int count = 0;
  for (std::size_t i = states_.size(); i < system_->rows.size(); ++i) {
    const int strip = strip_of(i);
    if (strip < 0 || !system_->rows[i].active || rejected[strip] == 0 || used[strip] >= least)
      continue;
    system_->rows[i].active = false;
    ++count;
  }
  return count;
}

int BlockJudgement::PutBackPoses(const BlockTests& tests) {
  int count = 0;
  for (std::size_t i = states_.size(); i < system_->rows.size(); ++i) {
    BlockRows& row = system_->rows[i];
    if (!row.OfPose() || row.active || !takes_part_[row.source] || pose_put_back_[i]) continue;
    if (tests.of_row[i].dof == 0 || Score(tests.of_row[i]) >= kFitsAgain) continue;
    row.active = true;
    pose_put_back_[i] = true;
    ++count;
  }
  return count;
}

BlockChanges BlockJudgement::Apply(const BlockTests& tests, double caution) {
  BlockChanges changes;
  changes.poses = RejectPoses(tests, caution);
  changes.poses += RejectUntested();
  changes.points = Reject(tests, caution);
  const bool none = changes.All() == 0;
  // While gross errors remain, the poses are too unreliable to reinstate rejected observations.
  if (changes.points == 0 || changes.points * 200 < static_cast<int>(states_.size())) {
    changes.points += PutBack(tests);
    changes.points += PutBackDissolved();
  }
  if (none) changes.poses += PutBackPoses(tests);
  Screen();
  return changes;
}

}  // namespace orient::block
