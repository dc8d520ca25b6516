// Slow changes of brightness: fogged edges, the gradient towards a dark corner.
#pragma once

#include "core/raster/image.h"

namespace orient::interior {

// Wide enough to leave every stroke alone, narrow enough to follow a dark corner's edge.
inline constexpr double kBackgroundSigmaMm = 0.6;

// Takes them away: value minus the Gaussian mean around it, in which NaN takes no part. NaN stays
// NaN. The mean is formed from block averages a third of sigma wide, which costs a hundredth of the
// full convolution and departs from it by 0.2 to 0.4 % of the image's spread (root mean square;
// 0.9 % in a mark's own pixels alone, at most 1 to 2 % inside and 6 % beside the image's border). A
// drawing and the scan it is compared with have the blocks in common, and the same departure.
Image RemoveBackground(const Image& image, double sigma_px);

}  // namespace orient::interior
