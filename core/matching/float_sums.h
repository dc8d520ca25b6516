// Sums of products in single precision, as fast as the processor multiplies: the inner loop of
// correlating and blurring.
#pragma once

#include <Eigen/Core>

namespace orient {

using FloatPlane = Eigen::Array<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// The most sums that are made at once: as many as fit into the processor's registers.
inline constexpr Eigen::Index kFloatSumsAtOnce = 64;

// sums[0 .. count - 1]: the sums at (row, col) and the next places of the row, at most
// kFloatSumsAtOnce. The image must reach as far as if all of these were wanted. Each is made in
// the order of the kernel's rows, whatever the width of the registers: bit by bit the same.
void SumProducts(const FloatPlane& kernel, const FloatPlane& image, Eigen::Index row,
                 Eigen::Index col, Eigen::Index count, float* sums);

// result(r, c) = sum over i, j of kernel(i, j) * image(r + i, c + j), wherever the kernel lies
// inside; the kernel is not larger than the image.
FloatPlane FloatSums(const FloatPlane& kernel, const FloatPlane& image);

// The same with a row and then a column of weights, of a plane with zeros beyond its border: the
// result is as large as the plane. `weights` are odd in number, the middle one belongs to the pixel
// itself.
FloatPlane SeparableSums(const FloatPlane& plane, const Eigen::ArrayXf& weights);

}  // namespace orient
