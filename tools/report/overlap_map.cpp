#include "tools/report/overlap_map.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "tools/report/html_text.h"
#include "tools/report/svg_shapes.h"

namespace orient {
namespace {

using Eigen::Vector2d;
using Outline = std::vector<Vector2d>;

constexpr int kLongestSide = 150;  // cells
constexpr int kCell = 4;           // side of a cell in the SVG
constexpr int kMostCounted = 6;    // so many photos, or more

std::vector<Outline> Footprints(const BlockRecord& block, const BlockVerdict& verdict) {
  std::vector<Outline> outlines;
  for (size_t i = 0; i < block.photos.size(); ++i) {
    const auto& exterior = block.photos[i].exterior;
    if (!exterior || verdict.photos[i].status == Status::kFailed) continue;
    if (exterior->footprint_m.size() < 3) continue;
    Outline& outline = outlines.emplace_back();
    for (const Eigen::Vector3d& corner : exterior->footprint_m) outline.push_back(corner.head<2>());
  }
  return outlines;
}

// Cells on the ground, rows from the north, and how many photos show each one's middle.
class Counts {
 public:
  explicit Counts(const std::vector<Outline>& outlines) {
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

  int Width() const { return width_; }
  int Height() const { return height_; }
  double Cell_m() const { return cell_m_; }
  int At(int col, int row) const {
    return std::min(
        counts_[static_cast<size_t>(row) * static_cast<size_t>(width_) + static_cast<size_t>(col)],
        kMostCounted);
  }

 private:
  // Between the outline's first and second, third and fourth ... crossing of the row's middle.
  void AddRow(const Outline& outline, int row) {
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
        ++counts_[static_cast<size_t>(row) * static_cast<size_t>(width_) +
                  static_cast<size_t>(col)];
    }
  }

  double cell_m_ = 1;
  Vector2d north_west_;
  int width_ = 0, height_ = 0;
  std::vector<int> counts_;
};

// Runs of cells of one count, a path for each count.
std::string Shapes(const Counts& counts) {
  std::array<std::string, kMostCounted + 1> paths;
  for (int row = 0; row < counts.Height(); ++row)
    for (int col = 0; col < counts.Width();) {
      const int count = counts.At(col, row), first = col;
      while (col < counts.Width() && counts.At(col, row) == count) ++col;
      if (count > 0)
        paths[static_cast<size_t>(count)] +=
            fmt::format("M{} {}h{}v{}h-{}z", first * kCell, row * kCell, (col - first) * kCell,
                        kCell, (col - first) * kCell);
    }
  std::string svg;
  for (size_t count = 1; count < paths.size(); ++count)
    if (!paths[count].empty())
      svg += fmt::format("<path class=\"seen-{}\" d=\"{}\"/>\n", count, paths[count]);
  return svg;
}

Markup Keys(const Counts& counts) {
  std::array<int, kMostCounted + 1> cells{};
  for (int row = 0; row < counts.Height(); ++row)
    for (int col = 0; col < counts.Width(); ++col)
      ++cells[static_cast<size_t>(counts.At(col, row))];
  const int covered = counts.Width() * counts.Height() - cells[0];
  Markup keys;
  for (size_t count = 1; count < cells.size(); ++count) {
    if (cells[count] == 0) continue;
    const bool more = count == kMostCounted;
    keys += Fill("overlap.html#key",
                 {{"count", count},
                  {"photos", fmt::format("{}{} {}", count, more ? " or more" : "",
                                         count == 1 ? "photo" : "photos")},
                  {"share", Decimal(100.0 * cells[count] / std::max(covered, 1), 0)}});
  }
  return keys;
}

}  // namespace

Markup OverlapMap(const BlockRecord& block, const BlockVerdict& verdict) {
  const std::vector<Outline> outlines = Footprints(block, verdict);
  if (outlines.size() < 2) return {};
  const Counts counts(outlines);
  const double cell_m = counts.Cell_m();
  return Fill("overlap.html", {{"width", counts.Width() * kCell},
                               {"height", counts.Height() * kCell},
                               {"shapes", Markup(Shapes(counts))},
                               {"keys", Keys(counts)},
                               {"cell", Decimal(cell_m, cell_m < 10 ? 1 : 0)}});
}

}  // namespace orient
