// Whether control contradicts GNSS as a whole. Private to block.
#pragma once

#include <vector>

#include "block/bundle/normal_equations.h"

namespace orient::block {

// Positions that share an error of some metres and control that has none are both consistent in
// themselves; weights that residuals decide would then believe whichever is the larger group. What
// GNSS has in common is therefore an unknown first (CommonGnssShift), and is held at zero where it
// is not significant: against its covariance as stated, with what control shares (through
// `as_weighted`) and without the approximations, which may well share an error themselves. It is
// also held where fewer than three control points are used, of which none could be told wrong, or
// not most positions of the photos that take part. For unknowns that converged. True where it is
// held from now on, so that everything has to be adjusted anew.
bool HoldCommonGnssShiftIfInsignificant(const BlockTests& tests, const BlockNormals& as_weighted,
                                        const std::vector<bool>& takes_part, BlockSystem* system);

}  // namespace orient::block
