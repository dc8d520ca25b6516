#include "core/imaging/float_sums.h"

namespace orient {

using Eigen::Index;

FloatPlane FloatSums(const FloatPlane& kernel, const FloatPlane& image) {
  const Index rows = image.rows() - kernel.rows() + 1, cols = image.cols() - kernel.cols() + 1;
  // The last ones of a row reach beyond it.
  FloatPlane padded = FloatPlane::Zero(image.rows(), image.cols() + kFloatSumsAtOnce);
  padded.leftCols(image.cols()) = image;
  FloatPlane result(rows, cols);
  for (Index row = 0; row < rows; ++row) {
    for (Index col = 0; col < cols; col += kFloatSumsAtOnce) {
      const Index n = std::min(kFloatSumsAtOnce, cols - col);
      result.row(row).segment(col, n) = SumProducts(kernel, padded, row, col).head(n).transpose();
    }
  }
  return result;
}

FloatPlane SeparableSums(const FloatPlane& plane, const Eigen::ArrayXf& weights) {
  const Index reach = weights.size() / 2;
  FloatPlane padded = FloatPlane::Zero(plane.rows() + 2 * reach, plane.cols() + 2 * reach);
  padded.block(reach, reach, plane.rows(), plane.cols()) = plane;
  return FloatSums(weights, FloatSums(weights.transpose(), padded));
}

}  // namespace orient
