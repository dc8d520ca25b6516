// How precise a match is when neighbouring pixels have correlated errors.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "core/raster/image.h"

namespace orient::interior {

struct MatchPrecision {
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  // of the shift, px^2
  // What the correlation would be without the image's grain. Residuals three pixels apart (in four
  // directions, the largest counts) tell grain from structure: grain is nearly uncorrelated there
  // if the scanner blurred it by a pixel or less; more strongly blurred grain counts as structure.
  // Meant for pixels near the drawing's strokes: beside them a scratch would count for little.
  double correlation_without_grain = 0;
  double gain_over_sigma = 0;  // its sigma from the residuals' autocovariance, as below
};

// Of an image and a model of it, matched by least squares with offset and gain. `model` is sampled
// at model_from_image + pixel. Grain that went through the scanner's blur is correlated over a few
// pixels, and so is what the drawing does not explain; the residuals' autocovariance c(k) up to
// three pixels enters the shift's covariance as
//   N^-1 (sum over k of c(k) sum over p of g(p) g(p + k)') N^-1,  N = sum of g g'.
// NaN pixels of `image` take no part. Empty where the estimate is not positive definite.
std::optional<MatchPrecision> PrecisionOfMatch(const Image& image, const Image& model,
                                               const Eigen::Vector2d& model_from_image);

// Only the correlation without grain of PrecisionOfMatch, in a fraction of its time; empty also if
// the residuals' sigma exceeds `most_residual`, as what remains is then no grain.
std::optional<double> CorrelationWithoutGrain(const Image& image, const Image& model,
                                              const Eigen::Vector2d& model_from_image,
                                              double most_residual);

// The model explains all but grain: a faint mark, even at a low correlation. On simulated scans
// right marks have 0.75 to 1 without grain; clutter, on bad real and simulated scans, mostly less
// than 0.6 (tools/bench/interior_strokes; tests/interior/bad_scans.cpp).
inline constexpr double kLeastWithoutGrain = 0.75;
// The highest gain of 10^5 places and blurs in grain alone, in its sigmas.
inline constexpr double kHighestGainOfGrain = 4.5;

}  // namespace orient::interior
