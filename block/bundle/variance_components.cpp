#include "block/bundle/variance_components.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "block/bundle/outcome.h"
#include "core/base/chi_square.h"
#include "core/base/median.h"

namespace orient::block {
namespace {

// Medians of chi-square by degrees of freedom, to four digits; 1 for no degrees of freedom.
const std::array<double, 7> kMedianChi2 = [] {
  std::array<double, 7> medians = {1};
  for (int dof = 1; dof < 7; ++dof)
    medians.at(static_cast<std::size_t>(dof)) = std::round(1e4 * ChiSquareLimit(dof, 0.5)) / 1e4;
  return medians;
}();
constexpr std::size_t kLeastForMedian = 8;
// Variance factors that change less than this are left alone.
constexpr double kSettled = 0.02;
// A stated variance counts as much as one found from this many degrees of freedom: image and ground
// of control that few photos see can hardly be distinguished, and small groups would run away.
constexpr double kStatedRedundancy = 20;
constexpr double kLeastFactor = 1e-4, kMostFactor = 1e4;
// Lower bound of factors from medians, which cannot separate image and ground of control.
constexpr double kLeastControlFactor = 0.5;

void SetFactor(RowKind kind, double factor, BlockSystem* system) {
  double least = kLeastFactor;
  if (kind == RowKind::kControlImage) least = kLeastControlFactor;
  // These are few, and gross errors are not yet known: not assumed to be better than stated.
  if (kind == RowKind::kGnss || kind == RowKind::kPosePrior) least = 1;
  system->SetFactor(kind, std::clamp(factor, least, kMostFactor));
}

}  // namespace

// Before anything is known of redundancies: each ray of a tie has its share of 2 n - 3.
void FactorsFromResiduals(BlockSystem* system) {
  if (!system->options.variance_components) return;
  for (const RowKind kind : {RowKind::kTieImage, RowKind::kControlImage}) {
    std::vector<double> chi2;
    for (std::size_t i = 0; i < system->block.observations.size(); ++i) {
      const BlockRows& row = system->rows[i];
      if (!row.active || row.kind != kind) continue;
      const double share = kind == RowKind::kTieImage
                               ? 1 - 1.5 / system->Rays(static_cast<std::size_t>(row.point))
                               : 1;
      chi2.push_back(system->LinearisePoint(row).residual.squaredNorm() / share / kMedianChi2[2]);
    }
    if (chi2.size() < kLeastForMedian) continue;
    SetFactor(kind, system->Factor(kind) * UpperMedian(std::move(chi2)), system);
  }
}

// Half of the observations may be gross errors. The tests are rescaled with the factors.
bool FactorsFromMedians(BlockSystem* system, BlockTests* tests) {
  if (!system->options.variance_components) return false;
  bool changed = false;
  for (const RowKind kind :
       {RowKind::kTieImage, RowKind::kControlImage, RowKind::kGnss, RowKind::kPosePrior}) {
    std::vector<double> chi2;
    // Rejected poses count, too: the others show if they are wrong or only stated too precisely.
    for (std::size_t i = 0; i < system->rows.size(); ++i)
      if (system->rows[i].kind == kind && tests->of_row[i].dof > 0 &&
          (system->IsActive(i) || system->rows[i].OfPose()))
        chi2.push_back(tests->of_row[i].t /
                       kMedianChi2.at(static_cast<std::size_t>(tests->of_row[i].dof)));
    if (chi2.size() < kLeastForMedian) continue;
    const double before = system->Factor(kind);
    SetFactor(kind, before * UpperMedian(std::move(chi2)), system);
    const double change = system->Factor(kind) / before;
    changed = changed || std::abs(change - 1) >= kSettled;
    for (std::size_t i = 0; i < system->rows.size(); ++i) {
      if (system->rows[i].kind != kind) continue;
      tests->of_row[i].t /= change;
      tests->of_row[i].square /= change;
    }
  }
  return changed;
}

// v'Pv over the redundancy, group by group. True where a factor changed.
bool FactorsFromSums(const BlockTests& tests, BlockSystem* system) {
  if (!system->options.variance_components) return false;
  const auto sums = SumsOf(*system, tests);
  bool changed = false;
  for (std::size_t k = 0; k < kVarianceGroups; ++k) {
    if (sums.at(k).redundancy < kLeastGroupRedundancy) continue;
    const auto kind = static_cast<RowKind>(k);
    // v'Pv of the residuals, plus that of the stated variance with its own degrees of freedom.
    const double stated = kStatedRedundancy / system->Factor(kind);
    double factor = system->Factor(kind) * (sums.at(k).square + stated) /
                    (sums.at(k).redundancy + kStatedRedundancy);
    factor = std::clamp(factor, kLeastFactor, kMostFactor);
    // Approximations that happen to fit well do not become more precise by that.
    if (kind == RowKind::kPosePrior) factor = std::max(factor, 1.0);
    // Changes below a quarter of the factor's standard deviation are not worth another adjustment.
    const double noise = 0.25 * std::sqrt(2 / sums.at(k).redundancy);
    if (std::abs(factor / system->Factor(kind) - 1) < std::max(kSettled, noise)) continue;
    changed = true;
    system->SetFactor(kind, factor);
  }
  return changed;
}

StatedPrecision::StatedPrecision(BlockSystem* system) : system_(system), weight_(system->weight) {
  for (std::size_t k = 0; k < kVarianceGroups; ++k) {
    const auto kind = static_cast<RowKind>(k);
    const double least = system->PrecisionFactor(kind);
    if (system->Factor(kind) < least) system->SetFactor(kind, least);
  }
}

}  // namespace orient::block
