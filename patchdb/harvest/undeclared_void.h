// Areas without data that a file does not declare: filled with black or white, where a mosaic or a
// mask ends. Grey values tell: in a picture of the ground no area is of exactly one value, but for
// saturated roofs and dark water, whose edges are blurred as all others are.
#pragma once

#include <cstdint>
#include <vector>

#include "core/raster/image.h"

namespace orient::patchdb {

// How far around a pixel an image must reach for its void to be found, px.
inline constexpr int kVoidReach_px = 80;

// 1 for pixels of voids, row by row. A void is connected, has a square of exactly one value at or
// within a few grey values of an end of the range (0, or the greatest of `bits`), and has edges as
// sharp as no lens draws them, or 40,000 px. To it belongs what compression makes of its border. In
// declared nodata, and so beyond a raster, it may go on. None below 8 bits.
std::vector<std::uint8_t> UndeclaredVoids(const Image& grey, int bits);

// Share of the pixels whose values allow them to be void: this alone settles nearly all images.
double ShareNearEnds(const Image& grey, int bits);

}  // namespace orient::patchdb
