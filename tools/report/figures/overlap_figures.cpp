#include "tools/report/figures/overlap_figures.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstddef>

namespace orient {
namespace {

using Eigen::Vector2d;
using std::size_t;

constexpr int kLongestSide = 150;  // cells

}  // namespace

OverlapCounts::OverlapCounts(const std::vector<Outline>& outlines) {
  Eigen::AlignedBox2d box;
  for (const Outline& outline : outlines)
    for (const Vector2d& corner : outline) box.extend(corner);
  cell_m_ = std::max(box.sizes().maxCoeff() / kLongestSide, 1e-3);
  north_west_ = {box.min().x(), box.max().y()};
  width_ = std::max(1, static_cast<int>(std::ceil(box.sizes().x() / cell_m_)));
  height_ = std::max(1, static_cast<int>(std::ceil(box.sizes().y() / cell_m_)));
  counts_.assign(static_cast<size_t>(width_) * static_cast<size_t>(height_), 0);
  for (const Outline& outline : outlines)
    for (int row = 0; row < height_; ++row) AddRow(outline, row);
}

int OverlapCounts::At(int col, int row) const {
  return std::min(
      counts_[static_cast<size_t>(row) * static_cast<size_t>(width_) + static_cast<size_t>(col)],
      kMostCounted);
}

double OverlapCounts::Share(int count) const {
  int covered = 0, of_count = 0;
  for (const int cell : counts_) {
    covered += cell > 0;
    of_count += cell > 0 && std::min(cell, kMostCounted) == count;
  }
  return static_cast<double>(of_count) / std::max(covered, 1);
}

// Between the outline's first and second, third and fourth ... crossing of the row's middle.
void OverlapCounts::AddRow(const Outline& outline, int row) {
  const double y = north_west_.y() - (row + 0.5) * cell_m_;
  std::vector<double> crossings;
  for (size_t i = 0; i < outline.size(); ++i) {
    const Vector2d &from = outline[i], &to = outline[(i + 1) % outline.size()];
    if ((from.y() > y) == (to.y() > y)) continue;
    const double x = from.x() + (to.x() - from.x()) * (y - from.y()) / (to.y() - from.y());
    crossings.push_back((x - north_west_.x()) / cell_m_ - 0.5);
  }
  std::sort(crossings.begin(), crossings.end());
  for (size_t i = 0; i + 1 < crossings.size(); i += 2) {
    const int first = std::max(0, static_cast<int>(std::ceil(crossings[i])));
    const int last = std::min(width_ - 1, static_cast<int>(std::floor(crossings[i + 1])));
    for (int col = first; col <= last; ++col)
      ++counts_[static_cast<size_t>(row) * static_cast<size_t>(width_) + static_cast<size_t>(col)];
  }
}

}  // namespace orient
