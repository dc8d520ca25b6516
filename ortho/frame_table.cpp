#include "ortho/frame_table.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/side_by_side.h"
#include "core/geometry/lens.h"

namespace orient::ortho {
namespace {

using Eigen::Vector2d;

constexpr int kNodes = 513;  // along each side

// Ideal image points of the frame's outline.
Bounds IdealBounds(const Camera& camera) {
  constexpr int kAlong = 64;
  Bounds bounds = Bounds::OfNothing();
  for (int i = 0; i <= kAlong; ++i)
    for (const double across : {-0.5, 0.5}) {
      const double along = static_cast<double>(i) / kAlong - 0.5;
      for (const Vector2d& unit : {Vector2d(along, across), Vector2d(across, along)}) {
        const Vector2d photo_mm = camera.frame_centre_mm + unit.cwiseProduct(camera.frame_mm);
        const Vector2d measured = photo_mm - camera.principal_point_mm;
        const auto ideal = UndistortPoint(camera.lens, measured);
        if (ideal) bounds.Include(ideal->x(), ideal->y());
      }
    }
  return bounds;
}

}  // namespace

FrameTable::FrameTable(const PhotoView& view, double border_mm, std::vector<Bounds> marks)
    : marks_(std::move(marks)) {
  const Camera& camera = view.camera;
  const Vector2d half =
      (0.5 * camera.frame_mm - Vector2d(border_mm, border_mm)).cwiseMax(Vector2d::Zero());
  const Vector2d low = camera.frame_centre_mm - half, high = camera.frame_centre_mm + half;
  within_ = {low.x(), low.y(), high.x(), high.y()};
  const Bounds ideal = IdealBounds(camera);
  if (ideal.Empty()) return;  // a lens that shows nothing: no node
  const Vector2d size(ideal.max_x - ideal.min_x, ideal.max_y - ideal.min_y);
  step_mm_ = size / (kNodes - 3);  // a node beyond each edge
  origin_mm_ = Vector2d(ideal.min_x, ideal.min_y) - step_mm_;
  nodes_.resize(static_cast<std::size_t>(kNodes) * kNodes);
  SideBySide(kNodes, [&](std::size_t row) {
    for (std::size_t col = 0; col < kNodes; ++col) {
      const Vector2d at = origin_mm_ + step_mm_.cwiseProduct(Vector2d(col, row));
      Node& node = nodes_[row * kNodes + col];
      if (!InsideFold(camera.lens, at)) {
        node.photo_mm.setConstant(std::nan(""));
        continue;
      }
      node.photo_mm = camera.principal_point_mm + DistortPoint(camera.lens, at);
      node.pixel = view.PixelFromPhoto(node.photo_mm);
    }
  });
  FindInnerCells();
}

bool FrameTable::Seen(const Vector2d& photo_mm) const {
  return within_.Contains(photo_mm.x(), photo_mm.y()) &&
         std::none_of(marks_.begin(), marks_.end(), [&](const Bounds& mark) {
           return mark.Contains(photo_mm.x(), photo_mm.y());
         });
}

void FrameTable::FindInnerCells() {
  for (std::size_t i = 0; i + kNodes + 1 < nodes_.size(); ++i) {
    Bounds cell = Bounds::OfNothing();
    bool seen = true;
    for (const std::size_t corner : {i, i + 1, i + kNodes, i + kNodes + 1}) {
      const Vector2d& photo_mm = nodes_[corner].photo_mm;
      seen = seen && Seen(photo_mm);
      cell.Include(photo_mm.x(), photo_mm.y());
    }
    nodes_[i].inner = seen && std::none_of(marks_.begin(), marks_.end(),
                                           [&](const Bounds& mark) { return mark.Overlaps(cell); });
  }
}

std::optional<Vector2d> FrameTable::PixelOf(const Vector2d& ideal_mm) const {
  const Vector2d at = (ideal_mm - origin_mm_).cwiseQuotient(step_mm_);
  if (nodes_.empty() || !(at.minCoeff() >= 0 && at.maxCoeff() < kNodes - 1)) return std::nullopt;
  const int col = static_cast<int>(at.x()), row = static_cast<int>(at.y());
  const double right = at.x() - col, down = at.y() - row;
  const Node* upper = &nodes_[static_cast<std::size_t>(row) * kNodes + col];
  const Node* lower = upper + kNodes;
  const auto between = [&](Vector2d Node::*of) -> Vector2d {
    return (1 - down) * ((1 - right) * upper[0].*of + right * upper[1].*of) +
           down * ((1 - right) * lower[0].*of + right * lower[1].*of);
  };
  if (!upper->inner) {
    const Vector2d photo_mm = between(&Node::photo_mm);
    if (!Seen(photo_mm)) return std::nullopt;
  }
  return between(&Node::pixel);
}

}  // namespace orient::ortho
