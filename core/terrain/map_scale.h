// How much longer or shorter a map's lines are than those on the ellipsoid.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

#include "core/geometry/bounds.h"
#include "core/terrain/crs.h"

namespace orient {

// Lengths on the map over those on the ellipsoid, over all directions at one place. The two are
// equal where the projection is conformal.
struct MapScale {
  double least = 1, largest = 1;
};

// At (x, y) in metres of `crs`, by central differences. Empty where the place cannot be traced back
// to the ellipsoid: outside the projection, or in a CRS without a geographic one below it.
std::optional<MapScale> MapScaleAt(const Crs& crs, const Eigen::Vector2d& xy);

// Whether collinearity with heights in metres holds on such a map; see docs/method/earth.md.
bool IsTrueToScale(const MapScale& scale);

// A CRS true to scale at a place on the earth: UTM, near the poles UPS, of WGS 84; its EPSG code.
int FittingEpsg(double longitude_deg, double latitude_deg);

// Throws InputError that names CRS, scale, place and a fitting CRS, where the scale is known
// somewhere in `area` (middle and corners) and true nowhere there.
void RefuseFalseScale(const Crs& crs, const Bounds& area);

}  // namespace orient
