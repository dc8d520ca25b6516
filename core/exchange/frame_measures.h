// Image coordinates and control of PAT-B and BINGO, read. Private to core/exchange.
//
// Image coordinates: photo by photo a heading, points, a line -99; relative to the principal point
// and without distortion (frame_adjustments.h). A heading is the photo's number and, optionally,
// its principal distance (BINGO: its camera) and two codes; a point its number, x, y and,
// optionally, a code. Units: PAT-B micrometres, BINGO millimetres.
//
// Control of PAT-B: one block "point X Y Z code", or two, horizontal "point X Y code" and vertical
// "point Z code", each ended by -99; the codes of standard deviations are not used. Of BINGO: lines
// "CONT point X Y Z". Metres.
//
// Photos get their names where photo_numbers.txt lies beside; that, and points that have no height
// or only one, are noted. Everything else that does not fit is an InputError naming file, line and
// value.
#pragma once

#include <string>

#include "core/measurements/gathered_measurements.h"

namespace orient {

// Whether a file holds image coordinates or control follows from its lines, where these fit both
// from its ending .im or .con; otherwise it is refused.
void AddPatbMeasures(const std::string& path, const MeasuredSigma& sigma,
                     GatheredMeasurements* all);
void AddBingoMeasures(const std::string& path, const MeasuredSigma& sigma,
                      GatheredMeasurements* all);

}  // namespace orient
