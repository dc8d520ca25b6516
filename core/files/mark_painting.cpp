#include "core/files/mark_painting.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace orient {
namespace {

using Eigen::Vector2d;

Eigen::Matrix2d TurnBack(double angle_rad) {
  return Eigen::Rotation2Dd(-angle_rad).toRotationMatrix();
}

bool IsInRectangle(const Vector2d& point, const Vector2d& half_size) {
  return std::abs(point.x()) <= half_size.x() && std::abs(point.y()) <= half_size.y();
}

struct PaintOn {
  const std::vector<Vector2d>& points;
  std::vector<float>* values;

  template <typename Element, typename Covers>
  void Where(const Element& element, const Covers& covers) const {
    const auto brightness = static_cast<float>(element.brightness);
    for (size_t i = 0; i < points.size(); ++i)
      if (covers(points[i])) (*values)[i] = brightness;
  }

  template <typename Element>
  void WhereNotOutside(const Element& element) const {
    const MarkElement any = element;
    Where(element, [&](const Vector2d& point) { return SignedDistance(any, point) <= 0; });
  }

  void operator()(const CrossElement& cross) const {
    const double middle = 0.25 * (cross.length_mm + cross.gap_mm);
    const Vector2d half(0.25 * (cross.length_mm - cross.gap_mm), 0.5 * cross.width_mm);
    const Eigen::Matrix2d turn = TurnBack(cross.angle_rad);
    Where(cross, [&](const Vector2d& point) {
      const Vector2d p = (turn * (point - cross.at_mm)).cwiseAbs();  // arms are alike
      return IsInRectangle({p.x() - middle, p.y()}, half) ||
             IsInRectangle({p.y() - middle, p.x()}, half);
    });
  }
  void operator()(const DotElement& dot) const {
    const double radius = 0.5 * dot.diameter_mm;
    Where(dot, [&](const Vector2d& point) {
      return (point - dot.at_mm).squaredNorm() <= radius * radius;
    });
  }
  void operator()(const CircleElement& circle) const {
    const double outer = 0.5 * (circle.diameter_mm + circle.width_mm);
    const double inner = std::max(0.5 * (circle.diameter_mm - circle.width_mm), 0.0);
    Where(circle, [&](const Vector2d& point) {
      const double square = (point - circle.at_mm).squaredNorm();
      return square <= outer * outer && square >= inner * inner;
    });
  }
  void operator()(const LineElement& line) const {
    const Vector2d half_length = 0.5 * (line.to_mm - line.from_mm);
    const Vector2d middle = line.from_mm + half_length, along = half_length.normalized();
    const Vector2d half(half_length.norm(), 0.5 * line.width_mm);
    Where(line, [&](const Vector2d& point) {
      return IsInRectangle({along.dot(point - middle),
                            along.x() * (point - middle).y() - along.y() * (point - middle).x()},
                           half);
    });
  }
  void operator()(const WedgeElement& wedge) const { WhereNotOutside(wedge); }
  void operator()(const PolygonElement& polygon) const { WhereNotOutside(polygon); }
  void operator()(const CheckerElement& checker) const {
    const Vector2d quarter = Vector2d::Constant(0.25 * checker.size_mm);
    const Eigen::Matrix2d turn = TurnBack(checker.angle_rad);
    Where(checker, [&](const Vector2d& point) {
      const Vector2d p = turn * (point - checker.at_mm);
      return IsInRectangle(p - quarter, quarter) || IsInRectangle(p + quarter, quarter);
    });
  }
};

}  // namespace

void Paint(const MarkElement& element, const std::vector<Vector2d>& points_mm,
           std::vector<float>* values) {
  std::visit(PaintOn{points_mm, values}, element);
}

}  // namespace orient
