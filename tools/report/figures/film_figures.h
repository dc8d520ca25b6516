// How film lies against its calibrated marks: mean and spread over the photos of a roll.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/files/results.h"

namespace orient {

struct MeanAndSpread {
  double mean = 0;
  std::optional<double> spread = {};  // standard deviation; empty: of one value
};
// Empty without values.
std::optional<MeanAndSpread> MeanAndSpreadOf(const std::vector<double>& values);

// Photos of one camera, scanned with one pixel size: only these have a mean.
struct FilmRoll {
  std::vector<std::string> cameras;  // its name in the camera library, where it was found there
  std::string first, last;           // photos
  int photos = 0, marks = 0, marks_used = 0;
  MeanAndSpread column_um, row_um;              // side of a pixel in the photo system
  MeanAndSpread difference_ppm, shear_urad;     // of the two scales; of the two axes
  std::optional<MeanAndSpread> sigma0_um = {};  // of a mark's coordinate
};

// In the order of the photos, of those with a film transform; null pointers are left out.
std::vector<FilmRoll> FilmRolls(const std::vector<const InteriorResult*>& photos);

}  // namespace orient
