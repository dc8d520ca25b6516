// Slow changes of brightness: fogged edges, the gradient towards a dark corner.
#pragma once

#include "core/imaging/image.h"

namespace orient {

// Wide enough to leave every stroke alone, narrow enough to follow a dark corner's edge.
inline constexpr double kBackgroundSigmaMm = 0.6;

// Takes them away: value minus the Gaussian mean around it, in which NaN takes no part. NaN stays
// NaN. The mean is formed from block averages a third of sigma wide, which equals the full
// convolution to 1e-3 of the image's spread and costs a hundredth.
Image RemoveBackground(const Image& image, double sigma_px);

}  // namespace orient
