#include "tools/report/map_sheet.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tools/report/html_text.h"
#include "tools/report/svg_shapes.h"

namespace orient {
namespace {

using Eigen::Vector2d;
using Box = Eigen::AlignedBox2d;

constexpr double kLongestHeight = 720;
constexpr double kPadding = 0.05;  // of the extent, around what is drawn
constexpr double kTickReach = 34;  // half a coordinate's width: it must not leave the drawing

}  // namespace

Sheet MakeSheet(Box ground) {
  constexpr double kSmallest_m = 10;  // a single projection centre has no extent
  const Vector2d pad = (kPadding * ground.sizes()).cwiseMax(kSmallest_m);
  ground = Box(Vector2d(ground.min() - pad), Vector2d(ground.max() + pad));
  Sheet sheet;
  sheet.width = kSheetPageWidth - kSheetLeft - kSheetRight;
  sheet.scale = std::min(sheet.width / ground.sizes().x(), kLongestHeight / ground.sizes().y());
  sheet.height = std::max(ground.sizes().y() * sheet.scale, 120.0);
  // What is left over beside a narrow block is ground as well.
  const Vector2d half(0.5 * sheet.width / sheet.scale, 0.5 * sheet.height / sheet.scale);
  const Vector2d centre = ground.center();
  sheet.ground = Box(Vector2d(centre - half), Vector2d(centre + half));
  return sheet;
}

std::string SheetGrid(const Sheet& sheet) {
  SvgPath lines;
  std::string labels;
  const double step = RoundNumberBelow(sheet.ground.sizes().maxCoeff() / 4);
  const double x0 = std::ceil(sheet.ground.min().x() / step) * step;
  for (double x = x0; x < sheet.ground.max().x(); x += step) {
    const double at = sheet.At({x, 0}).x();
    lines.AddLine({at, 0}, {at, sheet.height});
    if (at + kTickReach < sheet.width + kSheetRight && at > kTickReach - kSheetLeft)
      labels += SvgText("tick", {at, sheet.height + 16}, Grouped(x, 0), kCentred);
  }
  const double y0 = std::ceil(sheet.ground.min().y() / step) * step;
  for (double y = y0; y < sheet.ground.max().y(); y += step) {
    const double at = sheet.At({0, y}).y();
    lines.AddLine({0, at}, {sheet.width, at});
    const std::string turned = fmt::format(" transform=\"rotate(-90 -8 {})\"", SvgNumber(at));
    labels += SvgText("tick", {-8, at}, Grouped(y, 0), kCentred + turned);
  }
  return lines.Element("grid") + labels;
}

std::string ScaleBar(const Sheet& sheet) {
  const double length_m = RoundNumberBelow(0.2 * sheet.width / sheet.scale);
  const double length = length_m * sheet.scale, x = sheet.width - 16, y = sheet.height - 16;
  const bool kilometres = length_m >= 1000;
  const std::string text = SvgNumber(kilometres ? length_m / 1000 : length_m, 3) + kThinSpace +
                           (kilometres ? "km" : "m");
  SvgPath bar;
  bar.AddLine({x - length, y}, {x, y});
  bar.AddLine({x - length, y - 4}, {x - length, y + 4});
  bar.AddLine({x, y - 4}, {x, y + 4});
  return bar.Element("halo") + bar.Element("bar") +
         SvgText("label", {x - length / 2, y - 7}, text, kCentred);
}

std::string NorthArrow(const Sheet& sheet) {
  const double x = sheet.width - 24;
  SvgPath arrow;
  arrow.AddArrow({x, 52}, {x, 26});
  return arrow.Element("halo") + arrow.Element("bar") + SvgText("label", {x, 20}, "N", kCentred);
}

}  // namespace orient
