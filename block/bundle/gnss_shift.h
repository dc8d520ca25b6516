// Whether control contradicts GNSS as a whole. Private to block.
#pragma once

#include <vector>

#include "block/bundle/normal_equations.h"

namespace orient::block {

// Positions that share an error of some metres and control that has none are both consistent in
// themselves; weights derived from residuals would then favour the larger group. What is common to
// GNSS is therefore an unknown at first (CommonGnssShift), and is held at zero if it
// is not significant: against its covariance as stated, with what control shares (through
// `as_weighted`) and without the approximations, which may well share an error themselves. It is
// also held if fewer than three control points are used, as none could be found wrong, or
// no majority of the participating photos' positions. Needs converged unknowns. True if it is
// held from now on, so that everything has to be adjusted again.
bool HoldCommonGnssShiftIfInsignificant(const BlockTests& tests, const BlockNormals& as_weighted,
                                        const std::vector<bool>& takes_part, BlockSystem* system);

}  // namespace orient::block
