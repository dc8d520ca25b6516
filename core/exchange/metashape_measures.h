// Metashape's markers XML (File > Export > Export Markers), read: pixels as ours. Private to
// core/exchange.
#pragma once

#include <string>

#include "core/measurements/gathered_measurements.h"

namespace orient {

// Every chunk by itself: ids of cameras and markers are those of its chunk. A marker that is not
// enabled as control is a check point. A location is a measurement unless it is not valid (taken
// out of the photo) or not pinned (Metashape predicted it); how many were left out is noted.
//
// Throws InputError naming file and line: ids that nothing has, two cameras of one name, locations
// in several frames, ground coordinates in degrees or geocentric (the chunk's reference system).
void AddMetashapeMarkers(const std::string& path, const MeasuredSigma& sigma,
                         GatheredMeasurements* all);

}  // namespace orient
