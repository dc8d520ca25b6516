#include "ortho/tone_balance.h"

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>

#include "core/base/median.h"

namespace orient::ortho {
namespace {

// A cell as two photos show it.
struct Shared {
  int first, second;
  double of_first, of_second;
};

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

// Evenly over each overlap; tones need no more than a few thousand cells of it, and fewer where
// there are many overlaps.
std::vector<Shared> SharedCells(const std::vector<PhotoCells>& photos,
                                const std::vector<Overlap>& overlaps, std::size_t band) {
  constexpr double kOfAll = 4e6, kMostOfOne = 2500, kLeastOfOne = 100;
  const double most =
      std::clamp(kOfAll / (1.0 + static_cast<double>(overlaps.size())), kLeastOfOne, kMostOfOne);
  std::vector<Shared> shared;
  for (const Overlap& overlap : overlaps) {
    const auto& [a, b] = overlap.cells;
    const Image& first = photos[static_cast<std::size_t>(overlap.first)].bands[band];
    const Image& second = photos[static_cast<std::size_t>(overlap.second)].bands[band];
    const int step =
        std::max(1, static_cast<int>(std::ceil(std::sqrt(1.0 * a.width * a.height / most))));
    for (int row = step / 2; row < a.height; row += step)
      for (int col = step / 2; col < a.width; col += step) {
        const double of_first = static_cast<double>(first.At(a.col + col, a.row + row));
        const double of_second = static_cast<double>(second.At(b.col + col, b.row + row));
        if (!std::isnan(of_first + of_second))
          shared.push_back({overlap.first, overlap.second, of_first, of_second});
      }
  }
  return shared;
}

// Mean and spread of the values of both photos in each cell, as they are.
struct Moments {
  double mean = 0, spread = 0;

  static Moments Of(const std::vector<Shared>& shared) {
    Moments all;
    double squares = 0;
    const double count = 2.0 * static_cast<double>(shared.size());
    for (const Shared& cell : shared) all.mean += (cell.of_first + cell.of_second) / count;
    for (const Shared& cell : shared)
      for (const double value : {cell.of_first, cell.of_second})
        squares += (value - all.mean) * (value - all.mean);
    all.spread = std::sqrt(squares / std::max(count, 1.0));
    return all;
  }
};

double Difference(const Shared& cell, const std::vector<Tone>& tones) {
  const Tone &a = tones[static_cast<std::size_t>(cell.first)],
             &b = tones[static_cast<std::size_t>(cell.second)];
  return a.gain * cell.of_first + a.offset - b.gain * cell.of_second - b.offset;
}

std::vector<double> Differences(const std::vector<Shared>& shared, const std::vector<Tone>& tones) {
  std::vector<double> all;
  for (const Shared& cell : shared) all.push_back(std::abs(Difference(cell, tones)));
  return all;
}

// The normal equations of gains and offsets, two unknowns a photo.
class ToneEquations {
 public:
  explicit ToneEquations(std::size_t photos)
      : size_(2 * static_cast<int>(photos)), right_(Eigen::VectorXd::Zero(size_)) {}

  // The two values are equal, with this weight. Cells of one pair come one after the other.
  void Add(const Shared& cell, double weight) {
    if (cell.first != first_ || cell.second != second_) EndPair();
    first_ = cell.first;
    second_ = cell.second;
    const Eigen::Vector4d factors(cell.of_first, 1, -cell.of_second, -1);
    of_pair_ += weight * factors * factors.transpose();
  }

  // The photo keeps its own gain and offset, with these weights.
  void Hold(int photo, double of_gain, double of_offset) {
    entries_.emplace_back(2 * photo, 2 * photo, of_gain);
    entries_.emplace_back(2 * photo + 1, 2 * photo + 1, of_offset);
    right_[2 * photo] += of_gain;
  }

  std::vector<Tone> Solve() {
    EndPair();
    Eigen::SparseMatrix<double> normal(size_, size_);
    normal.setFromTriplets(entries_.begin(), entries_.end());
    const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver(normal);
    const Eigen::VectorXd x = solver.solve(right_);
    std::vector<Tone> tones;
    for (int i = 0; i < size_; i += 2) tones.push_back({x[i], x[i + 1]});
    return tones;
  }

