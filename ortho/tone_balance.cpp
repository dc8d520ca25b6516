#include "ortho/tone_balance.h"

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "core/base/median.h"

namespace orient::ortho {
namespace {

using Cells = std::vector<Eigen::Vector2d>;  // grey values of both photos

constexpr double kLargestGain = 2.5;

struct Overlap {
  int first, second;
  CommonCells cells;
};

std::vector<Overlap> OverlapsOf(const std::vector<PhotoCells>& photos) {
  std::vector<Overlap> overlaps;
  for (std::size_t i = 0; i < photos.size(); ++i)
    for (std::size_t j = i + 1; j < photos.size(); ++j) {
      const CommonCells cells = Common(photos[i].grid, photos[j].grid);
      if (cells.in_first.width > 0)
        overlaps.push_back({static_cast<int>(i), static_cast<int>(j), cells});
    }
  return overlaps;
}

// At most `most` cells, evenly over the overlap: tones need no more.
Cells CellsOf(const std::vector<PhotoCells>& photos, const Overlap& overlap, std::size_t band,
              double most) {
  const auto& [a, b] = overlap.cells;
  const Image& first = photos[static_cast<std::size_t>(overlap.first)].bands[band];
  const Image& second = photos[static_cast<std::size_t>(overlap.second)].bands[band];
  const int step =
      std::max(1, static_cast<int>(std::ceil(std::sqrt(1.0 * a.width * a.height / most))));
  Cells cells;
  for (int row = step / 2; row < a.height; row += step)
    for (int col = step / 2; col < a.width; col += step) {
      const Eigen::Vector2d values(static_cast<double>(first.At(a.col + col, a.row + row)),
                                   static_cast<double>(second.At(b.col + col, b.row + row)));
      if (values.allFinite()) cells.push_back(values);
    }
  return cells;
}

// Mean, spread and correlation of two photos' values.
struct Moments {
  Eigen::Vector2d mean = Eigen::Vector2d::Zero(), spread = Eigen::Vector2d::Zero();
  double correlation = 0;

