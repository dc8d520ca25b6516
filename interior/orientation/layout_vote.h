// What the marks' calibrated positions say of the scan orientation, where their layout looks the
// same in several ways: crosses calibrated 70 um off a symmetric layout fit one scan orientation
// only.
#pragma once

#include <optional>

#include "interior/constellation/film_reading.h"
#include "interior/orientation/film_marks.h"
#include "interior/orientation/film_orientation.h"

namespace orient::interior {

// The evidence of the used marks for each of the `open` ways, of which `reading.orientations` has
// the first one first: log odds of the constellation calibrated for that way, the film's transform
// and the scatter of its marks (20 to 120 um) unknown. Only what an affine leaves counts, unless
// the scanner is stated to be photogrammetric (scales within 1e-3 then): scanners and films have
// two scales. Best and worst way get opposite nats; all are 0 for a layout without departures.
OrientationVote VoteOfLayout(const CameraFile& camera, const FilmReading& reading,
                             const FilmMarks& marks, const OrientationClass& open,
                             std::optional<Scanner> scanner);

// The same candidates read anew as a film that lies in `orientation`, one of the reading's class,
// with the marks' calibrated positions in that way and no allowance for the others (`scanner`:
// as the user stated it). The marks of a reseau keep their candidates.
FilmReading ReadingIn(const CameraFile& camera, const FilmReading& reading,
                      ScanOrientation orientation, std::optional<Scanner> scanner);

}  // namespace orient::interior
