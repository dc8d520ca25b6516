#include "patchdb/store/learning.h"

#include <fmt/format.h>

#include <algorithm>

namespace orient::patchdb {
namespace {

constexpr double kWeakPhoto = 0.5;
constexpr double kEpochBefore = 0.25;
constexpr double kHalfLife_years = 20;
constexpr double kPriorAttempts = 2;
constexpr int kFailuresToRetire = 3;
constexpr int kMinNeighbours = 3;

bool Succeeded(const AttemptOutcome& attempt) { return attempt.state == "matched"; }
bool Failed(const AttemptOutcome& attempt) {
  return attempt.state == "not_found" || attempt.state == "rejected";
}

// The year, e.g. 1961 from 1961-07-30; empty if the text is not a date.
std::optional<double> YearOf(const std::optional<std::string>& date) {
  if (!date || date->size() < 4 ||
      !std::all_of(date->begin(), date->begin() + 4, [](char c) { return c >= '0' && c <= '9'; }))
    return std::nullopt;
  return std::stod(date->substr(0, 4));
}

double PhotoWeight(const AttemptOutcome& attempt) {
  if (attempt.photo_status == "failed") return 0;
  return attempt.photo_status == "weak" ? kWeakPhoto : 1;
}

bool NeighboursSucceeded(const AttemptOutcome& attempt) {
  return attempt.neighbours_sought && attempt.neighbours_matched &&
         *attempt.neighbours_sought >= kMinNeighbours &&
         2 * *attempt.neighbours_matched > *attempt.neighbours_sought;
}

}  // namespace

SuccessWeights WeighAttempts(const std::vector<AttemptOutcome>& attempts, int epoch) {
  std::optional<double> newest;
  for (const AttemptOutcome& attempt : attempts)
    if (const auto year = YearOf(attempt.photo_date))
      newest = std::max(newest.value_or(*year), *year);
  SuccessWeights weights;
  for (const AttemptOutcome& attempt : attempts) {
    double weight =
        PhotoWeight(attempt) *
        std::pow(kEpochBefore, std::max(0.0, static_cast<double>(epoch) - attempt.epoch));
    if (const auto year = YearOf(attempt.photo_date); year && newest)
      weight *= std::pow(0.5, (*newest - *year) / kHalfLife_years);
    if (Succeeded(attempt)) weights.success += weight;
    if (Failed(attempt)) weights.failure += weight;
  }
  return weights;
}

double SuccessBelief::Sigma() const {
  const double sum = alpha + beta;
  return std::sqrt(alpha * beta / (sum * sum * (sum + 1)));
}

SuccessBelief BeliefOf(const std::optional<double>& quality, const SuccessWeights& weights) {
  const bool known = quality && std::isfinite(*quality);
  const double mean = known ? std::clamp(*quality, 0.1, 0.9) : 0.5;
  const auto count = [](double weight) {
    return std::isfinite(weight) ? std::max(0.0, weight) : 0;
  };
  return {kPriorAttempts * mean + count(weights.success),
          kPriorAttempts * (1 - mean) + count(weights.failure)};
}

SuccessBelief BeliefOf(const Patch& patch) {
  return BeliefOf(patch.quality, {patch.success_weight, patch.failure_weight});
}

std::optional<std::string> WhyRetire(const std::vector<AttemptOutcome>& attempts, int epoch) {
  int failures = 0, successes = 0;
  for (const AttemptOutcome& attempt : attempts) {
    if (attempt.epoch != epoch || PhotoWeight(attempt) == 0) continue;
    if (Succeeded(attempt)) ++successes;
    if (Failed(attempt) && NeighboursSucceeded(attempt)) ++failures;
  }
  if (failures < kFailuresToRetire || failures < kFailuresToRetire * successes) return std::nullopt;
  std::string reason = fmt::format("failed in {} photos where its neighbours matched", failures);
  if (successes > 0) reason += ", matched in " + std::to_string(successes);
  return reason;
}

}  // namespace orient::patchdb
