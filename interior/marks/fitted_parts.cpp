#include "interior/marks/fitted_parts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace orient::interior {
namespace {

using Eigen::Vector2d;
using Elements = std::vector<MarkElement>;
using Parameters = std::vector<double>;

constexpr double kPi = std::numbers::pi;

// A shape that an element may have.
struct Shape {
  int lengths = 0;
  double turns_into_itself_rad = 0;  // 0: has no angle
  // Lengths in mm, then the angle.
  MarkElement (*draw)(const std::vector<double>& values, double brightness);
  // Starting values of the lengths, as shares of the window's half side.
  std::vector<std::vector<double>> starts;
};

MarkElement DrawCross(const std::vector<double>& v, double brightness) {
  return CrossElement{v[0], v[1], 0, v[2], Vector2d::Zero(), brightness};
}
MarkElement DrawOpenCross(const std::vector<double>& v, double brightness) {
  return CrossElement{v[0], v[1], v[2], v[3], Vector2d::Zero(), brightness};
}
MarkElement DrawCircle(const std::vector<double>& v, double brightness) {
  return CircleElement{v[0], v[1], Vector2d::Zero(), brightness};
}
MarkElement DrawDot(const std::vector<double>& v, double brightness) {
  return DotElement{v[0], Vector2d::Zero(), brightness};
}
MarkElement DrawWedge(const std::vector<double>& v, double brightness) {
  return WedgeElement{v[0], v[1], v[2], Vector2d::Zero(), brightness};
}
MarkElement DrawChecker(const std::vector<double>& v, double brightness) {
  return CheckerElement{v[0], v[1], Vector2d::Zero(), brightness};
}

const std::array<Shape, kFittedShapes>& Shapes() {
  static const std::array<Shape, kFittedShapes> shapes = {{
      {2, kPi / 2, DrawCross, {{0.8, 0.1}, {1.4, 0.06}, {1.4, 0.15}, {1.4, 0.3}}},
      {3, kPi / 2, DrawOpenCross, {{1.4, 0.06, 0.2}, {1.4, 0.12, 0.4}, {1.7, 0.1, 0.6}}},
      {2, 0, DrawCircle, {{0.5, 0.1}, {0.75, 0.1}, {1.0, 0.1}, {1.25, 0.1}, {1.5, 0.1}}},
      {1, 0, DrawDot, {{0.1}, {0.2}, {0.4}, {0.7}, {1.0}, {1.4}}},
      {2, 2 * kPi, DrawWedge, {{0.8, 0.8}, {1.0, 0.5}}},
      {1, kPi, DrawChecker, {{0.8}, {1.2}}},
  }};
  return shapes;
}

// False for degenerate strokes: a cross as wide as it is long, a circle without a hole, an opening
// that leaves no arms.
bool IsStroke(const MarkElement& element) {
  if (const auto* cross = std::get_if<CrossElement>(&element))
    return cross->width_mm < 0.4 * cross->length_mm && cross->gap_mm < 0.8 * cross->length_mm &&
           (cross->gap_mm == 0 || cross->gap_mm > cross->width_mm);
  if (const auto* circle = std::get_if<CircleElement>(&element))
    return circle->width_mm < 0.8 * circle->diameter_mm;
  return true;
}

// An element as bright as the surroundings is visible only on other elements.
bool ReachesBeyondTheOthers(const Elements& elements) {
  double shown = 0, hidden = 0;
  for (const MarkElement& element : elements) {
    double& reach = BrightnessOf(element) == 0 ? hidden : shown;
    reach = std::max(reach, Reach(element));
  }
  return hidden > 1.05 * shown;
}

double Rounded(double length_mm) { return std::round(length_mm * 200) / 200; }

// To a tenth of a degree, or to a multiple of `usual` nearby; into [0, turns_into_itself).
double Rounded(double angle, double turns_into_itself, double usual) {
  constexpr double kNearly = 4 * kPi / 180, kTenth = kPi / 1800;
  angle = std::round(angle / kTenth) * kTenth;
  const double nearest = std::round(angle / usual) * usual;
  if (std::abs(angle - nearest) < kNearly) angle = nearest;
  return angle - turns_into_itself * std::floor(angle / turns_into_itself + 1e-9);
}

struct Rounder {
  void operator()(CrossElement& e) const {
    e.length_mm = Rounded(e.length_mm);
    e.width_mm = std::max(Rounded(e.width_mm), 0.005);
    e.gap_mm = Rounded(e.gap_mm);
    e.angle_rad = Rounded(e.angle_rad, kPi / 2, kPi / 4);
  }
  void operator()(DotElement& e) const { e.diameter_mm = std::max(Rounded(e.diameter_mm), 0.005); }
  void operator()(CircleElement& e) const {
    e.diameter_mm = Rounded(e.diameter_mm);
    e.width_mm = std::max(Rounded(e.width_mm), 0.005);
  }
  void operator()(WedgeElement& e) const {
    e.base_mm = std::max(Rounded(e.base_mm), 0.005);
    e.depth_mm = std::max(Rounded(e.depth_mm), 0.005);
    e.angle_rad = Rounded(e.angle_rad, 2 * kPi, kPi / 4);
  }
  void operator()(CheckerElement& e) const {
    e.size_mm = std::max(Rounded(e.size_mm), 0.005);
    e.angle_rad = Rounded(e.angle_rad, kPi, kPi / 4);
  }
  void operator()(LineElement&) const {}
  void operator()(PolygonElement&) const {}
};

}  // namespace

Elements Drawn(const Parts& parts) {
  Elements elements;
  for (const Part& part : parts) {
    const Shape& shape = Shapes()[part.shape];
    std::vector<double> values = part.parameters;
    for (int i = 0; i < shape.lengths; ++i) values[i] = std::exp(values[i]);
    elements.push_back(shape.draw(values, part.brightness));
  }
  return elements;
}

size_t ParameterCount(const Parts& parts) {
  size_t count = 0;
  for (const Part& part : parts) count += part.parameters.size();
  return count;
}

std::vector<Parameters> StartsOf(size_t index, double half_mm) {
  const Shape& shape = Shapes()[index];
  std::vector<double> angles = {0};
  if (shape.turns_into_itself_rad > 0) {
    const int count = shape.turns_into_itself_rad > 4 ? 8 : 2;
    for (int i = 1; i < count; ++i) angles.push_back(i * shape.turns_into_itself_rad / count);
  }
  std::vector<Parameters> starts;
  for (const std::vector<double>& shares : shape.starts)
    for (const double angle : angles) {
      Parameters start;
      for (const double share : shares) start.push_back(std::log(share * half_mm));
      if (shape.turns_into_itself_rad > 0) start.push_back(angle);
      starts.push_back(std::move(start));
    }
  return starts;
}

bool IsDrawable(const Elements& elements) {
  return std::all_of(elements.begin(), elements.end(), IsStroke) &&
         !ReachesBeyondTheOthers(elements);
}

void RoundLengths(Elements* elements) {
  for (MarkElement& element : *elements) std::visit(Rounder(), element);
}

}  // namespace orient::interior
