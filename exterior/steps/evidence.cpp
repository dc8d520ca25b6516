#include "exterior/steps/evidence.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <set>

#include "core/base/binomial.h"
#include "exterior/steps/consensus.h"

namespace orient::exterior {
namespace {

constexpr int kOfAPose = 3;   // places make a pose
constexpr double kTests = 3;  // number of bounds by which a round may prove a pose

// Area within which the k-th observation would agree even if it were a gross error: that of data
// snooping, or that of three sigma0 if it is larger.
double AgreeingArea(const PreciseRound& round, std::size_t k) {
  const double reach = 3 * std::max(round.estimate->sigma0_px, 0.2 * round.reduction);
  return std::max(std::numbers::pi * reach * reach, round.estimate->passing_px2[k]);
}

double Mean(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) /
         static_cast<double>(std::max<std::size_t>(values.size(), 1));
}

// As if each supporter had the mean of the areas. `found_by_chance`: how often a patch is found
// where it cannot be.
double FalseAlarms(const PreciseRound& round, const Evidence& evidence, double found_by_chance) {
  std::vector<double> areas_px2;
  for (std::size_t k = 0; k < round.observed.size(); ++k)
    areas_px2.push_back(AgreeingArea(round, k));
  const double in_a_square = found_by_chance * static_cast<double>(round.predictions.size()) /
                             std::max(evidence.sought, 1);
  const double p = std::min(1.0, in_a_square * Mean(areas_px2) / Mean(round.windows_px2));
  return Log10FalseAlarms(evidence.sought, evidence.agreeing, in_a_square, p);
}

// For all that was found, right or wrong: a random place in its window agrees with the probability
// given by its own area, large for a poor texture and small for a good one. The three that define
// a pose agree in any case; they are taken to be those that prove most.
double FalseAlarmsOfFound(const PreciseRound& round, const Evidence& evidence) {
  std::map<Square, double> squares;
  for (std::size_t k = 0; k < round.observed.size(); ++k) {
    const std::size_t i = round.observed[k];
    squares[SquareOf(round.predictions[i], round.reduction)] +=
        AgreeingArea(round, k) / round.windows_px2[i];
  }
  std::vector<double> chances;
  for (const auto& [place, chance] : squares) chances.push_back(std::min(chance, 1.0));
  if (std::ssize(chances) <= kOfAPose || evidence.agreeing <= kOfAPose) return 0;
  std::sort(chances.begin(), chances.end());
  const auto found = static_cast<double>(chances.size());
  const double log_poses =
      std::lgamma(found + 1) - std::lgamma(found - kOfAPose + 1) - std::lgamma(kOfAPose + 1.0);
  chances.erase(chances.begin(), chances.begin() + kOfAPose);
  return (LogTailBound(chances, evidence.agreeing - kOfAPose) + log_poses) / std::numbers::ln10;
}

}  // namespace

Evidence CountEvidence(const PreciseRound& round, const PreciseRound& last) {
  std::set<std::size_t> at_last;
  for (std::size_t k = 0; k < last.observed.size(); ++k)
    if (!last.estimate->rejected[k]) at_last.insert(last.predictions[last.observed[k]].patch);
  std::map<Square, bool> squares;
  for (const PatchPrediction& prediction : round.predictions)
    squares[SquareOf(prediction, round.reduction)];
  for (std::size_t k = 0; k < round.observed.size(); ++k) {
    const PatchPrediction& prediction = round.predictions[round.observed[k]];
    if (!round.estimate->rejected[k] && at_last.count(prediction.patch) > 0)
      squares[SquareOf(prediction, round.reduction)] = true;
  }
  Evidence evidence{static_cast<int>(squares.size()), 0};
  for (const auto& [place, agrees] : squares) evidence.agreeing += agrees ? 1 : 0;
  return evidence;
}

double LeastFalseAlarms(const PhotoTask& task, const std::vector<PreciseRound>& rounds,
                        double enough) {
  const double tried = std::log10(kTests * static_cast<double>(rounds.size()));
  // Usually the first, whose windows are the largest; the others only search again where patches
  // were found in it.
  const PreciseRound* proves_most = &rounds.front();
  double least = 0;
  for (const PreciseRound& round : rounds) {
    const Evidence evidence = CountEvidence(round, rounds.back());
    const double of_round =
        std::min(FalseAlarms(round, evidence, 1), FalseAlarmsOfFound(round, evidence));
    if (of_round >= least) continue;
    proves_most = &round;
    least = of_round;
  }
  const Evidence evidence = CountEvidence(*proves_most, rounds.back());
  if (least + tried <= enough || evidence.agreeing < kFewestAgreeing) return least + tried;
  // The rate's upper confidence bound, exceeded once in a thousand.
  const DecoyMatches decoys = MatchDecoys(task, *proves_most);
  const double rate = UpperBoundOfRate(decoys.found, decoys.sought, 0.001);
  return std::min(least, FalseAlarms(*proves_most, evidence, rate)) + tried;
}

}  // namespace orient::exterior
