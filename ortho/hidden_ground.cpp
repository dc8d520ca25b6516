#include "ortho/hidden_ground.h"

#include <algorithm>
#include <cmath>

#include "core/base/side_by_side.h"

namespace orient::ortho {
namespace {

constexpr int kCells = 32;  // of the surface along a block's side

// Twice the largest rise over run between samples a cell apart: of a rise between two nodes of the
// surface, one of two neighbouring pairs of samples shows at least half.
float SteepestAround(const GroundSurface& surface, const Eigen::Vector2d& corner, double cell_m) {
  double largest = 0;
  std::vector<double> below;
  for (int row = 0; row <= kCells; ++row) {
    std::vector<double> heights(kCells + 1);
    for (int col = 0; col <= kCells; ++col)
      heights[static_cast<std::size_t>(col)] =
          surface.HeightAt(corner.x() + col * cell_m, corner.y() + row * cell_m)
              .value_or(std::nan(""));
    for (std::size_t col = 0; col < kCells && row > 0; ++col) {
      const double east = heights[col + 1] - heights[col], north = heights[col] - below[col];
      const double rise = std::hypot(std::isfinite(east) ? east : 0,  //
                                     std::isfinite(north) ? north : 0);
      largest = std::max(largest, rise);
    }
    below = std::move(heights);
  }
  return static_cast<float>(2 * largest / cell_m);
}

}  // namespace

HiddenGround::HiddenGround(const GroundSurface& surface, const Eigen::Vector3d& centre_m)
    : surface_(surface),
      centre_m_(centre_m),
      extent_(surface.Extent()),
      block_m_(kCells * surface.CellSize()) {
  columns_ = std::max(1, static_cast<int>(std::ceil((extent_.max_x - extent_.min_x) / block_m_)));
  rows_ = std::max(1, static_cast<int>(std::ceil((extent_.max_y - extent_.min_y) / block_m_)));
  steepest_.resize(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_));
  SideBySide(steepest_.size(), [&](std::size_t i) {
    const std::size_t col_of = i % static_cast<std::size_t>(columns_);
    const std::size_t row_of = i / static_cast<std::size_t>(columns_);
    const auto col = static_cast<double>(col_of), row = static_cast<double>(row_of);
    const double cell_m = surface_.CellSize();
    // The first samples lie in the preceding block, so that no pair across the border is missed.
    steepest_[i] = SteepestAround(
        surface_,
        {extent_.min_x + col * block_m_ - cell_m, extent_.min_y + row * block_m_ - cell_m},
        cell_m * (kCells + 1) / kCells);
  });
}

double HiddenGround::SteepestIn(const Bounds& bounds) const {
  const auto block = [&](double from, double at, int count) {
    return std::clamp(static_cast<int>(std::floor((at - from) / block_m_)), 0, count - 1);
  };
  float largest = 0;
  for (int row = block(extent_.min_y, bounds.min_y, rows_);
       row <= block(extent_.min_y, bounds.max_y, rows_); ++row)
    for (int col = block(extent_.min_x, bounds.min_x, columns_);
         col <= block(extent_.min_x, bounds.max_x, columns_); ++col)
      largest = std::max(largest, steepest_[static_cast<std::size_t>(row) * columns_ + col]);
  return largest;
}

bool HiddenGround::MayHide(const Bounds& bounds) const {
  const double above = centre_m_.z() - surface_.MaxHeight();
  if (!(above > 0)) return true;
  const double away =
      std::hypot(std::max(centre_m_.x() - bounds.min_x, bounds.max_x - centre_m_.x()),
                 std::max(centre_m_.y() - bounds.min_y, bounds.max_y - centre_m_.y()));
  // What hides the ground lies no farther towards the nadir than the flattest ray needs to rise
  // from the lowest to the highest place.
  const double reach = (surface_.MaxHeight() - surface_.MinHeight()) * away / above;
  Bounds before = bounds;
  before.min_x = std::min(before.min_x, std::max(centre_m_.x(), before.min_x - reach));
  before.min_y = std::min(before.min_y, std::max(centre_m_.y(), before.min_y - reach));
  before.max_x = std::max(before.max_x, std::min(centre_m_.x(), before.max_x + reach));
  before.max_y = std::max(before.max_y, std::min(centre_m_.y(), before.max_y + reach));
  return SteepestIn(before) * away >= above;
}

bool HiddenGround::Hides(const Eigen::Vector3d& ground_m) const {
  const Eigen::Vector3d along = ground_m - centre_m_;
  const auto met = surface_.Intersect({centre_m_, along.normalized()});
  // A ray from above meets a visible point to within the accuracy of the intersection.
  const double same_m = 1e-3 + 0.02 * surface_.CellSize();
  return !met || (*met - ground_m).norm() > same_m;
}

}  // namespace orient::ortho
