// What makes a patch worth seeking: texture, only one place it fits, texture that survives the
// pyramid, and evidence that it lies where it says. Measured on grey values and heights; one number
// of them all.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "core/raster/image.h"
#include "patchdb/store/patch.h"

namespace orient::patchdb {

// Standard deviation of the grey values, over the pixels that have one.
double Contrast(const Image& image);

// Standard deviation of white noise, from what no smooth surface and no straight edge along the
// axes leaves (Immerkaer 1996, Fast noise variance estimation); fine texture adds to it. NaN pixels
// and their neighbours take no part.
double NoiseOf(const Image& image);

// The second peak of the autocorrelation.
struct SecondPeak {
  double score = 0;  // 0: there is none
  std::optional<double>
      distance_px;  // pixels of the image at full resolution; empty: there is none
  double Distinctness() const { return 1 - std::min(std::max(score, 0.0), 1.0); }
};

// The middle of `surroundings`, `template_px` a side, is correlated over all of it; the main peak
// and its flanks within 4 px do not count. Scores are relative to what the middle itself would get
// in another exposure: noise makes no place distinct. Empty where the middle is flat or incomplete.
std::optional<SecondPeak> FindSecondPeak(const Image& surroundings, int template_px);

// Pyramid levels, counted from full resolution, at which a copy of the chip that is shifted by half
// a pixel and noisy is still found within half a pixel. Noise: a tenth of the chip's contrast, at
// least one grey level; the same numbers every time. At most 3 for a chip of 61 px.
int Persistence(const Image& chip);

// Mean squared gradient by direction: xx, xy, yy per pixel, x to the east and y to the north. NaN
// pixels and their neighbours take no part.
Eigen::Vector3d TextureEnergy(const Image& chip);

// 0 .. 1, the lowest of the scores for all that is known about the patch; 0.5 is the least
// that is good. docs/patchdb.md has the table. Empty where nothing was measured.
std::optional<double> QualityOf(const Patch& patch);
inline constexpr double kGoodQuality = 0.5;

}  // namespace orient::patchdb
