// Marks outside their search windows, where the marks that were found put them: on film that lies
// turned, or that the scan cuts off.
#pragma once

#include <optional>
#include <vector>

#include "interior/constellation/film_reading.h"
#include "interior/locators/scan_windows.h"

namespace orient::interior {

// The most probable of these readings again, each with the marks that it lacks also looked for
// where two or more others put them on the scan, if that makes it more probable. Windows searched
// twice count twice, so that clutter gains nothing by it. Empty where nothing new was found.
std::vector<FilmReading> ReadingsBeyondWindows(const std::vector<FilmReading>& readings,
                                               const CameraFile& camera, const MarkShapes& shapes,
                                               std::optional<LocatorKind> locator,
                                               ScanWindows* windows);

}  // namespace orient::interior
