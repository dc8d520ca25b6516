// Sums of a kernel's products with every part of an image: the bricks of correlation, in space or
// by FFT. Internal to core/imaging.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "core/matching/spot_correlation.h"

namespace orient {

using Plane = Eigen::Array<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// result(r, c) = sum over i, j of kernel(i, j) * image(r + i, c + j), wherever the kernel lies
// inside; the kernel is not larger than the image.
class ProductSums {
 public:
  virtual ~ProductSums() = default;
  virtual Plane Sum(const Plane& kernel, const Plane& image) = 0;
};

// Multiplies pixel by pixel, in single precision.
class SpatialSums : public ProductSums {
 public:
  Plane Sum(const Plane& kernel, const Plane& image) override;
};

// Through spectra of overlapping blocks, which stay in the processor's cache; each block of each
// plane is transformed once, however many sums it takes part in. The planes are recognised by their
// address: they must stay as they are while this lives.
class FftSums : public ProductSums {
 public:
  FftSums(const Eigen::Vector2i& kernel_size, const Eigen::Vector2i& image_size);  // width, height
  ~FftSums() override;
  Plane Sum(const Plane& kernel, const Plane& image) override;

 private:
  struct Spectra;
  std::unique_ptr<Spectra> spectra_;
};

// Kernel of ones, by running sums.
Plane BoxSums(const Plane& image, Eigen::Index kernel_rows, Eigen::Index kernel_cols);

// Of every pixel's row all that lies before it; one column more than the plane has.
Plane SumsBefore(const Plane& plane);

// Kernel of ones and zeros, given by its runs of ones, by sums along the image's rows.
Plane RunSums(const Plane& image, Eigen::Index kernel_rows, Eigen::Index kernel_cols,
              const std::vector<MaskRun>& runs);

// Estimated run time in arbitrary equal units of one sum.
double SpatialCost(const Eigen::Vector2i& templ_size, const Eigen::Vector2i& image_size);
double FftCost(const Eigen::Vector2i& templ_size, const Eigen::Vector2i& image_size);

}  // namespace orient
