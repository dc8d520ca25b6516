// How precise a match is when neighbouring pixels have correlated errors.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "core/raster/image.h"

namespace orient::interior {

// Covariance (px^2) of the shift between an image and a model of it, matched by least squares with
// offset and gain. `model` is sampled at model_from_image + pixel. Grain that went through the
// scanner's blur is correlated over a few pixels, and so is what the drawing does not explain; the
// residuals' autocovariance c(k) up to three pixels enters as
//   N^-1 (sum over k of c(k) sum over p of g(p) g(p + k)') N^-1,  N = sum of g g'.
// NaN pixels of `image` take no part. Empty where the estimate is not positive definite.
std::optional<Eigen::Matrix2d> ShiftCovariance(const Image& image, const Image& model,
                                               const Eigen::Vector2d& model_from_image);

}  // namespace orient::interior
