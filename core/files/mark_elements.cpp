#include "core/files/mark_elements.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace orient {
namespace {

using Eigen::Vector2d;

double Cross(const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

Vector2d Turned(const Vector2d& v, double angle_rad) {
  return angle_rad == 0 ? v : Eigen::Rotation2Dd(angle_rad) * v;
}

double RectangleDistance(const Vector2d& point, const Vector2d& half_size) {
  const Vector2d d = point.cwiseAbs() - half_size;
  return d.cwiseMax(0.0).norm() + std::min(d.maxCoeff(), 0.0);
}

double SegmentDistance(const Vector2d& from, const Vector2d& to, const Vector2d& point) {
  const Vector2d along = to - from;
  const double t = std::clamp((point - from).dot(along) / along.squaredNorm(), 0.0, 1.0);
  return (point - from - t * along).norm();
}

// Whether the ray from `point` to +x crosses the segment; an odd number of crossings means inside.
bool CrossesRay(const Vector2d& from, const Vector2d& to, const Vector2d& point) {
  if ((from.y() > point.y()) == (to.y() > point.y())) return false;
  const double t = (point.y() - from.y()) / (to.y() - from.y());
  return from.x() + t * (to.x() - from.x()) > point.x();
}

double PolygonDistance(const std::vector<Vector2d>& corners, const Vector2d& point) {
  double distance = std::numeric_limits<double>::infinity();
  bool inside = false;
  for (size_t i = 0; i < corners.size(); ++i) {
    const Vector2d& from = corners[i];
    const Vector2d& to = corners[(i + 1) % corners.size()];
    distance = std::min(distance, SegmentDistance(from, to, point));
    if (CrossesRay(from, to, point)) inside = !inside;
  }
  return inside ? -distance : distance;
}

// To the sides between successive points; none from the last one back to the first.
double DistanceToSides(const std::vector<Vector2d>& points, const Vector2d& point) {
  double distance = std::numeric_limits<double>::infinity();
  for (size_t i = 0; i + 1 < points.size(); ++i)
    distance = std::min(distance, SegmentDistance(points[i], points[i + 1], point));
  return distance;
}

double FarthestOf(const std::vector<Vector2d>& corners) {
  double farthest = 0;
  for (const Vector2d& corner : corners) farthest = std::max(farthest, corner.norm());
  return farthest;
}

// Positive where the corners go round counter-clockwise.
double TwiceArea(const std::vector<Vector2d>& corners) {
  double twice_area = 0;
  for (size_t i = 0; i < corners.size(); ++i)
    twice_area += Cross(corners[i], corners[(i + 1) % corners.size()]);
  return twice_area;
}

double PolygonThickness(const std::vector<Vector2d>& corners) {
  double perimeter = 0;
  for (size_t i = 0; i < corners.size(); ++i)
    perimeter += (corners[(i + 1) % corners.size()] - corners[i]).norm();
  return 2 * std::abs(TwiceArea(corners)) / perimeter;
}

// Outward unit normal of the side from the last point to the first.
Vector2d OutOf(const PolygonElement& polygon) {
  const Vector2d along = polygon.points_mm.front() - polygon.points_mm.back();
  const double turn = TwiceArea(polygon.points_mm) > 0 ? 1 : -1;
  return turn * Vector2d(along.y(), -along.x()).normalized();
}

struct DistanceTo {
  Vector2d point;

  double operator()(const CrossElement& cross) const {
    const double arm = 0.5 * (cross.length_mm - cross.gap_mm);
    const double middle = 0.25 * (cross.length_mm + cross.gap_mm);
    const Vector2d p = Turned(point - cross.at_mm, -cross.angle_rad).cwiseAbs();  // arms are equal
    const Vector2d half(0.5 * arm, 0.5 * cross.width_mm);
    return std::min(RectangleDistance(p - Vector2d(middle, 0), half),
                    RectangleDistance(p - Vector2d(0, middle), {half.y(), half.x()}));
  }
  double operator()(const DotElement& dot) const {
    return (point - dot.at_mm).norm() - 0.5 * dot.diameter_mm;
  }
  double operator()(const CircleElement& circle) const {
    return std::abs((point - circle.at_mm).norm() - 0.5 * circle.diameter_mm) -
           0.5 * circle.width_mm;
  }
  double operator()(const LineElement& line) const {
    const Vector2d half_length = 0.5 * (line.to_mm - line.from_mm);
    const Vector2d from_middle = point - line.from_mm - half_length;
    const Vector2d along = half_length.normalized();
    return RectangleDistance({along.dot(from_middle), Cross(along, from_middle)},
                             {half_length.norm(), 0.5 * line.width_mm});
  }
  double operator()(const WedgeElement& wedge) const {
    return PolygonDistance(Corners(wedge), point);
  }
  double operator()(const CheckerElement& checker) const {
    const Vector2d p = Turned(point - checker.at_mm, -checker.angle_rad);
    const Vector2d quarter = Vector2d::Constant(0.25 * checker.size_mm);
    return std::min(RectangleDistance(p - quarter, quarter),
                    RectangleDistance(p + quarter, quarter));
  }
  double operator()(const PolygonElement& polygon) const {
    return PolygonDistance(polygon.open ? Corners(polygon) : polygon.points_mm, point);
  }
};

struct ReachOf {
  double operator()(const CrossElement& e) const {
    return e.at_mm.norm() + 0.5 * std::hypot(e.length_mm, e.width_mm);
  }
  double operator()(const DotElement& e) const { return e.at_mm.norm() + 0.5 * e.diameter_mm; }
  double operator()(const CircleElement& e) const {
    return e.at_mm.norm() + 0.5 * (e.diameter_mm + e.width_mm);
  }
  double operator()(const LineElement& e) const {
    return std::max(e.from_mm.norm(), e.to_mm.norm()) + 0.5 * e.width_mm;
  }
  double operator()(const WedgeElement& e) const { return FarthestOf(Corners(e)); }
  double operator()(const CheckerElement& e) const {
    return e.at_mm.norm() + std::sqrt(0.5) * e.size_mm;
  }
  double operator()(const PolygonElement& e) const { return FarthestOf(e.points_mm); }
};

struct ThicknessOf {
  double operator()(const CrossElement& e) const { return e.width_mm; }
  double operator()(const DotElement& e) const { return e.diameter_mm; }
  double operator()(const CircleElement& e) const { return e.width_mm; }
  double operator()(const LineElement& e) const { return e.width_mm; }
  double operator()(const WedgeElement& e) const { return PolygonThickness(Corners(e)); }
  double operator()(const CheckerElement& e) const { return 0.5 * e.size_mm; }
  double operator()(const PolygonElement& e) const { return PolygonThickness(e.points_mm); }
};

}  // namespace

std::vector<Vector2d> Corners(const WedgeElement& wedge) {
  const Vector2d back = Turned({-wedge.depth_mm, 0}, wedge.angle_rad);
  const Vector2d side = Turned({0, 0.5 * wedge.base_mm}, wedge.angle_rad);
  return {wedge.at_mm, wedge.at_mm + back + side, wedge.at_mm + back - side};
}

std::vector<Vector2d> Corners(const PolygonElement& polygon) {
  std::vector<Vector2d> corners = polygon.points_mm;
  if (!polygon.open) return corners;
  constexpr double kBeyond_mm = 100;
  const auto goes_on = [&](const Vector2d& end, const Vector2d& before) -> Vector2d {
    return end + kBeyond_mm * (end - before).normalized();
  };
  const Vector2d first = goes_on(corners[0], corners[1]);
  const Vector2d last = goes_on(corners.back(), corners[corners.size() - 2]);
  const Vector2d beyond = kBeyond_mm * OutOf(polygon);
  corners.insert(corners.end(), {last, last + beyond, first + beyond, first});
  return corners;
}

double SignedDistance(const MarkElement& element, const Vector2d& point_mm) {
  return std::visit(DistanceTo{point_mm}, element);
}

double StrokeDistance(const MarkElement& element, const Vector2d& point_mm) {
  const double distance = SignedDistance(element, point_mm);
  const auto* polygon = std::get_if<PolygonElement>(&element);
  if (polygon == nullptr || !polygon->open) return distance;
  return std::copysign(DistanceToSides(polygon->points_mm, point_mm), distance);
}

double DistanceFromPart(const MarkElement& element, const Vector2d& point_mm) {
  const auto* polygon = std::get_if<PolygonElement>(&element);
  if (polygon == nullptr || !polygon->open) return SignedDistance(element, point_mm);
  return std::min(DistanceToSides(polygon->points_mm, point_mm),
                  PolygonDistance(polygon->points_mm, point_mm));
}

double Reach(const MarkElement& element) { return std::visit(ReachOf(), element); }

double Thickness(const MarkElement& element) { return std::visit(ThicknessOf(), element); }

double BrightnessOf(const MarkElement& element) {
  return std::visit([](const auto& e) { return e.brightness; }, element);
}

double PaintedBrightness(const std::vector<MarkElement>& elements, const Vector2d& point_mm) {
  for (auto e = elements.rbegin(); e != elements.rend(); ++e)
    if (SignedDistance(*e, point_mm) <= 0) return BrightnessOf(*e);
  return 0;
}

}  // namespace orient
