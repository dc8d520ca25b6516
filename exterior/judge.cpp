#include "exterior/judge.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <string>

#include "exterior/steps/evidence.h"

namespace orient::exterior {
namespace {

constexpr int kPlacesForOk = 10;       // with fewer, the pose's precision is not determined: weak
constexpr int kUsualPatches = 100;     // with fewer a search depends on each of them
constexpr double kUsualSide_px = 25;   // narrower patches are easily mistaken for one another
constexpr double kSpreadForOk = 0.03;  // share of the photo over which the matched patches spread
// Share of the target. If one source's patches lie this far to one side of the pose, the others'
// lie on the other, and it is open which the pose should follow. Correct poses reach 0.52.
constexpr double kMostOfOneSource = 0.6;

std::string TrendText(const ResidualTrend& trend) {
  const auto of_kind = [&] {
    switch (trend.kind) {
      case TrendKind::kShift:
        return "shift";
      case TrendKind::kScale:
        return "change of scale";
      case TrendKind::kRotation:
        return "rotation";
      case TrendKind::kRadial:
        return "radial distortion";
      case TrendKind::kQuadrants:
        return "shift that differs by quadrant";
    }
    return "";
  };
  return trend.source ? fmt::format("{} of the patches from source {}", of_kind(), *trend.source)
                      : fmt::format("{}", of_kind());
}

}  // namespace

double FalseAlarmLimit(bool proven_before, const OrientPhotoOptions& options) {
  return options.max_log10_false_alarms / (proven_before ? 2 : 1);
}

std::optional<Finding> WhyNotAccepted(const JudgedMatches& matches,
                                      const OrientPhotoOptions& options) {
  const auto failed = [](Reason reason, std::optional<double> value = {},
                         std::optional<double> limit = {}) {
    return Finding{reason, Status::kFailed, value, limit};
  };
  if (matches.agreeing < kFewestAgreeing)
    return failed(Reason::kTooFewAgree, matches.agreeing, kFewestAgreeing);
  if (matches.places < kFewestAgreeing)
    return failed(Reason::kPatchesOverlap, matches.places, kFewestAgreeing);
  if (matches.log10_false_alarms > FalseAlarmLimit(matches.proven_before, options))
    return failed(Reason::kAgreementMayBeChance, matches.agreeing, matches.sought);
  if (2 * matches.agreeing < matches.matched)
    return failed(Reason::kMostContradict, matches.agreeing, matches.matched);
  return std::nullopt;
}

std::optional<ProjectionSigma> ProjectionSigmaOf(double worst_sigma_px, double ground_pixel_m) {
  if (!std::isfinite(worst_sigma_px)) return std::nullopt;
  return ProjectionSigma{worst_sigma_px, worst_sigma_px * ground_pixel_m};
}

Findings JudgeSources(const SourceVotes& votes) {
  Findings findings;
  const Status by_sources = IsUndecided(votes) ? Status::kWeak : Status::kOk;
  for (const ContradictedSource& source : votes.contradicted)
    findings.push_back({.reason = Reason::kSourceContradicted,
                        .at_best = by_sources,
                        .value = source.shift_px.norm(),
                        .limit = source.found - source.used,
                        .where = std::to_string(source.source)});
  if (votes.elsewhere.patches > 0)
    findings.push_back(
        {.reason = Reason::kPatchesAgreeElsewhere,
         .at_best = IsUndecided(votes.elsewhere, votes.used) ? Status::kWeak : Status::kOk,
         .value = votes.elsewhere.shift_px.norm(),
         .limit = votes.elsewhere.patches,
         .where = fmt::format("{:+.1f} columns, {:+.1f} rows", votes.elsewhere.shift_px.x(),
                              votes.elsewhere.shift_px.y())});
  return findings;
}

void RejudgeSources(ExteriorResult* result) {
  if (std::none_of(result->patches.begin(), result->patches.end(),
                   [](const PatchResult& patch) { return patch.source.has_value(); }))
    return;  // a result of an earlier version
  const auto of_sources = [](const Finding& finding) {
    return finding.reason == Reason::kSourceContradicted ||
           finding.reason == Reason::kPatchesAgreeElsewhere;
  };
  const int reduction = result->iterations.empty() ? 1 : result->iterations.back().reduction;
  if (std::erase_if(result->findings, of_sources) > 0) result->status = StatusOf(result->findings);
  for (const Finding& finding : JudgeSources(VotesOf(result->patches, reduction)))
    Add(finding, result);
}

Findings Judge(const JudgedPose& pose) {
  Findings findings;
  const auto weak = [&](Reason reason, double value, double limit) {
    findings.push_back({reason, Status::kWeak, value, limit});
  };
  if (pose.contradicts_prior)
    findings.push_back({.reason = Reason::kContradictsApproximation,
                        .at_best = pose.prior_counts ? Status::kWeak : Status::kOk,
                        .value = pose.prior_sigmas,
                        .where = "the patches' coordinates are"});
  if (pose.places < kPlacesForOk) weak(Reason::kFewPlaces, pose.places, kPlacesForOk);
  if (pose.spread < kSpreadForOk) weak(Reason::kPoorSpread, 100 * pose.spread, 100 * kSpreadForOk);
  if (!(pose.worst_sigma_px <= pose.target_px))
    weak(Reason::kPoorlyDetermined, pose.worst_sigma_px, pose.target_px);
  for (const Finding& finding : JudgeSources(pose.sources)) findings.push_back(finding);
  // Only the largest trend of all residuals and of each source's: others reflect the same errors.
  std::set<std::optional<std::int64_t>> told;
  for (const ResidualTrend& trend : pose.trends) {
    if (!told.insert(trend.source).second) continue;
    const double most_px = (trend.source ? kMostOfOneSource : 1) * pose.target_px;
    findings.push_back({.reason = Reason::kResidualTrend,
                        .at_best = trend.rms_px > most_px ? Status::kWeak : Status::kOk,
                        .value = trend.rms_px,
                        .where = TrendText(trend)});
  }
  return findings;
}

Findings Remedies(const TriedPatches& tried) {
  Findings findings;
  if (tried.visible < kUsualPatches)
    findings.push_back(
        {.reason = Reason::kHarvestMoreDensely, .value = tried.visible, .limit = kUsualPatches});
  if (tried.side_px && *tried.side_px < kUsualSide_px)
    findings.push_back(
        {.reason = Reason::kHarvestLargerChips, .value = *tried.side_px, .limit = kUsualSide_px});
  return findings;
}

bool ConcernsPrecision(const Finding& finding) {
  return finding.reason == Reason::kPoorlyDetermined || finding.reason == Reason::kFewPlaces;
}

Finding NoPatches(const std::string& where) {
  return {.reason = Reason::kNoPatches, .at_best = Status::kFailed, .where = where};
}

namespace {

std::string AsFarAsSearched(bool complete) {
  return complete ? "" : "; not all of them could be tried at reasonable cost";
}

}  // namespace

Finding NothingAlike(bool complete) {
  return {.reason = Reason::kNothingAlike,
          .at_best = Status::kFailed,
          .where = AsFarAsSearched(complete)};
}

Finding NotSearchedAsAWhole() { return {Reason::kNotSearchedAsAWhole, Status::kFailed}; }

Finding NoConsensus(const LoopRound& round, bool wide, bool complete) {
  if (wide)
    return {Reason::kNothingAlike, Status::kFailed, round.matched, round.searched,
            fmt::format("{}: at best {} of {} places agree, chance could produce that",
                        AsFarAsSearched(complete), round.matched, round.searched)};
  return {Reason::kNoConsensus, Status::kFailed, round.matched, round.searched,
          fmt::format("{:.0f} px", round.window_px)};
}

Finding NoPreciseResection(int matched, int sought) {
  if (matched < kFewestAgreeing)
    return {Reason::kTooFewPreciseMatches, Status::kFailed, matched, kFewestAgreeing};
  return {Reason::kMatchesAgreeOnNoPose, Status::kFailed, matched, sought};
}

void Add(const Finding& finding, ExteriorResult* result) {
  result->status = std::max(result->status, finding.at_best);
  result->findings.push_back(finding);
}

}  // namespace orient::exterior
