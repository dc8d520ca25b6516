// Interest points after Foerstner & Guelch (1987): corners, crossings and round spots.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/raster/image.h"

namespace orient {

struct InterestPoint {
  // Corner convention, subpixel: where the window's edges meet, or the middle of a round spot.
  Eigen::Vector2d pixel;
  double weight = 0;           // det N / tr N: inverse of the mean point variance
  double roundness = 0;        // q = 4 det N / tr^2 N, in [0, 1]
  Eigen::Matrix2d covariance;  // px^2 for unit grey-value noise: inverse of N
};

struct InterestOptions {
  double min_weight_ratio = 0.5;  // of the median weight over the image
  double min_distance_px = 5;
};

// Best first by weight. NaN regions and their neighbourhood give no points.
std::vector<InterestPoint> FindInterestPoints(const Image& image,
                                              const InterestOptions& options = {});

}  // namespace orient
