// How the film lies where a person has clicked some of its marks: two clicks show where the others
// are to be looked for, one does where the pixel size is known.
#pragma once

#include <optional>

#include "core/raster/raster.h"
#include "interior/constellation/film_reading.h"

namespace orient::interior {

// A click and a place measured on the scan are of one mark where they are no farther apart, pixels.
double ClickReach_px(const MarkClick& click);

// Of the mark with this id; null where nobody clicked it.
const MarkClick* ClickOn(const std::vector<MarkClick>& clicks, const std::string& mark);

// The most probable reading with the clicks among the marks' candidates. Scan orientations are told
// apart, for clicks name the marks: `orientations` has one member. Two confused corners of a square
// look like a mirrored scan, so that one must be stated. A click
// that contradicts the others, or what is seen of the other marks, is not chosen. Empty where no
// scan orientation explains a click, or two of them. Throws InputError for a mark that the camera
// does not have.
std::optional<FilmReading> ReadFilmByClicks(const Raster& scan, const CameraFile& camera,
                                            const MarkShapes& shapes,
                                            const InteriorOptions& options);

}  // namespace orient::interior
