// The marks of a camera with a réseau: a few outer ones are searched for as usual, the others where
// these predict them.
#pragma once

#include <vector>

#include "interior/constellation/film_reading.h"

namespace orient::interior {

// Indices of the marks that lie farthest out in eight directions, at most eight: a constellation
// that does not fit itself when it is moved by one step of the grid.
std::vector<size_t> AnchorMarks(const std::vector<Fiducial>& fiducials);

// By how much the layout may be moved so that at least half of its marks, or of those with one
// drawing (crosses among fiducial marks), lie where others lay: to the next crosses of a reseau, at
// most eight, the shortest first. Photo system, mm.
std::vector<Eigen::Vector2d> MeshShifts(const std::vector<Fiducial>& fiducials);

// As ReadFilm. The windows of all other marks are 3 mm wide and lie where the anchors' transform
// puts them, so that dense crosses are never confused with their neighbours. What the anchors leave
// open, all marks together decide: orientations, other readings of the anchors that are nearly as
// probable, and the film lying a mesh farther on, where a row of crosses on the border is missing.
// The margin is that of all marks together. Where the anchors are not found no mark is assigned.
FilmReading ReadFilmByAnchors(const Raster& scan, const CameraFile& camera,
                              const MarkShapes& shapes, const InteriorOptions& options);

}  // namespace orient::interior
