#include "core/matching/float_sums.h"

#include <algorithm>
#include <vector>

namespace orient {

using Eigen::Index;

FloatPlane FloatSums(const FloatPlane& kernel, const FloatPlane& image) {
  const Index rows = image.rows() - kernel.rows() + 1, cols = image.cols() - kernel.cols() + 1;
  // The last sums of a row read beyond its end.
  FloatPlane padded = FloatPlane::Zero(image.rows(), image.cols() + kFloatSumsAtOnce);
  padded.leftCols(image.cols()) = image;
  FloatPlane result(rows, cols);
  for (Index row = 0; row < rows; ++row) {
    for (Index col = 0; col < cols; col += kFloatSumsAtOnce) {
      const Index n = std::min(kFloatSumsAtOnce, cols - col);
      SumProducts(kernel, padded, row, col, n, &result(row, col));
    }
  }
  return result;
}

namespace {

// out[i] = sum over k of weights[k] * lines[k][i]
void SumOfLines(const Eigen::ArrayXf& weights, const std::vector<const float*>& lines, Index count,
                float* out) {
  constexpr Index kAtOnce = 16;
  using Few = Eigen::Array<float, kAtOnce / 4, 1>;
  const float* weight = weights.data();
  const Index terms = weights.size();
  if (count < kAtOnce) {
    for (Index i = 0; i < count; ++i) {
      out[i] = 0;
      for (Index k = 0; k < terms; ++k) out[i] += weight[k] * lines[static_cast<size_t>(k)][i];
    }
    return;
  }
  for (Index i = 0; i < count; i += kAtOnce) {
    const Index at = std::min(i, count - kAtOnce);  // the last group overlaps the one before
    Few a = Few::Zero(), b = a, c = a, d = a;
    for (Index k = 0; k < terms; ++k) {
      const float* line = lines[static_cast<size_t>(k)] + at;
      const Few w = Few::Constant(weight[k]);
      a += w * Eigen::Map<const Few>(line);
      b += w * Eigen::Map<const Few>(line + 4);
      c += w * Eigen::Map<const Few>(line + 8);
      d += w * Eigen::Map<const Few>(line + 12);
    }
    Eigen::Map<Few>(out + at) = a;
    Eigen::Map<Few>(out + at + 4) = b;
    Eigen::Map<Few>(out + at + 8) = c;
    Eigen::Map<Few>(out + at + 12) = d;
  }
}

}  // namespace

FloatPlane SeparableSums(const FloatPlane& plane, const Eigen::ArrayXf& weights) {
  const Index reach = weights.size() / 2, rows = plane.rows(), cols = plane.cols();
  const std::vector<float> zeros(static_cast<size_t>(cols));
  std::vector<float> padded(static_cast<size_t>(cols + 2 * reach));  // a row's sums down
  std::vector<const float*> across, down(static_cast<size_t>(weights.size()));
  for (Index k = 0; k < weights.size(); ++k) across.push_back(padded.data() + k);
  FloatPlane result(rows, cols);
  for (Index row = 0; row < rows; ++row) {
    for (Index k = 0; k < weights.size(); ++k) {
      const Index from = row + k - reach;
      down[static_cast<size_t>(k)] = from >= 0 && from < rows ? &plane(from, 0) : zeros.data();
    }
    SumOfLines(weights, down, cols, padded.data() + reach);
    SumOfLines(weights, across, cols, &result(row, 0));
  }
  return result;
}

}  // namespace orient
