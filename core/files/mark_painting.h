// A mark's elements painted over many points at once.
#pragma once

#include <vector>

#include "core/files/mark_elements.h"

namespace orient {

// Gives the points (mark system) within the element, or on its outline, the element's brightness:
// what SignedDistance would say, without its roots.
void Paint(const MarkElement& element, const std::vector<Eigen::Vector2d>& points_mm,
           std::vector<float>* values);

}  // namespace orient
