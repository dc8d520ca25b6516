// Resampling of images at arbitrary places, and pyramids.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "core/raster/image.h"

namespace orient {

// Value at a pixel position (corner convention), NaN within half a pixel of the border, outside, or
// where a contributing pixel is NaN.
float SampleBilinear(const Image& image, const Eigen::Vector2d& pixel);
// Catmull-Rom cubic; falls back to bilinear in the outermost pixel ring.
float SampleBicubic(const Image& image, const Eigen::Vector2d& pixel);

// Value and gradient (per pixel in col and row) of the bicubic surface. False where it is NaN.
bool SampleBicubicWithGradient(const Image& image, const Eigen::Vector2d& pixel, float* value,
                               Eigen::Vector2f* gradient);

// The part of that size around the middle (half a pixel to the upper left of it where the
// difference in size is odd). Not larger than the image.
Image MiddleOf(const Image& image, int width, int height);

// Columns from right to left.
Image Mirrored(Image image);

// Gaussian blur, NaN-aware (normalised convolution; NaN pixels stay NaN).
Image GaussianBlur(const Image& image, double sigma_px);

// Half the size (rounded up): 2x2 means after the slight blur that keeps aliasing away. In the
// corner convention coarse = fine / 2 exactly. NaN-aware: a coarse pixel is NaN where at least half
// of its pixels are.
Image ReduceByTwo(const Image& image);

// levels[0] is the image itself.
std::vector<Image> BuildPyramid(const Image& image, int levels);

// `factor` pixels for each, per axis, on a cubic through their values (corner convention: fine =
// factor * image), which departs from a straight slope by up to 0.04 of a step between pixels. NaN
// where a contributing pixel is NaN.
Image EnlargeBy(const Image& image, int factor);

// Area-averaged reduction by any factor >= 1 (corner convention: coarse = fine / factor).
Image ReduceBy(const Image& image, double factor);

}  // namespace orient
