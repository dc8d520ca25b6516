// What fiducial marks are drawn with: a few shapes, in mm around the mark's centre (mark system: x
// right, y up on the positive), lengths as in the camera file.
//
// Elements are painted in their order, later ones over earlier ones. Brightness on a positive: 0 is
// what surrounds the mark, 1 its brightest strokes, -1 as much darker.
#pragma once

#include <Eigen/Core>
#include <variant>
#include <vector>

namespace orient {

struct CrossElement {
  double length_mm = 0;  // tip to tip
  double width_mm = 0;
  double gap_mm = 0;     // whole opening at the centre
  double angle_rad = 0;  // counter-clockwise from +x; 0: arms along x and y
  Eigen::Vector2d at_mm = Eigen::Vector2d::Zero();
  double brightness = 1;
};
struct DotElement {
  double diameter_mm = 0;
  Eigen::Vector2d at_mm = Eigen::Vector2d::Zero();
  double brightness = 1;
};
struct CircleElement {
  double diameter_mm = 0;  // of the stroke's centre line
  double width_mm = 0;
  Eigen::Vector2d at_mm = Eigen::Vector2d::Zero();
  double brightness = 1;
};
// A bar with square ends.
struct LineElement {
  Eigen::Vector2d from_mm = Eigen::Vector2d::Zero();
  Eigen::Vector2d to_mm = Eigen::Vector2d::Zero();
  double width_mm = 0;
  double brightness = 1;
};
// A tooth or notch: a filled triangle with equal sides, whose tip is `at_mm`.
struct WedgeElement {
  double base_mm = 0;
  double depth_mm = 0;   // from the base to the tip
  double angle_rad = 0;  // direction in which the tip points, counter-clockwise from +x
  Eigen::Vector2d at_mm = Eigen::Vector2d::Zero();
  double brightness = 1;
};
// A square's opposite quarters, two filled squares that touch at the centre: upper right and lower
// left for angle 0.
struct CheckerElement {
  double size_mm = 0;  // side of the whole square
  double angle_rad = 0;
  Eigen::Vector2d at_mm = Eigen::Vector2d::Zero();
  double brightness = 1;
};
// Filled; the outline does not cross itself. An open one (a notch in the picture's edge) has no
// side from its last point to its first: its first and last sides continue straight outwards, and
// so does the filled area.
struct PolygonElement {
  std::vector<Eigen::Vector2d> points_mm;
  double brightness = 1;
  bool open = false;
};
using MarkElement = std::variant<CrossElement, DotElement, CircleElement, LineElement, WedgeElement,
                                 CheckerElement, PolygonElement>;

// Tip first, then the base's ends counter-clockwise.
std::vector<Eigen::Vector2d> Corners(const WedgeElement& wedge);

// An open polygon includes its extension, which reaches beyond any mark.
std::vector<Eigen::Vector2d> Corners(const PolygonElement& polygon);

// Signed distance (mm) from a point (mark system) to the element's outline; negative inside.
double SignedDistance(const MarkElement& element, const Eigen::Vector2d& point_mm);

// The same to what is drawn of the outline: not to where an open one goes on.
double StrokeDistance(const MarkElement& element, const Eigen::Vector2d& point_mm);

// To the nearest point of the mark: of an open polygon, of its outline as drawn and of what that
// encloses. Not positive inside.
double DistanceFromPart(const MarkElement& element, const Eigen::Vector2d& point_mm);

// Distance of the element's farthest point from the mark's centre, mm.
double Reach(const MarkElement& element);

// Width of the thinnest part, mm; of a polygon twice its area over half its perimeter.
double Thickness(const MarkElement& element);

double BrightnessOf(const MarkElement& element);

// Brightness of the topmost element at a point (mark system); 0 beside all of them.
double PaintedBrightness(const std::vector<MarkElement>& elements, const Eigen::Vector2d& point_mm);

}  // namespace orient
