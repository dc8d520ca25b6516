#include "exterior/steps/pixel_lattice.h"

#include <algorithm>
#include <cmath>

namespace orient::exterior {

PixelLattice::PixelLattice(
    int side, double step,
    const std::function<std::optional<Eigen::Vector2d>(const Eigen::Vector2d&)>& place)
    : step_(step), nodes_(static_cast<int>(std::ceil(side / step)) + 1) {
  const Eigen::Vector2d lost = Eigen::Vector2d::Constant(std::nan(""));
  places_.reserve(static_cast<std::size_t>(nodes_ * nodes_));
  for (int row = 0; row < nodes_; ++row)
    for (int col = 0; col < nodes_; ++col)
      places_.push_back(place(step_ * Eigen::Vector2d(col, row)).value_or(lost));
}

Eigen::Vector2d PixelLattice::At(double col, double row) const {
  const double u = col / step_, v = row / step_;
  const int i = std::min(static_cast<int>(u), nodes_ - 2);
  const int j = std::min(static_cast<int>(v), nodes_ - 2);
  const double fu = u - i, fv = v - j;
  return (1 - fv) * ((1 - fu) * Node(i, j) + fu * Node(i + 1, j)) +
         fv * ((1 - fu) * Node(i, j + 1) + fu * Node(i + 1, j + 1));
}

double PixelLattice::Scale() const {
  const Eigen::Vector2d across = Node(nodes_ - 1, nodes_ / 2) - Node(0, nodes_ / 2);
  const Eigen::Vector2d down = Node(nodes_ / 2, nodes_ - 1) - Node(nodes_ / 2, 0);
  return (across.norm() + down.norm()) / (2 * step_ * (nodes_ - 1));
}

std::optional<std::pair<Eigen::Vector2d, Eigen::Vector2d>> PixelLattice::Area() const {
  Eigen::Vector2d low = Eigen::Vector2d::Constant(1e9), high = -low;
  for (const Eigen::Vector2d& place : places_) {
    if (!place.allFinite()) continue;
    low = low.cwiseMin(place);
    high = high.cwiseMax(place);
  }
  if (low.x() > high.x()) return std::nullopt;
  return std::pair<Eigen::Vector2d, Eigen::Vector2d>{(low + high) / 2, (high - low) / 2};
}

int SamplesOfPixel(double scale, int most) {
  if (!std::isfinite(scale)) return 1;
  return std::clamp(static_cast<int>(std::ceil(scale - 0.2)), 1, most);
}

}  // namespace orient::exterior
