// Local maxima of correlation scores.
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/matching/correlation.h"

namespace orient {
namespace {

struct Cell {
  int col = 0, row = 0;
};

constexpr std::array<Cell, 8> kNeighbours = {
    {{-1, -1}, {0, -1}, {1, -1}, {-1, 0}, {1, 0}, {-1, 1}, {0, 1}, {1, 1}}};

bool Inside(const Image& image, const Cell& cell) {
  return cell.col >= 0 && cell.row >= 0 && cell.col < image.width && cell.row < image.height;
}

// The connected cells of the same score; empty where one of them has a higher neighbour.
std::vector<Cell> Plateau(const Image& scores, const Cell& seed, std::vector<bool>* seen) {
  const float level = scores.At(seed.col, seed.row);
  const auto index = [&scores](const Cell& cell) {
    return static_cast<size_t>(cell.row) * static_cast<size_t>(scores.width) +
           static_cast<size_t>(cell.col);
  };
  std::vector<Cell> cells = {seed};
  (*seen)[index(seed)] = true;
  bool is_top = true;
  for (size_t k = 0; k < cells.size(); ++k) {
    for (const Cell& step : kNeighbours) {
      const Cell next{cells[k].col + step.col, cells[k].row + step.row};
      if (!Inside(scores, next)) continue;
      const float score = scores.At(next.col, next.row);
      is_top = is_top && !(score > level);
      if (score != level || (*seen)[index(next)]) continue;
      (*seen)[index(next)] = true;
      cells.push_back(next);
    }
  }
  return is_top ? cells : std::vector<Cell>{};
}

// Vertex of the parabola through three equidistant scores, relative to the middle one.
double Vertex(float before, float middle, float after) {
  const double bend = double(before) - 2 * double(middle) + double(after);
  if (!(bend < 0)) return 0;  // NaN on one side, or no maximum in this direction
  return std::clamp(0.5 * (double(before) - double(after)) / bend, -0.5, 0.5);
}

Eigen::Vector2d Refined(const Image& scores, const std::vector<Cell>& cells) {
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();
  for (const Cell& cell : cells) centre += Eigen::Vector2d(cell.col, cell.row);
  centre /= static_cast<double>(cells.size());
  if (cells.size() > 1) return centre;
  const auto [c, r] = std::pair(cells[0].col, cells[0].row);
  const float top = scores.At(c, r);
  if (c > 0 && c + 1 < scores.width)
    centre.x() += Vertex(scores.At(c - 1, r), top, scores.At(c + 1, r));
  if (r > 0 && r + 1 < scores.height)
    centre.y() += Vertex(scores.At(c, r - 1), top, scores.At(c, r + 1));
  return centre;
}

std::vector<Peak> AllPeaks(const Image& scores, double min_score) {
  std::vector<Peak> peaks;
  std::vector<bool> seen(scores.values.size(), false);
  for (int r = 0; r < scores.height; ++r) {
    for (int c = 0; c < scores.width; ++c) {
      const size_t index =
          static_cast<size_t>(r) * static_cast<size_t>(scores.width) + static_cast<size_t>(c);
      const double score = double(scores.At(c, r));
      if (!(score >= min_score) || seen[index]) continue;
      const std::vector<Cell> cells = Plateau(scores, {c, r}, &seen);
      if (!cells.empty()) peaks.push_back({Refined(scores, cells), score});
    }
  }
  return peaks;
}

}  // namespace

std::vector<Peak> FindPeaks(const Image& scores, int max_count, double min_distance,
                            double min_score) {
  std::vector<Peak> all = AllPeaks(scores, min_score);
  std::stable_sort(all.begin(), all.end(),
                   [](const Peak& a, const Peak& b) { return a.score > b.score; });
  std::vector<Peak> peaks;
  for (const Peak& candidate : all) {
    if (static_cast<int>(peaks.size()) >= max_count) break;
    const bool apart = std::all_of(peaks.begin(), peaks.end(), [&](const Peak& better) {
      return (better.position - candidate.position).norm() >= min_distance;
    });
    if (apart) peaks.push_back(candidate);
  }
  return peaks;
}

}  // namespace orient
