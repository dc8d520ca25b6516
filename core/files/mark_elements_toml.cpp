#include "core/files/mark_elements_toml.h"

#include <cmath>

#include "core/geometry/rotation.h"

namespace orient {
namespace {

using Eigen::Vector2d;

double ReadAngle(const TomlTable& table) {
  return RadFromDeg(table.FindNumber("angle_deg").value_or(0));
}

Vector2d ReadPlace(const TomlTable& table) {
  return table.FindVector2("at_mm").value_or(Vector2d(Vector2d::Zero()));
}

double ReadBrightness(const TomlTable& table) {
  const double brightness = table.FindNumber("brightness").value_or(1);
  if (std::abs(brightness) > 1)
    table.Fail("brightness",
               "must lie between -1 (darker than the surroundings), 0 (as they are) "
               "and 1 (the brightest stroke)");
  return brightness;
}

CrossElement ReadCross(const TomlTable& table) {
  CrossElement cross;
  cross.length_mm = table.PositiveNumber("length_mm");
  cross.width_mm = table.PositiveNumber("width_mm");
  cross.gap_mm = table.FindNumber("gap_mm").value_or(0);
  if (cross.gap_mm < 0 || cross.gap_mm >= cross.length_mm)
    table.Fail("gap_mm", "must be at least 0 and smaller than length_mm");
  cross.angle_rad = ReadAngle(table);
  cross.at_mm = ReadPlace(table);
  cross.brightness = ReadBrightness(table);
  return cross;
}

DotElement ReadDot(const TomlTable& table) {
  return {table.PositiveNumber("diameter_mm"), ReadPlace(table), ReadBrightness(table)};
}

CircleElement ReadCircle(const TomlTable& table) {
  const CircleElement circle{table.PositiveNumber("diameter_mm"), table.PositiveNumber("width_mm"),
                             ReadPlace(table), ReadBrightness(table)};
  if (circle.width_mm >= circle.diameter_mm)
    table.Fail("width_mm", "must be smaller than diameter_mm; a filled disc is a dot");
  return circle;
}

LineElement ReadLine(const TomlTable& table) {
  const LineElement line{table.Vector2("from_mm"), table.Vector2("to_mm"),
                         table.PositiveNumber("width_mm"), ReadBrightness(table)};
  if (line.from_mm == line.to_mm) table.Fail("to_mm", "equals from_mm; a line must have a length");
  return line;
}

WedgeElement ReadWedge(const TomlTable& table) {
  return {table.PositiveNumber("base_mm"), table.PositiveNumber("depth_mm"), ReadAngle(table),
          ReadPlace(table), ReadBrightness(table)};
}

CheckerElement ReadChecker(const TomlTable& table) {
  return {table.PositiveNumber("size_mm"), ReadAngle(table), ReadPlace(table),
          ReadBrightness(table)};
}

// Twice the signed area of a triangle.
double Side(const Vector2d& a, const Vector2d& b, const Vector2d& c) {
  return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
}

bool EdgesCross(const Vector2d& a, const Vector2d& b, const Vector2d& c, const Vector2d& d) {
  return Side(a, b, c) * Side(a, b, d) < 0 && Side(c, d, a) * Side(c, d, b) < 0;
}

void RequireArea(const TomlTable& table, const std::vector<Vector2d>& points) {
  double twice_area = 0;
  for (size_t i = 0; i < points.size(); ++i) {
    const Vector2d &from = points[i], &to = points[(i + 1) % points.size()];
    if (from == to) table.Fail("points_mm", "has the same point twice in a row");
    twice_area += Side(Vector2d::Zero(), from, to);
  }
  if (twice_area == 0) table.Fail("points_mm", "encloses no area");
}

void RequireSimple(const TomlTable& table, const std::vector<Vector2d>& corners) {
  const size_t n = corners.size();
  for (size_t i = 0; i < n; ++i)
    for (size_t j = i + 1; j < n; ++j)
      if (EdgesCross(corners[i], corners[(i + 1) % n], corners[j], corners[(j + 1) % n]))
        table.Fail("points_mm", "is an outline that crosses itself; list its corners in order");
}

PolygonElement ReadPolygon(const TomlTable& table) {
  PolygonElement polygon{table.Points2("points_mm"), ReadBrightness(table)};
  if (polygon.points_mm.size() < 3) table.Fail("points_mm", "must have at least three points");
  polygon.open = table.FindFlag("open").value_or(false);
  if (!polygon.open) RequireSimple(table, polygon.points_mm);
  RequireArea(table, polygon.points_mm);
  if (polygon.open) RequireSimple(table, Corners(polygon));
  return polygon;
}

}  // namespace

MarkElement ReadMarkElement(const toml::table& raw, const std::string& file,
                            const std::string& name) {
  const TomlTable any(
      raw, file, name,
      {"shape", "length_mm", "width_mm", "gap_mm", "angle_deg", "diameter_mm", "at_mm",
       "brightness", "from_mm", "to_mm", "base_mm", "depth_mm", "size_mm", "points_mm", "open"});
  const std::string shape = any.Text("shape");
  if (shape == "cross")
    return ReadCross(
        {raw,
         file,
         name,
         {"shape", "length_mm", "width_mm", "gap_mm", "angle_deg", "at_mm", "brightness"}});
  if (shape == "dot")
    return ReadDot({raw, file, name, {"shape", "diameter_mm", "at_mm", "brightness"}});
  if (shape == "circle")
    return ReadCircle(
        {raw, file, name, {"shape", "diameter_mm", "width_mm", "at_mm", "brightness"}});
  if (shape == "line")
    return ReadLine({raw, file, name, {"shape", "from_mm", "to_mm", "width_mm", "brightness"}});
  if (shape == "wedge")
    return ReadWedge(
        {raw, file, name, {"shape", "base_mm", "depth_mm", "angle_deg", "at_mm", "brightness"}});
  if (shape == "checker")
    return ReadChecker({raw, file, name, {"shape", "size_mm", "angle_deg", "at_mm", "brightness"}});
  if (shape == "polygon")
    return ReadPolygon({raw, file, name, {"shape", "points_mm", "open", "brightness"}});
  any.Fail("shape", "is \"" + shape +
                        "\"; it must be cross or dot or circle or line or wedge or checker or "
                        "polygon");
}

}  // namespace orient
