// The template's side of least-squares matching. Internal to matching.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/geometry/principal_axes.h"
#include "core/raster/image.h"

namespace orient {

// Of its pixels all but the outer ring, which has no neighbours on one side, hence no gradient; row
// by row.
struct LsmTemplate {
  int cols = 0, rows = 0;
  Eigen::Vector2d first;          // centre of the first of these pixels, from the reference point
  Eigen::ArrayXd u, v;            // their offsets from the reference point, in half sizes
  Eigen::ArrayXd value;           // normalised: mean 0, deviation 1
  Eigen::ArrayXd by_col, by_row;  // gradient of that value, per template pixel
  Eigen::ArrayXd known;           // 1 or 0; the others are zero where this is
  double mean = 0, deviation = 0;
  double half_size = 1;
  std::vector<Eigen::Vector2d> corners;  // from the reference point, template pixels
};

// Empty where the image is flat. `reference` is the point of interest.
std::optional<LsmTemplate> PrepareTemplate(const Image& image, const Eigen::Vector2d& reference);

// Principal axes of the smoothed template's structure tensor. The pixel staircase of a sharp edge
// looks like information along the edge; smoothing removes it.
PrincipalAxes GradientAxes(const Image& templ);

}  // namespace orient
