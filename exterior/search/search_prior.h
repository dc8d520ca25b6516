// Which photos need a search of the whole photo, and what such a search allows for.
#pragma once

#include <numbers>
#include <vector>

#include "core/geometry/camera.h"
#include "core/geometry/resection.h"

namespace orient::exterior {

// Usual tilt of aerial photos, one sigma.
inline constexpr double kUsualTilt_rad = 5 * std::numbers::pi / 180;

// Whether the prior is too poor for search windows around the patches: kappa is open, or the
// patches may lie anywhere in the frame. Such a photo needs OrientPhotoOptions::wide.
bool IsVague(const Camera& camera, const PosePrior& prior, double ground_height_m);

// Whether the prior's position is good enough for patches to look nearly as seen from there, so
// that no other flying height need be tried. `ground_height_m`: MedianGroundHeight of the patches.
bool IsPositionKnown(const PosePrior& prior, double ground_height_m);

// Approximations are often worse than stated: sigmas are doubled, and the position's increased by a
// few per cent of the flying height, the size of errors from a map or a forgotten datum shift.
PosePrior Doubtful(const PosePrior& prior, double ground_height_m);

// What a wide search allows for, whatever the prior claims: any kappa, a position wrong by a third
// of the flying height, and no more tilt than aerial photos have.
PosePrior Widened(const PosePrior& prior, double ground_height_m);

// Flying heights to try if the stated one is uncertain, as factors of it, outwards from 1; at least
// one step to each side even if it is stated as known.
inline constexpr double kHeightStep = 1.2;
std::vector<double> HeightFactors(const PosePrior& prior, double ground_height_m);

// The prior with kappa in one sector each: its own first; then, of those that its accuracy (three
// sigma) allows, outwards; of all, the opposite one (a strip flown the other way), those at right
// angles, and the others outwards. Kappa may be anywhere in its sector, unless it is known better.
inline constexpr int kKappaSectors = 16;
std::vector<PosePrior> KappaSectors(const PosePrior& prior, bool all);

}  // namespace orient::exterior