  // Factor from the second photo's contrast to the first's.
  double Ratio() const { return HasContrast() ? spread[0] / spread[1] : 1; }
  bool HasContrast() const {
    constexpr double kLeast = 1e-4;  // of the values
    return spread.minCoeff() > kLeast * mean.cwiseAbs().maxCoeff();
  }
  double Difference(const Eigen::Vector2d& cell) const {
    return cell[0] - mean[0] - Ratio() * (cell[1] - mean[1]);
  }
};

Moments RobustMoments(const Cells& cells) {
  Moments moments;
  for (int i = 0; i < 2; ++i) {
    std::vector<double> values;
    for (const Eigen::Vector2d& cell : cells) values.push_back(cell[i]);
    const RobustValue robust = Robust(std::move(values));
    moments.mean[i] = robust.median;
    moments.spread[i] = robust.sigma;
  }
  return moments;
}

Moments MomentsOf(const Cells& cells) {
  Moments moments;
  const auto count = static_cast<double>(cells.size());
  for (const Eigen::Vector2d& cell : cells) moments.mean += cell / count;
  Eigen::Vector2d squares = Eigen::Vector2d::Zero();
  double product = 0;
  for (const Eigen::Vector2d& cell : cells) {
    const Eigen::Vector2d off = cell - moments.mean;
    squares += off.cwiseAbs2() / count;
    product += off[0] * off[1] / count;
  }
  moments.spread = squares.cwiseSqrt();
  if (squares.minCoeff() > 0) moments.correlation = product / std::sqrt(squares.prod());
  return moments;
}

// Moments of the cells that have not changed between the two photos.
Moments MomentsOfTheUnchanged(const Cells& cells) {
  constexpr int kRounds = 8;
  constexpr double kLimit = 3;
  Moments moments = RobustMoments(cells);
  for (int round = 0; round < kRounds; ++round) {
    std::vector<double> off;
    for (const Eigen::Vector2d& cell : cells) off.push_back(std::abs(moments.Difference(cell)));
    const double limit = kLimit * kSigmaOfMedianDeviation * UpperMedian(std::move(off));
    Cells kept;
    for (const Eigen::Vector2d& cell : cells)
      if (std::abs(moments.Difference(cell)) <= limit) kept.push_back(cell);
    moments = MomentsOf(kept);
  }
  return moments;
}

// What an overlap shows about its two photos in one band.
struct Agreement {
  int first, second;
  Moments moments;
  double weight;  // of its means
};

double MedianDifference(const Cells& cells, const Tone& first, const Tone& second) {
  std::vector<double> off;
  for (const Eigen::Vector2d& cell : cells)
    off.push_back(std::abs(first.Shown(cell[0]) - second.Shown(cell[1])));
  return Median(std::move(off));
}

// `first` - `second` = `difference`, with one unknown per photo.
struct Equation {
  int first, second;
  double difference, weight;
};

// The unknowns by least squares with Huber's weights, weakly constrained to 0.
Eigen::VectorXd Adjust(const std::vector<Equation>& equations, std::size_t photos,
                       double least_sigma) {
  constexpr int kRounds = 30;
  constexpr double kHuber = 1.345, kHold = 1e-3;
  const auto size = static_cast<Eigen::Index>(photos);
  Eigen::VectorXd x = Eigen::VectorXd::Zero(size), hold = Eigen::VectorXd::Constant(size, kHold);
  for (const Equation& one : equations)
    for (const int photo : {one.first, one.second}) hold[photo] += kHold * one.weight;
  for (int round = 0; round < kRounds && !equations.empty(); ++round) {
    std::vector<double> off;
    for (const Equation& one : equations)
      off.push_back(std::abs(x[one.first] - x[one.second] - one.difference));
    const double sigma = std::max(kSigmaOfMedianDeviation * UpperMedian(off), least_sigma);
    std::vector<Eigen::Triplet<double>> entries;
    for (Eigen::Index i = 0; i < size; ++i)
      entries.emplace_back(static_cast<int>(i), static_cast<int>(i), hold[i]);
    Eigen::VectorXd right = Eigen::VectorXd::Zero(size);
    for (std::size_t i = 0; i < equations.size(); ++i) {
      const Equation& one = equations[i];
      const double weight = one.weight * std::min(1.0, kHuber * sigma / std::max(off[i], 1e-300));
      entries.emplace_back(one.first, one.first, weight);
      entries.emplace_back(one.second, one.second, weight);
      entries.emplace_back(one.first, one.second, -weight);
      entries.emplace_back(one.second, one.first, -weight);
      right[one.first] += weight * one.difference;
      right[one.second] -= weight * one.difference;
    }
    Eigen::SparseMatrix<double> normal(size, size);
    normal.setFromTriplets(entries.begin(), entries.end());
    x = Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>(normal).solve(right);
  }
  return x;
}

// Logarithms of the gains, since a gain is positive.
Eigen::VectorXd LogGains(const std::vector<Agreement>& agreements, std::size_t photos) {
  constexpr double kLeastCorrelation = 0.3;  // below, spreads are not due to the same ground
  constexpr double kLeastSigma = 0.01;
  std::vector<Equation> equations;
  for (const Agreement& one : agreements)
    if (one.moments.HasContrast() && one.moments.correlation > kLeastCorrelation)
      equations.push_back({one.first, one.second,
                           std::log(one.moments.spread[1] / one.moments.spread[0]),
                           one.weight * one.moments.correlation * one.moments.correlation});
  return Adjust(equations, photos, kLeastSigma);
}

// Mean of a photo's values in its overlaps; the gain leaves it unchanged, so that the offset shifts
// the photo's brightness.
std::vector<double> MeansOf(const std::vector<Agreement>& agreements, std::size_t photos) {
  std::vector<double> sums(photos), weights(photos);
  for (const Agreement& one : agreements)
    for (const auto& [photo, mean] :
         {std::pair{one.first, one.moments.mean[0]}, std::pair{one.second, one.moments.mean[1]}}) {
      sums[static_cast<std::size_t>(photo)] += one.weight * mean;
      weights[static_cast<std::size_t>(photo)] += one.weight;
    }
  for (std::size_t i = 0; i < photos; ++i)
    if (weights[i] > 0) sums[i] /= weights[i];
  return sums;
}

// Sets `bounded` for photos whose gain is limited.
std::vector<Tone> TonesOfBand(const std::vector<Agreement>& agreements, std::size_t photos,
                              std::vector<bool>* bounded) {
  const Eigen::VectorXd log_gains = LogGains(agreements, photos);
  const std::vector<double> means = MeansOf(agreements, photos);
  std::vector<Tone> tones(photos);
  for (std::size_t i = 0; i < photos; ++i) {
    const double free = std::exp(log_gains[static_cast<Eigen::Index>(i)]);
    tones[i].gain = std::clamp(free, 1 / kLargestGain, kLargestGain);
    if (tones[i].gain != free) (*bounded)[i] = true;
    tones[i].offset = (1 - tones[i].gain) * means[i];
  }
  std::vector<Equation> equations;
  std::vector<double> spreads;
  for (const Agreement& one : agreements) {
    const Tone &first = tones[static_cast<std::size_t>(one.first)],
               &second = tones[static_cast<std::size_t>(one.second)];
    equations.push_back({one.first, one.second,
                         second.Shown(one.moments.mean[1]) - first.Shown(one.moments.mean[0]),
                         one.weight});
    spreads.push_back(one.moments.spread.maxCoeff());
  }
  constexpr double kLeastSigma = 0.01;  // of the usual spread
  const double spread = spreads.empty() ? 1 : std::max(UpperMedian(spreads), 1e-9);
  const Eigen::VectorXd shifts = Adjust(equations, photos, kLeastSigma * spread);
  for (std::size_t i = 0; i < photos; ++i) tones[i].offset += shifts[static_cast<Eigen::Index>(i)];
  return tones;
}

// The overlaps of all photos, and the largest number of cells used in each.
struct Overlaps {
  std::vector<Overlap> all;
  double most_cells;
};

Overlaps OverlapsToLookAt(const std::vector<PhotoCells>& photos) {
  constexpr double kOfAll = 4e6, kMostOfOne = 2500, kLeastOfOne = 100;
  Overlaps overlaps{OverlapsOf(photos), kMostOfOne};
  overlaps.most_cells = std::clamp(kOfAll / (1.0 + static_cast<double>(overlaps.all.size())),
                                   kLeastOfOne, kMostOfOne);
  return overlaps;
}

// Calls visit(overlap, cells) for overlaps with enough cells.
template <typename Visit>
void ForEachOverlap(const std::vector<PhotoCells>& photos, const Overlaps& overlaps,
                    std::size_t band, const Visit& visit) {
  constexpr std::size_t kFewest = 10;
  for (const Overlap& overlap : overlaps.all)
    if (const Cells cells = CellsOf(photos, overlap, band, overlaps.most_cells);
        cells.size() >= kFewest)
      visit(overlap, cells);
}

std::vector<int> Indices(const std::vector<bool>& chosen) {
  std::vector<int> indices;
  for (std::size_t i = 0; i < chosen.size(); ++i)
    if (chosen[i]) indices.push_back(static_cast<int>(i));
  return indices;
}

double Mean(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

}  // namespace

BalancedTones BalanceTones(const std::vector<PhotoCells>& photos) {
  const Overlaps overlaps = OverlapsToLookAt(photos);
  BalancedTones result;
  result.tones.resize(photos.size());
  std::vector<bool> alone(photos.size(), true), bounded(photos.size(), false);
  std::vector<double> before, after;
  const std::size_t bands = photos.empty() ? 0 : photos.front().bands.size();
  for (std::size_t band = 0; band < bands; ++band) {
    std::vector<Agreement> agreements;
    ForEachOverlap(photos, overlaps, band, [&](const Overlap& overlap, const Cells& cells) {
      agreements.push_back({overlap.first, overlap.second, MomentsOfTheUnchanged(cells),
                            static_cast<double>(cells.size())});
      for (const int photo : {overlap.first, overlap.second})
        alone[static_cast<std::size_t>(photo)] = false;
    });
    const std::vector<Tone> tones = TonesOfBand(agreements, photos.size(), &bounded);
    for (std::size_t i = 0; i < photos.size(); ++i) result.tones[i].push_back(tones[i]);
    ForEachOverlap(photos, overlaps, band, [&](const Overlap& overlap, const Cells& cells) {
      before.push_back(MedianDifference(cells, {}, {}));
      after.push_back(MedianDifference(cells, tones[static_cast<std::size_t>(overlap.first)],
                                       tones[static_cast<std::size_t>(overlap.second)]));
    });
  }
  result.alone = Indices(alone);
  result.bounded = Indices(bounded);
  if (!before.empty()) {
    result.before = Mean(before);
    result.after = Mean(after);
  }
  result.would_worsen = result.before && *result.after > *result.before;
  if (result.would_worsen) {
    for (std::vector<Tone>& of_photo : result.tones) of_photo.assign(bands, Tone());
    result.after = result.before;
    result.bounded.clear();
  }
  return result;
}

void ShowInTones(const std::vector<std::vector<Tone>>& tones, std::vector<PhotoCells>* photos) {
  for (std::size_t i = 0; i < photos->size(); ++i)
    for (std::size_t band = 0; band < tones[i].size(); ++band)
      for (float& value : (*photos)[i].bands[band].values)
        value = static_cast<float>(tones[i][band].Shown(static_cast<double>(value)));
}

}  // namespace orient::ortho
