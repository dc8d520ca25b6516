// The sheet of a map in the report: where places on the ground lie in it, its grid, scale bar and
// north arrow.
#pragma once

#include <Eigen/Geometry>
#include <string>

namespace orient {

// Sizes in the SVG's units; the page shows about 1 unit as 1 CSS pixel.
inline constexpr double kSheetPageWidth = 1000;
inline constexpr double kSheetLeft = 34, kSheetRight = 12, kSheetTop = 12, kSheetBottom = 34;

// Ground to SVG, north up.
struct Sheet {
  Eigen::AlignedBox2d ground;
  double scale = 1;  // units per metre
  double width = 0, height = 0;

  Eigen::Vector2d At(const Eigen::Vector2d& xy) const {
    return {(xy.x() - ground.min().x()) * scale, (ground.max().y() - xy.y()) * scale};
  }
};

// Around what is drawn, with a margin; as wide as the page.
Sheet MakeSheet(Eigen::AlignedBox2d ground);

// Lines at round coordinates, with these beside the sheet.
std::string SheetGrid(const Sheet& sheet);
std::string ScaleBar(const Sheet& sheet);
std::string NorthArrow(const Sheet& sheet);

}  // namespace orient
