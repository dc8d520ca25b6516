// What makes a patch worth seeking: texture, only one place it fits, texture that survives the
// pyramid. Measured on grey values alone.
#pragma once

#include <optional>

#include "core/imaging/image.h"

namespace orient {

// Standard deviation of the grey values, over the pixels that have one.
double Contrast(const Image& image);

// 1 - height of the second peak of the autocorrelation: the middle of `surroundings`, `template_px`
// a side, is correlated over all of it; the main peak and its flanks within 4 px do not count.
// 1 means alone, 0 that an equal place lies near. Empty where the middle is flat or incomplete.
std::optional<double> Distinctness(const Image& surroundings, int template_px);

// Pyramid levels, counted from full resolution, at which a copy of the chip that is shifted by half
// a pixel and noisy is still found within half a pixel. Noise: a tenth of the chip's contrast, at
// least one grey level; the same numbers every time. At most 3 for a chip of 61 px.
int Persistence(const Image& chip);

}  // namespace orient
