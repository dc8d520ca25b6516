#include "block/verdict/judge.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "block/stages/adjustment_stage.h"
#include "core/base/chi_square.h"
#include "exterior/judge.h"
#include "exterior/search/point_resection.h"

namespace orient::block {

namespace {

// Control besides a photo's own measured points, so that its ties show whether these are wrong.
constexpr int kLeastControl = 2 * exterior::kLeastPointsAlone;
// Times the target: a pose by ties that are less precise does not count as a pose.
constexpr double kMostTargets = 3;
const double kMaxAloneChi2 = ChiSquareLimit(6, 1e-4);
// Share of a photo's own patches that misfit the block: up to 11 % in right photos, 22 to 43 %
// where a scan is cropped or the DEM has a step.
constexpr double kMostMisfitting = 0.2;
constexpr int kFewestMisfitting = 12;

bool OwnPatchesContradict(const OwnPatches& own) {
  return own.misfitting >= kFewestMisfitting &&
         own.misfitting >= kMostMisfitting * (own.used + own.rejected);
}

}  // namespace

bool IsByFewPoints(const Finding& finding) {
  return finding.reason == Reason::kByPointsAlone && finding.at_best != Status::kOk;
}

bool TiesContradict(const TiedPhoto& photo) {
  return photo.comparable >= kLeastTies && 2 * photo.ties_used < photo.comparable;
}

Finding TiesContradictFinding(Status at_best) { return {Reason::kTiesContradict, at_best}; }

Findings JudgeTied(const TiedPhoto& photo) {
  if (photo.ties_used < kLeastTies)
    return {{Reason::kFewTies, Status::kFailed, photo.ties_used, kLeastTies}};
  if (TiesContradict(photo)) return {TiesContradictFinding(Status::kFailed)};
  if (photo.tie_redundancy < kLeastTieRedundancy)
    return {
        {Reason::kTiesUncontrolled, Status::kFailed, photo.tie_redundancy, kLeastTieRedundancy}};
  if (photo.worst_sigma_px <= photo.target_px) return {};
  const bool useful = photo.worst_sigma_px <= kMostTargets * photo.target_px;
  return {{Reason::kTiesImprecise, useful ? Status::kWeak : Status::kFailed, photo.worst_sigma_px,
           photo.target_px}};
}

Findings JudgeAgainstOwnPatches(const TiedPhoto& photo) {
  Findings findings;
  if (!(photo.worst_sigma_px <= photo.target_px))
    findings.push_back(
        {Reason::kPoorlyDetermined, Status::kWeak, photo.worst_sigma_px, photo.target_px});
  if (TiesContradict(photo)) findings.push_back(TiesContradictFinding(Status::kWeak));
  // If the photo is held off its own patches, worst_sigma_px includes the move: then only a remark,
  // unless these lie off by more than the target.
  const bool moved = photo.moved_chi2 > kMaxAloneChi2, held_off = IsHeldOff(photo.own);
  if (moved || held_off)
    findings.push_back({Reason::kMovedByBlock,
                        moved || photo.own.rms_px > photo.target_px ? Status::kWeak : Status::kOk,
                        std::sqrt(photo.moved_chi2), std::sqrt(kMaxAloneChi2)});
  const int all = photo.own.used + photo.own.rejected;
  if (OwnPatchesContradict(photo.own))
    findings.push_back(
        {.reason = Reason::kPatchContradictsBlock,
         .at_best = Status::kWeak,
         .value = photo.own.misfitting,
         .limit = all,
         .where = fmt::format(": {} of the {} patches that the photo was oriented by do not fit it",
                              photo.own.misfitting, all)});
  return findings;
}

void RejudgePrecision(const TiedPhoto& photo, ExteriorResult* result) {
  if (!(photo.worst_sigma_px <= photo.target_px))
    std::erase_if(result->findings, [](const Finding& finding) {
      return finding.reason == Reason::kPoorlyDetermined;
    });
  if (result->status == Status::kFailed || photo.ties_used < kLeastTies ||
      photo.tie_redundancy < kLeastTieRedundancy)
    return;
  for (Finding& finding : result->findings)
    if (IsByFewPoints(finding) && photo.control_elsewhere < kLeastControl)
      finding = {Reason::kLittleOtherControl, Status::kWeak,
                 static_cast<double>(photo.control_elsewhere), kLeastControl};
  // Ties say nothing about the other findings.
  if (std::erase_if(result->findings, [](const Finding& finding) {
        return exterior::ConcernsPrecision(finding) || finding.reason == Reason::kByPointsAlone;
      }) > 0)
    result->status = StatusOf(result->findings);
}

void HoldTo(const ExteriorResult& held, ExteriorResult* adjusted) {
  const std::string why = JoinedSentences(held.findings);
  if (held.status == Status::kFailed) {
    const bool failed_anyway = adjusted->status == Status::kFailed;
    *adjusted = held;
    if (!failed_anyway)
      adjusted->findings.insert(adjusted->findings.begin(),
                                {Reason::kFailedWithoutPriors, Status::kFailed});
  } else if (held.status == Status::kWeak && adjusted->status == Status::kOk) {
    exterior::Add({.reason = Reason::kWeakWithoutPriors,
                   .at_best = Status::kWeak,
                   .where = why.empty() ? "" : ": " + why},
                  adjusted);
  }
}

}  // namespace orient::block
