// Measures the marks where a reading places them, and rejects those that are wrong.
#pragma once

#include <optional>
#include <vector>

#include "core/raster/raster.h"
#include "interior/constellation/film_reading.h"
#include "interior/marks/cross_position.h"
#include "interior/marks/subpixel.h"
#include "interior/orientation/film_transform.h"
#include "interior/orientation/measured_places.h"

namespace orient::interior {

// How many are in this state.
int Count(const FilmMarks& marks, MarkState state);

// Measures the assigned marks by least-squares matching with the drawing at the size and rotation
// that the reading found; bare crosses in the picture by their lines instead, unless another
// locator is `wanted` (cross_position.h); rejects wrong marks. What is among the scan's `known`
// places is not measured again, all others join them.
FilmMarks MeasureMarks(const Raster& scan, const CameraFile& camera, const MarkShapes& shapes,
                       const FilmReading& reading, std::optional<LocatorKind> wanted,
                       MeasuredPlaces* known);

// A cross's place by its lines, with the matched one's correlation. Where the two contradict each
// other beyond their sigmas (chi-square with two degrees of freedom), one of them is wrong and
// nothing tells which, however little correlates: the difference becomes part of the sigma.
MarkPosition PositionByLines(const MarkPosition& matched, const MeasuredCross& crossing);

// Of all measured marks those become rejected that do not look like the mark, that the others
// contradict (leave-one-out chi-square above 11.8) and that are not surely marks (gain below 3
// nats). A mark that only grain keeps from correlating looks like the mark if the reading leaves no
// doubt, or if all of the camera's marks are used with it, unless it correlates much less than the
// others. A reseau's cross whose strokes are clear looks like the mark, however little the picture
// beside them correlates with the drawing: its neighbours tell its place to some micrometres
// (reseau.h). Where fewer than a reseau's marks are left of them, correlation counts for all; but a
// mark that looks unlike is taken back where at least three others put it within their 90 % region
// (chi-square with two degrees of freedom) and its own sigma is no larger than theirs.
FilmMarks WithoutWrongMarks(const FilmReading& reading, const FilmMarks& measured);

// Exact clicks in place of what was measured there: used where the reading chose the click and the
// other marks do not contradict it, rejected otherwise.
void TakeExactClicks(const CameraFile& camera, const FilmReading& reading,
                     const std::vector<MarkClick>& clicks, FilmMarks* marks);

// Used marks, any of which may be wrong instead of a rejected one: without it, and with that one,
// none contradicts the others. With few marks snooping cannot tell them apart (separability).
std::vector<size_t> SuspectMarks(const FilmReading& reading, const FilmMarks& marks);

std::vector<MeasuredMark> UsedMarks(const CameraFile& camera, const FilmMarks& marks);

}  // namespace orient::interior
