#include "core/terrain/dem_grid.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <tuple>
#include <utility>

namespace orient {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Shortens [begin, end] to the t with 0 <= origin + t * speed <= size; false where none is left.
bool ClipTo(double origin, double speed, double size, double* begin, double* end) {
  if (speed == 0) return origin >= 0 && origin <= size;
  const double a = -origin / speed, b = (size - origin) / speed;
  *begin = std::max(*begin, std::min(a, b));
  *end = std::min(*end, std::max(a, b));
  return *begin <= *end;
}

// Smallest s in [0, length] with f0 + f1 s + f2 s^2 <= 0, where f0 > 0.
std::optional<double> FirstRoot(double f0, double f1, double f2, double length) {
  const double at_end = f0 + length * (f1 + length * f2);
  if (f2 <= 0 && at_end > 0) return std::nullopt;  // concave: lowest at its ends
  const double discriminant = f1 * f1 - 4 * f2 * f0;
  double first = kInfinity;
  if (discriminant >= 0) {
    const double q = -0.5 * (f1 + std::copysign(std::sqrt(discriminant), f1));
    for (const double root : {q / f2, f0 / q})
      if (root >= 0 && root < first) first = root;  // false for NaN (f2 = 0, q = 0)
  }
  if (first <= length) return first;
  if (at_end <= 0) return length;  // the root lies on the cell's border, but for rounding
  return std::nullopt;
}

// Extremes and mean of the known heights.
class Extremes {
 public:
  void Add(const std::vector<float>& heights) {
    for (const float height : heights) {
      if (!std::isfinite(height)) continue;
      low_ = std::min<double>(low_, height);
      high_ = std::max<double>(high_, height);
      sum_ += height;
      ++count_;
    }
  }
  // NaN where none is known.
  std::tuple<double, double, double> LowHighMean() const {
    const double none = std::numeric_limits<double>::quiet_NaN();
    return {count_ > 0 ? low_ : none, count_ > 0 ? high_ : none, sum_ / count_};
  }

 private:
  double low_ = kInfinity, high_ = -kInfinity, sum_ = 0, count_ = 0;
};

}  // namespace

DemGrid::DemGrid(std::vector<float> heights, int columns, int rows)
    : heights_(std::move(heights)), columns_(columns), rows_(rows) {
  if (columns < 2 || rows < 2 ||
      heights_.size() != static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows))
    throw std::invalid_argument("a height grid needs at least 2 x 2 nodes");
  Extremes extremes;
  extremes.Add(heights_);
  std::tie(min_, max_, mean_) = extremes.LowHighMean();
}

DemGrid::DemGrid(ReadHeights read, int columns, int rows)
    : tiles_(std::make_unique<DemTiles>(std::move(read), columns, rows)),
      columns_(columns),
      rows_(rows) {
  if (columns < 2 || rows < 2)
    throw std::invalid_argument("a height grid needs at least 2 x 2 nodes");
  Extremes extremes;
  tiles_->VisitAll([&](const std::vector<float>& heights) { extremes.Add(heights); });
  std::tie(min_, max_, mean_) = extremes.LowHighMean();
}

CellHeights DemGrid::Cell(int column, int row) const {
  if (tiles_) return tiles_->Cell(column, row);
  const float* upper = heights_.data() + static_cast<std::ptrdiff_t>(row) * columns_ + column;
  const float* lower = upper + columns_;
  return {upper[0], upper[1], lower[0], lower[1]};
}

std::optional<double> DemGrid::HeightAt(double u, double v) const {
  if (!(u >= 0 && v >= 0 && u <= columns_ - 1 && v <= rows_ - 1)) return std::nullopt;
  const int column = std::min(static_cast<int>(u), columns_ - 2);
  const int row = std::min(static_cast<int>(v), rows_ - 2);
  const auto [h00, h10, h01, h11] = Cell(column, row);
  const double a = u - column, b = v - row;
  const double height = (1 - b) * ((1 - a) * h00 + a * h10) + b * ((1 - a) * h01 + a * h11);
  if (!std::isfinite(height)) return std::nullopt;
  return height;
}

