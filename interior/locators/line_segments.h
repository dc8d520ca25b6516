// Short, nearly horizontal lines in an image, as the arms of a cross are.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/raster/image.h"

namespace orient::interior {

struct LineSearch {
  double length_px = 0;     // of the whole line, gap included
  double gap_px = 0;        // in its middle, where nothing is drawn
  double width_px = 1;      // of the stroke
  double max_slope = 0.09;  // from the horizontal
  int max_per_band = 30;    // lines of one polarity in a band as wide as a line is long
};

// y = offset + slope * (x - middle), corner convention.
struct LineSegment {
  double middle = 0, offset = 0, slope = 0;
  double reach = 0;  // the line was seen within middle +- reach
  int points = 0;    // that it was fitted to
  bool bright = true;

  double At(double x) const { return offset + slope * (x - middle); }
};

// Lines longer than the gap leaves are found as several overlapping segments.
std::vector<LineSegment> FindLineSegments(const Image& image, const LineSearch& search);

// Correlation of every pixel's surroundings with a horizontal line template: a bright bar of
// `length` x `width` pixels between two dark ones of the same width, a pixel apart; NaN near the
// border and where the image has no data.
Image CorrelateLine(const Image& image, int length, int width);

}  // namespace orient::interior
