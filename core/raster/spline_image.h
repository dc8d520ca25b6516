// Interpolating cubic B-spline through a part of an image (Unser 1999). Internal to core/imaging.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/raster/image.h"
#include "core/raster/raster.h"

namespace orient {

// Far closer to the ideal interpolation than a local cubic: a match does not lean towards whole
// or half pixels. Positions are pixels of the whole image.
class SplineImage {
 public:
  // Of `part` of the image, which is clipped to it. Beyond the part nothing can be sampled; within
  // about six pixels of a border that is not the image's own the surface is not quite exact.
  SplineImage(const Image& image, const PixelWindow& part);

  // Value and gradient at a position between the part's pixel centres; false outside and where one
  // of the 4 x 4 pixels around it is NaN.
  bool Sample(const Eigen::Vector2d& pixel, double* value, Eigen::Vector2d* gradient) const;

 private:
  void FillGaps();
  void MarkSupport();

  int col_ = 0, row_ = 0, width_ = 0, height_ = 0;
  std::vector<double> coefficients_;
  std::vector<char> valid_;  // of the cell to the lower right of each pixel centre
};

}  // namespace orient
