#include "core/raster/area_average.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace orient {
namespace {

// Rounding of origin + k * size must not cut a sliver off a pixel.
constexpr double kSliver = 1e-9;

// Weights of a cell that are summed at a time.
constexpr size_t kAtATime = 4;
using Few = Eigen::Array<float, kAtATime, 1>;

double Snap(double value) {
  const double nearest = std::round(value);
  return std::abs(value - nearest) < kSliver * std::max(1.0, std::abs(value)) ? nearest : value;
}

// The part [begin, end) of pixel `i` as weights of the pixel and the neighbour on the part's side.
void AddPart(int i, double begin, double end, double size, int first,
             std::vector<double>* weights) {
  const double length = end - begin;
  if (length <= 0) return;
  const double offset = (begin + end) / 2 - (i + 0.5);
  const int neighbour = offset < 0 ? i - 1 : i + 1;
  double to_neighbour = std::abs(offset) * length / size;
  const int index = neighbour - first;
  // Beyond the cell there is nothing to take: a neighbour lies inside by construction unless the
  // cell is one pixel's interior.
  if (index < 0 || index >= static_cast<int>(weights->size())) to_neighbour = 0;
  (*weights)[static_cast<size_t>(i - first)] += length / size - to_neighbour;
  if (to_neighbour > 0) (*weights)[static_cast<size_t>(index)] += to_neighbour;
}

CellWeights OneCell(double begin, double end, int source_count) {
  const int first = static_cast<int>(std::floor(begin));
  const int last = std::max(first, static_cast<int>(std::ceil(end)) - 1);
  std::vector<double> all(static_cast<size_t>(last - first + 1), 0.0);
  for (int i = first; i <= last; ++i)
    AddPart(i, std::max(begin, double(i)), std::min(end, double(i) + 1), end - begin, first, &all);
  CellWeights cell;
  cell.first = std::clamp(first, 0, source_count);
  const int stop = std::clamp(last + 1, cell.first, source_count);
  cell.weights.assign(all.begin() + (cell.first - first), all.begin() + (stop - first));
  return cell;
}

double ShareInside(const CellWeights& cell) {
  return std::accumulate(cell.weights.begin(), cell.weights.end(), 0.0);
}

}  // namespace

std::vector<CellWeights> AreaWeights(double origin, double size, int cell_count, int source_count) {
  std::vector<CellWeights> cells;
  cells.reserve(static_cast<size_t>(cell_count));
  for (int k = 0; k < cell_count; ++k) {
    const double begin = Snap(origin + k * size), end = Snap(origin + (k + 1) * size);
    if (end <= 0 || begin >= source_count)
      cells.push_back({std::clamp(static_cast<int>(std::clamp(begin, 0.0, double(source_count))), 0,
                                  source_count),
                       {}});
    else
      cells.push_back(OneCell(begin, end, source_count));
  }
  return cells;
}

AreaAverager::AreaAverager(std::vector<CellWeights> cols, std::vector<CellWeights> rows,
                           int first_col)
    : cols_(std::move(cols)),
      rows_(std::move(rows)),
      first_col_(first_col),
      width_(0),
      sum_(cols_.size() * rows_.size(), 0.0),
      share_(sum_.size(), 0.0) {
  for (const CellWeights& cell : cols_) {
    col_shares_.push_back(ShareInside(cell));
    if (!cell.weights.empty())
      width_ = std::max(width_, cell.first + static_cast<int>(cell.weights.size()) - first_col_);
    most_weights_ = std::max(most_weights_, cell.weights.size());
  }
  most_weights_ = (most_weights_ + kAtATime - 1) / kAtATime * kAtATime;
  weights_.assign(cols_.size() * most_weights_, 0.0f);
  for (size_t c = 0; c < cols_.size(); ++c)
    std::transform(cols_[c].weights.begin(), cols_[c].weights.end(),
                   weights_.begin() + static_cast<std::ptrdiff_t>(c * most_weights_),
                   [](double weight) { return static_cast<float>(weight); });
}

void AreaAverager::AddRow(int row, const float* values) {
  const Eigen::Map<const Eigen::ArrayXf> line(values, width_);
  const bool gaps = std::isnan(line.sum());
  // Zeros, as the last cells' lists of weights may reach beyond the line.
  const auto behind = static_cast<Eigen::Index>(most_weights_);
  for (; next_row_ < rows_.size() && rows_[next_row_].first <= row; ++next_row_)
    if (!rows_[next_row_].weights.empty())
      open_.push_back({next_row_, Eigen::ArrayXf::Zero(width_ + behind), {}, 0});
  for (OpenRow& open : open_) {
    const CellWeights& cell = rows_[open.row];
    Add(cell.weights[static_cast<size_t>(row - cell.first)], line, gaps, &open);
  }
  const auto complete = [&](const OpenRow& open) {
    return rows_[open.row].first + static_cast<int>(rows_[open.row].weights.size()) == row + 1;
  };
  for (const OpenRow& open : open_)
    if (complete(open)) Close(open);
  std::erase_if(open_, complete);
}

void AreaAverager::Add(double weight, const Eigen::Map<const Eigen::ArrayXf>& values, bool gaps,
                       OpenRow* open) {
  if (gaps && open->share.size() == 0)
    open->share = Eigen::ArrayXd::Constant(values.size(), open->weight);
  open->weight += weight;
  const auto part = static_cast<float>(weight);
  if (!gaps) {
    open->sum.head(values.size()) += part * values;
    if (open->share.size() > 0) open->share += weight;
    return;
  }
  for (Eigen::Index i = 0; i < values.size(); ++i) {
    if (std::isnan(values[i])) continue;
    open->sum[i] += part * values[i];
    open->share[i] += weight;
  }
}

void AreaAverager::Close(const OpenRow& open) {
  double* sum = sum_.data() + open.row * cols_.size();
  double* share = share_.data() + open.row * cols_.size();
  for (size_t c = 0; c < cols_.size(); ++c) {
    const float* value = open.sum.data() + (cols_[c].first - first_col_);
    const float* weights = weights_.data() + c * most_weights_;
    Few total = Few::Zero();
    for (size_t i = 0; i < most_weights_; i += kAtATime)
      total += Eigen::Map<const Few>(weights + i) * Eigen::Map<const Few>(value + i);
    sum[c] = static_cast<double>(total.sum());
    share[c] = open.weight * col_shares_[c];
  }
  if (open.share.size() == 0) return;
  for (size_t c = 0; c < cols_.size(); ++c) {
    const double* valid = open.share.data() + (cols_[c].first - first_col_);
    share[c] = 0;
    for (const double weight : cols_[c].weights) share[c] += weight * *valid++;
  }
}

Image AreaAverager::Result(double min_share, bool inside_only) const {
  Image result(static_cast<int>(cols_.size()), static_cast<int>(rows_.size()), kNoData);
  for (size_t r = 0; r < rows_.size(); ++r) {
    const double row_inside = inside_only ? ShareInside(rows_[r]) : 1;
    for (size_t c = 0; c < cols_.size(); ++c) {
      const size_t k = r * cols_.size() + c;
      const double full = inside_only ? row_inside * col_shares_[c] : 1;
      if (share_[k] > 0 && share_[k] >= min_share * full - kSliver)
        result.values[k] = static_cast<float>(sum_[k] / share_[k]);
    }
  }
  return result;
}

}  // namespace orient
