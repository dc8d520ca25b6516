// Whether control contradicts GNSS as a whole. Private to block.
#pragma once

#include "block/bundle/normal_equations.h"

namespace orient::block {

// Positions that share an error of some metres and control that has none are both consistent in
// themselves; weights that residuals decide would then believe whichever is the larger group. What
// GNSS has in common is therefore an unknown first (CommonGnssShift), and is held at zero where it
// is not significant: against its covariance as stated, with what control shares and without the
// approximations, which may well share an error themselves. For unknowns that converged. True where
// it is held from now on, so that everything has to be adjusted anew.
bool HoldCommonGnssShiftIfInsignificant(const BlockTests& tests, BlockSystem* system);

}  // namespace orient::block
