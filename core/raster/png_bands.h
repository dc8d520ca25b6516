// PNGs in memory with their bands apart: colour chips, which Raster's grey would lose.
#pragma once

#include <vector>

#include "core/raster/image.h"

namespace orient {

// One band (grey) or three (red, green, blue) of one size, 8 or 16 bit. Values are rounded to whole
// numbers and clamped to 0 .. 2^bits - 1; NaN becomes 0.
std::vector<unsigned char> EncodePngBands(const std::vector<Image>& bands, int bits);

// One band or three; a palette, transparency or interlacing is not taken. Throws InputError for
// anything that is not such a PNG of at most 4096 x 4096 pixels.
std::vector<Image> DecodePngBands(const std::vector<unsigned char>& png);

// 0.299 R + 0.587 G + 0.114 B, as Raster makes grey of colour; the band itself where it is the only
// one.
Image GreyOfBands(std::vector<Image> bands);

}  // namespace orient
