// What values of a patch say anything of where it is.
#pragma once

namespace orient::patchdb {

// Of its position and heights. Surveyed points whose height is not known have several kilometres.
inline constexpr double kGreatestPatchSigma_m = 1e4;

}  // namespace orient::patchdb
