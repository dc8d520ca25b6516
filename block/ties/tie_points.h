// Tie points: places that two or more photos of a block show, measured in all of them.
//
// Every photo owns the part of the ground that it sees nearer to its centre than the others do;
// there one interest point per cell of its frame is searched for in every other photo that shows
// it. So the ties spread over the von Gruber areas and over every overlap, three-fold and side-lap
// ones too, and no place is measured twice.
#pragma once

#include <cstddef>
#include <vector>

#include "block/ties/tie.h"
#include "core/terrain/ground_surface.h"

namespace orient::block {

// Those ties that photos[owner] owns. Reads windows of the images only. The same ones every time. A
// photo that is damaged shows nothing there; throws InputError where the owner is.
std::vector<MeasuredTie> FindTies(const std::vector<TiePhoto>& photos, std::size_t owner,
                                  const GroundSurface& surface, const TieOptions& options = {});

}  // namespace orient::block
