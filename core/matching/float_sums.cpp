#include "core/matching/float_sums.h"

#include <algorithm>
#include <vector>

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace orient {

using Eigen::Index;

namespace {

// `kCount` sums, with what every processor has.
template <Index kCount>
void SumUp(const FloatPlane& kernel, const FloatPlane& image, Index row, Index col, float* sums) {
  using Some = Eigen::Array<float, kCount, 1>;
  Some some = Some::Zero();
  for (Index i = 0; i < kernel.rows(); ++i) {
    const float* line = &image(row + i, col);
    const float* weight = &kernel(i, 0);
    for (Index j = 0; j < kernel.cols(); ++j) some += weight[j] * Eigen::Map<const Some>(line + j);
  }
  Eigen::Map<Some>(sums, kCount) = some;
}

#if defined(__x86_64__)

// The same in registers twice as wide; without fused operations, which would round otherwise.
template <Index kCount>
__attribute__((target("avx2"))) void SumUpWide(const FloatPlane& kernel, const FloatPlane& image,
                                               Index row, Index col, float* sums) {
  constexpr Index kLanes = 8, kRegisters = kCount / kLanes;
  __m256 some[kRegisters];
  for (Index k = 0; k < kRegisters; ++k) some[k] = _mm256_setzero_ps();
  for (Index i = 0; i < kernel.rows(); ++i) {
    const float* line = image.data() + (row + i) * image.cols() + col;
    const float* weights = kernel.data() + i * kernel.cols();
    for (Index j = 0; j < kernel.cols(); ++j, ++line) {
      const __m256 weight = _mm256_set1_ps(weights[j]);
      for (Index k = 0; k < kRegisters; ++k)
        some[k] = _mm256_add_ps(some[k], _mm256_mul_ps(weight, _mm256_loadu_ps(line + kLanes * k)));
    }
  }
  for (Index k = 0; k < kRegisters; ++k) _mm256_storeu_ps(sums + kLanes * k, some[k]);
}

bool HasWideRegisters() {
  static const bool has = __builtin_cpu_supports("avx2") != 0;
  return has;
}

#endif

// `kCount` sums, as fast as this processor makes them.
template <Index kCount>
void SumUpFast(const FloatPlane& kernel, const FloatPlane& image, Index row, Index col,
               float* sums) {
#if defined(__x86_64__)
  if (HasWideRegisters()) return SumUpWide<kCount>(kernel, image, row, col, sums);
#endif
  constexpr Index kFit = std::min<Index>(kCount, 32);  // in narrow registers
  for (Index k = 0; k < kCount; k += kFit) SumUp<kFit>(kernel, image, row, col + k, sums + k);
}

}  // namespace

void SumProducts(const FloatPlane& kernel, const FloatPlane& image, Index row, Index col,
                 Index count, float* sums) {
  float all[kFloatSumsAtOnce];
  // Few remain at the end of a row.
  if (count > kFloatSumsAtOnce / 2)
    SumUpFast<kFloatSumsAtOnce>(kernel, image, row, col, all);
  else if (count > kFloatSumsAtOnce / 4)
    SumUpFast<kFloatSumsAtOnce / 2>(kernel, image, row, col, all);
  else
    SumUpFast<kFloatSumsAtOnce / 4>(kernel, image, row, col, all);
  std::copy_n(all, count, sums);
}

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
