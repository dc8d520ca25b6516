// Where photos of a flight were taken from, where only some of them are located and the order of
// the strips is known: what strip geometry says, and how well.
#pragma once

#include <optional>
#include <vector>

#include "core/files/flight_plan.h"
#include "core/files/orientation_table.h"
#include "core/geometry/camera.h"

namespace orient::block {

// Least squares for the positions of all photos of the strips. Observed are the located ones; that
// photos follow one another by their strip's base, the same from photo to photo to a share of
// itself; the base by overlap, frame and scale, where the azimuth is stated with its direction; the
// next strip lies by the side-lap beside the one before, their middles abreast, and is flown back.
// So two located photos give a direction that is not stated, and a sigma grows with the distance
// from what is located. Where neither azimuth nor a second photo tells the direction, a strip may
// run anywhere from its located photo.
//
// `located` holds what is known (metres, `sigma` must be there, attitude_known says whether kappa
// is) and may have photos of no strip; `ground_m` is the ground's height. Returns the strips'
// photos that are not located, with sigmas of position and attitude (kappa: as the nearest located
// photo's, turned with the strip; without any unknown). Throws InputError: no photo of the strips
// is located, or none above the ground.
std::vector<OrientationRow> FillStrips(const FlightPlan& plan,
                                       const std::vector<OrientationRow>& located,
                                       const Camera& camera, double ground_m);

// Base along a strip and distance between strips, m; `uncertain`: relative uncertainty of both
// if it is not known which side of the frame lies along the flight.
struct StripDistances {
  double base_m = 0, apart_m = 0, uncertain = 0;
};
// At `height_m` above the ground. `x_along`: whether the photos' x axis lies along the flight.
StripDistances DistancesOf(const FlightPlan& plan, const Camera& camera, double height_m,
                           std::optional<bool> x_along);

}  // namespace orient::block
