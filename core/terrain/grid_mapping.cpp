#include "core/terrain/grid_mapping.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace orient {
namespace {

constexpr int kLargestTable = 600;  // nodes along one side
constexpr int kSamples = 12;        // along one side, where an error is measured

// Weights of the four nodes at -1, 0, 1, 2 for the cubic through them, at 0 <= a <= 1.
Eigen::Vector4d CubicWeights(double a) {
  return {-a * (a - 1) * (a - 2) / 6, (a + 1) * (a - 1) * (a - 2) / 2, -(a + 1) * a * (a - 2) / 2,
          (a + 1) * a * (a - 1) / 6};
}

}  // namespace

Eigen::Vector2d GridMapping::Interpolate(double x_m, double y_m) const {
  const double u = (x_m - west_) / step_m_, v = (y_m - south_) / step_m_;
  // The outermost ring of the table only serves the cubic.
  if (!(u >= 1 && v >= 1 && u <= columns_ - 2 && v <= rows_ - 2))
    return Eigen::Vector2d::Constant(std::numeric_limits<double>::quiet_NaN());
  const int column = std::min(static_cast<int>(u), columns_ - 3);
  const int row = std::min(static_cast<int>(v), rows_ - 3);
  const Eigen::Vector4d across = CubicWeights(u - column), up = CubicWeights(v - row);
  Eigen::Vector2d node = Eigen::Vector2d::Zero();
  for (int j = 0; j < 4; ++j) {
    const Eigen::Vector2d* p = table_.data() + (row - 1 + j) * columns_ + column - 1;
    node += up[j] * (across[0] * p[0] + across[1] * p[1] + across[2] * p[2] + across[3] * p[3]);
  }
  return node;
}

double GridMapping::CellSizeAt(double x_m, double y_m) const {
  const double h = 1.0;  // metre; the mapping is smooth over kilometres
  Eigen::Matrix2d node_by_block;
  node_by_block.col(0) = NodeFromBlock(x_m + h, y_m) - NodeFromBlock(x_m - h, y_m);
  node_by_block.col(1) = NodeFromBlock(x_m, y_m + h) - NodeFromBlock(x_m, y_m - h);
  return 2 * h / std::sqrt(std::abs(node_by_block.determinant()));
}

double GridMapping::CellAlongXAt(double x_m, double y_m) const {
  const double h = 1.0;
  const Eigen::Vector2d nodes = NodeFromBlock(x_m + h, y_m) - NodeFromBlock(x_m - h, y_m);
  return 2 * h / nodes.cwiseAbs().maxCoeff();
}

// Largest difference between the table and the exact mapping, in metres on the ground.
double GridMapping::TableError(const Exact& exact) const {
  double worst = 0;
  for (int j = 0; j < kSamples; ++j) {
    for (int i = 0; i < kSamples; ++i) {
      // Spread over the region, each in the middle between four nodes, where a cubic is worst.
      const auto middle = [](double low, double high, double origin, double step, int k) {
        const double wanted = low + (high - low) * (k + 0.5) / kSamples;
        return origin + (std::floor((wanted - origin) / step) + 0.5) * step;
      };
      const double x = middle(region_.min_x, region_.max_x, west_, step_m_, i);
      const double y = middle(region_.min_y, region_.max_y, south_, step_m_, j);
      const auto truth = exact({x, y});
      const Eigen::Vector2d node = Interpolate(x, y);
      if (!truth || !node.allFinite()) continue;
      const double cell_m = CellSizeAt(x, y);
      if (std::isfinite(cell_m)) worst = std::max(worst, (node - *truth).norm() * cell_m);
    }
  }
  return worst;
}

std::optional<GridMapping> GridMapping::Tabulate(const Exact& exact, const Bounds& region) {
  GridMapping mapping;
  mapping.region_ = region;
  const double width = region.max_x - region.min_x, height = region.max_y - region.min_y;
  for (mapping.step_m_ = std::max(width, height) / 4;; mapping.step_m_ /= 2) {
    const double step = mapping.step_m_;
    mapping.west_ = region.min_x - 2 * step;
    mapping.south_ = region.min_y - 2 * step;
    mapping.columns_ = static_cast<int>(std::ceil(width / step)) + 5;
    mapping.rows_ = static_cast<int>(std::ceil(height / step)) + 5;
    if (std::max(mapping.columns_, mapping.rows_) > kLargestTable) return std::nullopt;
    const Eigen::Vector2d none =
        Eigen::Vector2d::Constant(std::numeric_limits<double>::quiet_NaN());
    mapping.table_.clear();
    for (int row = 0; row < mapping.rows_; ++row)
      for (int column = 0; column < mapping.columns_; ++column)
        mapping.table_.push_back(
            exact({mapping.west_ + column * step, mapping.south_ + row * step}).value_or(none));
    if (mapping.TableError(exact) <= kTableError_m) break;
  }
  mapping.FindStraightLength();
  return mapping;
}

void GridMapping::FindStraightLength() {
  straight_length_m_ = std::max(region_.max_x - region_.min_x, region_.max_y - region_.min_y);
  for (int j = 0; j <= kSamples; ++j) {
    for (int i = 0; i <= kSamples; ++i) {
      const double x = region_.min_x + (region_.max_x - region_.min_x) * i / kSamples;
      const double y = region_.min_y + (region_.max_y - region_.min_y) * j / kSamples;
      for (const auto& [dx, dy] : {std::pair{0.5, 0.0}, {0.0, 0.5}, {0.35, 0.35}, {0.35, -0.35}}) {
        // The sagitta grows with the square of the length.
        const double l = step_m_;
        const Eigen::Vector2d bow =
            0.5 * (NodeFromBlock(x - l * dx, y - l * dy) + NodeFromBlock(x + l * dx, y + l * dy)) -
            NodeFromBlock(x, y);
        const double sagitta_m = bow.norm() * CellSizeAt(x, y);
        if (sagitta_m > 0)
          straight_length_m_ =
              std::min(straight_length_m_, l * std::sqrt(kTableError_m / sagitta_m));
      }
    }
  }
}

}  // namespace orient
