// Photos of different exposure, development and haze in one tone.
#pragma once

#include <optional>
#include <vector>

#include "ortho/mosaic_cells.h"
#include "ortho/mosaic_part.h"

namespace orient::ortho {

struct BalancedTones {
  std::vector<std::vector<Tone>> tones;  // of each photo, of each of its bands
  // Median difference of two photos' cells where they overlap, the mean of all overlaps, grey
  // values; empty without overlaps.
  std::optional<double> before, after;
  bool would_worsen = false;  // then all photos keep their own tones, and after is before
  std::vector<int> alone;     // photos that no other overlaps: they stay as they are
  std::vector<int> bounded;   // photos whose gain in some band would be below 0.4 or above 2.5
};

// A gain and an offset for each photo and band, by which the same ground has the same grey value in
// the photos that show it. Each overlap says how the spreads and the means of its two photos
// differ, without the cells that have changed (cars, shadows, water); of all overlaps at once
// follow the gains and then the offsets, robustly (Huber), so that one overlap that has changed
// altogether does not count for much. From spreads, since a regression takes noise for a lack of
// contrast; as much noise as contrast still costs 30 % of it.
// Photos are held by their own tones a thousandth as firmly as by their overlaps. Bands are
// independent. Tones that would bring overlaps no closer are not taken.
BalancedTones BalanceTones(const std::vector<PhotoCells>& photos);

// The cells as the tones show them.
void ShowInTones(const std::vector<std::vector<Tone>>& tones, std::vector<PhotoCells>* photos);

}  // namespace orient::ortho
