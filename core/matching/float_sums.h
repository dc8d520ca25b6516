// Sums of products in single precision, as fast as the processor multiplies: the inner loop of
// correlating and blurring.
#pragma once

#include <Eigen/Core>

namespace orient {

using FloatPlane = Eigen::Array<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// As many sums as fit into the processor's registers; half as many for a short rest of a row.
inline constexpr Eigen::Index kFloatSumsAtOnce = 32;

// sums[0 .. count - 1]: the sums at (row, col) and the next places of the row, at most
// kFloatSumsAtOnce. The image reaches as far as all of these.
inline void SumProducts(const FloatPlane& kernel, const FloatPlane& image, Eigen::Index row,
                        Eigen::Index col, Eigen::Index count, float* sums) {
  const auto sum_up = [&](auto some) {
    some.setZero();
    for (Eigen::Index i = 0; i < kernel.rows(); ++i) {
      const float* line = &image(row + i, col);
      const float* weight = &kernel(i, 0);
      for (Eigen::Index j = 0; j < kernel.cols(); ++j)
        some += weight[j] * Eigen::Map<const decltype(some)>(line + j);
    }
    Eigen::Map<Eigen::ArrayXf>(sums, count) = some.head(count);
  };
  if (2 * count > kFloatSumsAtOnce)
    sum_up(Eigen::Array<float, kFloatSumsAtOnce, 1>());
  else
    sum_up(Eigen::Array<float, kFloatSumsAtOnce / 2, 1>());
}

// result(r, c) = sum over i, j of kernel(i, j) * image(r + i, c + j), wherever the kernel lies
// inside; the kernel is not larger than the image.
FloatPlane FloatSums(const FloatPlane& kernel, const FloatPlane& image);

// The same with a row and then a column of weights, of a plane with zeros beyond its border: the
// result is as large as the plane. `weights` are odd in number, the middle one belongs to the pixel
// itself.
FloatPlane SeparableSums(const FloatPlane& plane, const Eigen::ArrayXf& weights);

}  // namespace orient