 private:
  void EndPair() {
    const int unknowns[] = {2 * first_, 2 * first_ + 1, 2 * second_, 2 * second_ + 1};
    for (int i = 0; i < 4 && first_ >= 0; ++i)
      for (int j = 0; j < 4; ++j) entries_.emplace_back(unknowns[i], unknowns[j], of_pair_(i, j));
    of_pair_.setZero();
  }

  int size_;
  int first_ = -1, second_ = -1;
  Eigen::Matrix4d of_pair_ = Eigen::Matrix4d::Zero();
  std::vector<Eigen::Triplet<double>> entries_;
  Eigen::VectorXd right_;
};

// Equal values want small gains: the mean gain is 1 again, as is the tones' mean offset 0, both of
// values about their mean.
void KeepTheWhole(std::vector<Tone>* tones) {
  double gain = 0, offset = 0;
  for (const Tone& tone : *tones) gain += tone.gain, offset += tone.offset;
  const auto count = static_cast<double>(tones->size());
  for (Tone& tone : *tones) {
    tone.offset = (tone.offset - offset / count) * count / gain;
    tone.gain *= count / gain;
  }
}

// The tones of cells in units of their spread about their mean.
std::vector<Tone> AdjustTones(const std::vector<Shared>& shared, std::size_t photos) {
  constexpr int kRoundsOfOffsets = 3, kRounds = 15;
  constexpr double kTukey = 4.685, kLeastSigma = 1e-6;
  constexpr double kHold = 0.01, kHoldFirmly = 1e6;  // of a photo's weight in its overlaps
  std::vector<Tone> tones(photos);
  for (int round = 0; round < kRounds; ++round) {
    const double sigma = std::max(1.4826 * UpperMedian(Differences(shared, tones)), kLeastSigma);
    ToneEquations equations(photos);
    std::vector<double> weights(photos, 1);
    for (const Shared& cell : shared) {
      const double off = Difference(cell, tones) / (kTukey * sigma);
      if (std::abs(off) >= 1) continue;
      const double weight = (1 - off * off) * (1 - off * off);
      equations.Add(cell, weight);
      weights[static_cast<std::size_t>(cell.first)] += weight;
      weights[static_cast<std::size_t>(cell.second)] += weight;
    }
    for (std::size_t i = 0; i < photos; ++i)
      equations.Hold(static_cast<int>(i),
                     (round < kRoundsOfOffsets ? kHoldFirmly : kHold) * weights[i],
                     kHold * weights[i]);
    tones = equations.Solve();
    KeepTheWhole(&tones);
  }
  return tones;
}

std::vector<Tone> TonesOfBand(const std::vector<Shared>& shared, std::size_t photos) {
  const Moments own = Moments::Of(shared);
  if (own.spread == 0) return std::vector<Tone>(photos);
  std::vector<Shared> scaled = shared;
  for (Shared& cell : scaled)
    for (double* value : {&cell.of_first, &cell.of_second})
      *value = (*value - own.mean) / own.spread;
  std::vector<Tone> tones = AdjustTones(scaled, photos);
  for (Tone& tone : tones) tone.offset = own.mean + own.spread * tone.offset - tone.gain * own.mean;
  return tones;
}

}  // namespace

BalancedTones BalanceTones(const std::vector<PhotoCells>& photos) {
  BalancedTones result;
  result.tones.resize(photos.size());
  const std::size_t bands = photos.empty() ? 0 : photos.front().bands.size();
  const std::vector<Overlap> overlaps = OverlapsOf(photos);
  std::vector<double> before, after;
  for (std::size_t band = 0; band < bands; ++band) {
    const std::vector<Shared> shared = SharedCells(photos, overlaps, band);
    const std::vector<Tone> tones = TonesOfBand(shared, photos.size());
    for (std::size_t i = 0; i < photos.size(); ++i) result.tones[i].push_back(tones[i]);
    for (double one : Differences(shared, std::vector<Tone>(photos.size()))) before.push_back(one);
    for (double one : Differences(shared, tones)) after.push_back(one);
  }
  if (before.empty()) return result;
  result.before = Median(before);
  result.after = Median(after);
  return result;
}

}  // namespace orient::ortho
