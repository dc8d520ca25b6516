// Where on the earth a coordinate reference system is meant to be used.
#pragma once

#include <Eigen/Core>

#include "core/terrain/crs.h"

namespace orient {

// Whether (x, y), in metres of `crs`, may be a place in it: not where it lies outside the area of
// use by more than half the area's size, nor where it lies outside at all and within 100 km of x =
// y = 0, as coordinates do that lack their origin. True for a CRS that states no area of use.
bool MayHold(const Crs& crs, const Eigen::Vector2d& xy);

}  // namespace orient
