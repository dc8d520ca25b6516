#include "exterior/steps/evidence.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include "core/base/binomial.h"
#include "exterior/steps/consensus.h"

namespace orient::exterior {
namespace {

// Each supporter had what area gross errors pass in, or that of three sigma where residuals say
// that it ought to be larger. `found_by_chance`: how often a patch is found where it cannot be.
double FalseAlarms(const PreciseRound& round, const Evidence& evidence, double found_by_chance) {
  const double reach = 3 * std::max(round.estimate->sigma0_px, 0.2);
  const double area = std::max(std::numbers::pi * reach * reach, round.estimate->passing_px2);
  const double in_a_square = found_by_chance * static_cast<double>(round.predictions.size()) /
                             std::max(evidence.sought, 1);
  const double p = std::min(1.0, in_a_square * area / round.mean_window_px2);
  return Log10FalseAlarms(evidence.sought, evidence.agreeing, in_a_square, p);
}

}  // namespace

Evidence CountEvidence(const PreciseRound& round, const PreciseRound& last) {
  std::set<std::size_t> at_last;
  for (std::size_t k = 0; k < last.observed.size(); ++k)
    if (!last.estimate->rejected[k]) at_last.insert(last.predictions[last.observed[k]].patch);
  std::map<Square, bool> squares;
  for (const PatchPrediction& prediction : round.predictions) squares[SquareOf(prediction)];
  for (std::size_t k = 0; k < round.observed.size(); ++k) {
    const PatchPrediction& prediction = round.predictions[round.observed[k]];
    if (!round.estimate->rejected[k] && at_last.count(prediction.patch) > 0)
      squares[SquareOf(prediction)] = true;
  }
  Evidence evidence{static_cast<int>(squares.size()), 0};
  for (const auto& [place, agrees] : squares) evidence.agreeing += agrees ? 1 : 0;
  return evidence;
}

double LeastFalseAlarms(const PhotoTask& task, const std::vector<PreciseRound>& rounds,
                        double enough) {
  const double tried = std::log10(static_cast<double>(rounds.size()));
  // Usually the first, whose windows are the largest: where patches were found there the others
  // only look again.
  const PreciseRound* proves_most = &rounds.front();
  double least = 0;
  for (const PreciseRound& round : rounds) {
    const double of_round = FalseAlarms(round, CountEvidence(round, rounds.back()), 1);
    if (of_round >= least) continue;
    proves_most = &round;
    least = of_round;
  }
  const Evidence evidence = CountEvidence(*proves_most, rounds.back());
  if (least + tried <= enough || evidence.agreeing < kFewestAgreeing) return least + tried;
  // So high that it is exceeded once in a thousand.
  const DecoyMatches decoys = MatchDecoys(task, *proves_most);
  const double rate = UpperBoundOfRate(decoys.found, decoys.sought, 0.001);
  return FalseAlarms(*proves_most, evidence, rate) + tried;
}

}  // namespace orient::exterior
