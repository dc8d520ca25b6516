// The elements that a drawing is fitted of (drawing_fit.h), with their parameters.
#pragma once

#include <cstddef>
#include <vector>

#include "core/files/mark_elements.h"

namespace orient::interior {

// Cross, open cross, circle, dot, wedge, checker.
inline constexpr size_t kFittedShapes = 6;

struct Part {
  size_t shape = 0;  // below kFittedShapes
  double brightness = 1;
  // Logarithms of lengths in mm, then the angle in radians, where the shape has one.
  std::vector<double> parameters;
};
using Parts = std::vector<Part>;

// In their order; all around the mark's centre.
std::vector<MarkElement> Drawn(const Parts& parts);

size_t ParameterCount(const Parts& parts);

// Parameters to begin with, in a window of this half side.
std::vector<std::vector<double>> StartsOf(size_t shape, double half_mm);

// False for what is no drawing: a cross as wide as it is long, a circle without a hole, an opening
// that leaves no arms; or what has the brightness of the surroundings and reaches beyond the other
// elements, on which alone it is seen.
bool IsDrawable(const std::vector<MarkElement>& elements);

// Lengths to 5 micrometres, angles to a tenth of a degree, and to multiples of 45 degrees nearby.
void RoundLengths(std::vector<MarkElement>* elements);

}  // namespace orient::interior
