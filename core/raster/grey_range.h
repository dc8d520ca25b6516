// The grey values between which a picture is stretched from black to white.
#pragma once

#include <utility>

#include "core/raster/image.h"

namespace orient {

// Darkest and brightest hundredth, so that a speck of dust does not flatten what is faint: equal
// for an even image, 0 and 0 for one without data.
std::pair<float, float> GreyRange(const Image& image);

}  // namespace orient
