// The marks of a camera with a réseau: a few outer ones are searched as usual, the others where
// these say that they are.
#pragma once

#include <vector>

#include "interior/film_search.h"

namespace orient {

// Indices of the marks that lie farthest out in eight directions, at most eight: a constellation
// that does not fit itself when it is moved by one step of the grid.
std::vector<size_t> AnchorMarks(const std::vector<Fiducial>& fiducials);

// As ReadFilm. The windows of all other marks are 3 mm wide and lie where the anchors' transform
// puts them, so that dense crosses are never taken for their neighbours. Orientations that the
// anchors leave open and all marks together do not are decided by the number of marks found.
// Margin and polarity are the anchors'. Where the anchors are not found it is ReadFilm's answer for
// them alone, with the other marks unassigned.
FilmReading ReadFilmByAnchors(const Raster& scan, const CameraFile& camera,
                              const MarkShapes& shapes, const InteriorOptions& options);

}  // namespace orient