// The current position of the walk from cell to cell.
struct DemGrid::Walk {
  int column, row;
  double t;
};

std::optional<double> DemGrid::TraceCell(const GridRay& ray, const Walk& walk, double t_exit,
                                         Side* side) const {
  const CellHeights corners = Cell(walk.column, walk.row);
  const double h00 = corners[0], h10 = corners[1], h01 = corners[2], h11 = corners[3];
  const double highest = std::max(std::max(h00, h10), std::max(h01, h11));
  const bool has_surface = std::isfinite(h00 + h10 + h01 + h11);
  if (!has_surface) {
    *side = Side::kUnknown;
    return std::nullopt;
  }
  if (ray.z + t_exit * ray.dz > highest) {
    *side = Side::kAbove;
    return std::nullopt;
  }
  // Along the ray the bilinear surface is a parabola: f(s) = ray - surface, s = t - walk.t.
  const double a = ray.u + walk.t * ray.du - walk.column;
  const double b = ray.v + walk.t * ray.dv - walk.row;
  const double by_a = h10 - h00, by_b = h01 - h00, twist = h11 - h10 - h01 + h00;
  const double f0 = ray.z + walk.t * ray.dz - (h00 + by_a * a + by_b * b + twist * a * b);
  if (f0 <= 0) {
    if (*side == Side::kAbove) return walk.t;
    *side = Side::kBelow;
    return std::nullopt;
  }
  *side = Side::kAbove;
  const double f1 = ray.dz - (by_a * ray.du + by_b * ray.dv + twist * (a * ray.dv + b * ray.du));
  const double f2 = -twist * ray.du * ray.dv;
  const auto s = FirstRoot(f0, f1, f2, t_exit - walk.t);
  if (!s) return std::nullopt;
  return walk.t + *s;
}

std::optional<double> DemGrid::Trace(const GridRay& ray, Side* side) const {
  double begin = ray.begin, end = ray.end;
  if (!ClipTo(ray.u, ray.du, columns_ - 1, &begin, &end) ||
      !ClipTo(ray.v, ray.dv, rows_ - 1, &begin, &end)) {
    *side = Side::kUnknown;
    return std::nullopt;
  }
  const auto cell_of = [](double coordinate, int nodes) {
    return std::clamp(static_cast<int>(std::floor(coordinate)), 0, nodes - 2);
  };
  Walk walk = {cell_of(ray.u + begin * ray.du, columns_), cell_of(ray.v + begin * ray.dv, rows_),
               begin};
  // The t at which the ray crosses the next line between columns, and between rows.
  const int column_step = ray.du > 0 ? 1 : -1, row_step = ray.dv > 0 ? 1 : -1;
  const double column_every = ray.du == 0 ? kInfinity : 1 / std::abs(ray.du);
  const double row_every = ray.dv == 0 ? kInfinity : 1 / std::abs(ray.dv);
  double next_column =
      ray.du == 0 ? kInfinity : (walk.column + (ray.du > 0 ? 1 : 0) - ray.u) / ray.du;
  double next_row = ray.dv == 0 ? kInfinity : (walk.row + (ray.dv > 0 ? 1 : 0) - ray.v) / ray.dv;
  while (true) {
    const double t_exit = std::max(walk.t, std::min({next_column, next_row, end}));
    const auto hit = TraceCell(ray, walk, t_exit, side);
    if (hit || *side == Side::kBelow || t_exit >= end) return hit;
    walk.t = t_exit;
    if (next_column <= next_row) {
      walk.column += column_step;
      next_column += column_every;
    } else {
      walk.row += row_step;
      next_row += row_every;
    }
    if (walk.column < 0 || walk.row < 0 || walk.column > columns_ - 2 || walk.row > rows_ - 2)
      return std::nullopt;
  }
}

}  // namespace orient
