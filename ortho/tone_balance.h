// Photos of different exposure, development and haze in one tone.
#pragma once

#include <vector>

#include "ortho/mosaic_cells.h"
#include "ortho/mosaic_part.h"

namespace orient::ortho {

struct BalancedTones {
  std::vector<std::vector<Tone>> tones;  // of each photo, of each of its bands
  // Median difference of two photos' cells where they overlap, grey values; 0 without overlaps.
  double before = 0, after = 0;
};

// A gain and an offset for each photo and band, by which the same ground has the same grey value in
// the photos that show it: least squares over the cells of all overlaps at once, those that have
// changed (cars, shadows, water) not counted (Tukey's weights), a photo whose overlaps say little
// of its tone held by its own. The mean of the gains is 1, and the mean of all photos stays. Bands
// are independent.
BalancedTones BalanceTones(const std::vector<PhotoCells>& photos);

}  // namespace orient::ortho
