// Normalised cross-correlation of a template over an image, and the peaks of the result.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/raster/image.h"

namespace orient {

// NCC coefficients in [-1, 1] of a masked template (NaN = not part of the template) at every
// position where it lies inside the image. result(c, r) is for the template's (0, 0) corner at the
// image's (c, r) corner; its size is (iw - tw + 1) x (ih - th + 1), empty where the template is
// larger. NaN where less than `min_valid` of the template's pixels meet valid image pixels, or one
// side is flat. Spatial or by FFT, whichever is cheaper; both give the same to 1e-4.
Image Correlate(const Image& templ, const Image& image, double min_valid = 0.75);
Image CorrelateSpatial(const Image& templ, const Image& image, double min_valid = 0.75);
Image CorrelateFft(const Image& templ, const Image& image, double min_valid = 0.75);

// One coefficient of two images of equal size, over pixels valid in both. NaN: flat or too few.
double CorrelationCoefficient(const Image& a, const Image& b, double min_valid = 0.75);

struct Peak {
  Eigen::Vector2d position;  // continuous: the peak of cell (c, r) is near (c, r), NOT (c+.5, r+.5)
  double score = 0;
};

// Up to `max_count` local maxima (8-neighbourhood), best first, at least `min_distance` cells
// apart, score >= min_score, refined by a parabola in both directions.
std::vector<Peak> FindPeaks(const Image& scores, int max_count, double min_distance,
                            double min_score);

}  // namespace orient
