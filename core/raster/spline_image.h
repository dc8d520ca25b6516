// Interpolating cubic B-spline through a part of an image (Unser 1999).
#pragma once

#include <Eigen/Core>

#include "core/raster/image.h"

namespace orient {

// At places a pixel apart, one row of them after the other; zero where nothing is known.
struct SplineSamples {
  Eigen::ArrayXd value, by_col, by_row;  // the latter: gradient, per pixel
  Eigen::ArrayXd known;                  // 1 or 0
};

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

  // The same at `first`, the places right of it and those below, many times as fast.
  SplineSamples SampleGrid(const Eigen::Vector2d& first, int cols, int rows) const;

 private:
  using Grid = Eigen::Array<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  static void FilterDown(Grid* samples);
  static void FillGaps(Grid* samples);
  void MarkSupport(const Grid& samples);

  int col_ = 0, row_ = 0, width_ = 0, height_ = 0;
  Grid coefficients_;
  Grid valid_;  // 1 or 0, of the cell to the lower right of each pixel centre
};

}  // namespace orient
