#include "core/matching/spot_correlation.h"

#include <algorithm>
#include <cmath>

namespace orient {
namespace {

constexpr int kAtATime = 16;
using Products = Eigen::Array<float, kAtATime, 1>;

double Coefficient(double n, double t, double tt, double i, double ii, double ti) {
  const double var_t = tt - t * t / n, var_i = ii - i * i / n;
  if (!(var_t > 1e-10 * tt) || !(var_i > 1e-6 * ii)) return std::nan("");
  return (ti - t * i / n) / std::sqrt(var_t * var_i);
}

}  // namespace

std::vector<MaskRun> RunsOf(const Image& image) {
  std::vector<MaskRun> runs;
  for (int row = 0; row < image.height; ++row) {
    const float* values = image.Row(row);
    for (int col = 0; col < image.width;) {
      const int first = col;
      while (col < image.width && std::isfinite(values[col])) ++col;
      if (col > first) runs.push_back({row, first, col});
      while (col < image.width && !std::isfinite(values[col])) ++col;
    }
  }
  return runs;
}

SpotTemplate::SpotTemplate(const Image& templ)
    : image_(templ),
      stride_((templ.width + kAtATime - 1) / kAtATime * kAtATime),
      padded_(static_cast<size_t>(stride_) * static_cast<size_t>(templ.height), 0.0f),
      runs_(RunsOf(templ)) {
  for (const MaskRun& run : runs_) {
    for (int col = run.first; col < run.stop; ++col) {
      const float value = templ.At(col, run.row);
      padded_[static_cast<size_t>(run.row) * static_cast<size_t>(stride_) +
              static_cast<size_t>(col)] = value;
      sum_ += static_cast<double>(value);
      squares_ += static_cast<double>(value) * static_cast<double>(value);
    }
    count_ += run.stop - run.first;
  }
}

SpotImage::SpotImage(const Image& image)
    : image_(image),
      padded_(image.values.size() + kAtATime, 0.0f),
      along_(image.values.size() + static_cast<size_t>(image.height)) {
  const bool gaps = std::any_of(image.values.begin(), image.values.end(),
                                [](float value) { return !std::isfinite(value); });
  if (gaps) valid_.resize(along_.size());
  size_t pixel = 0, k = 0;
  for (int row = 0; row < image.height; ++row, ++k) {
    Sums sums;
    int valid = 0;
    for (int col = 0; col < image.width; ++col, ++pixel) {
      const float value = image.values[pixel];
      const bool data = std::isfinite(value);
      padded_[pixel] = data ? value : 0.0f;
      const auto v = static_cast<double>(padded_[pixel]);
      sums.value += v;
      sums.square += v * v;
      along_[++k] = sums;
      if (gaps) valid_[k] = valid += data ? 1 : 0;
    }
  }
}

bool SpotImage::AllValid(const SpotTemplate& templ, int col, int row) const {
  if (valid_.empty()) return true;
  const int line = image_.width + 1;
  return std::all_of(templ.runs_.begin(), templ.runs_.end(), [&](const MaskRun& run) {
    const int* valid = valid_.data() + (row + run.row) * line + col;
    return valid[run.stop] - valid[run.first] == run.stop - run.first;
  });
}

double SpotImage::Correlate(const SpotTemplate& templ, int col, int row, double min_valid) const {
  if (col < 0 || row < 0 || col + templ.Width() > image_.width ||
      row + templ.Height() > image_.height || templ.count_ < 2)
    return std::nan("");
  if (!AllValid(templ, col, row)) return CorrelateValid(templ, col, row, min_valid);
  double i = 0, ii = 0;
  for (const MaskRun& run : templ.runs_) {
    const Sums* sums = along_.data() + (row + run.row) * (image_.width + 1) + col;
    i += sums[run.stop].value - sums[run.first].value;
    ii += sums[run.stop].square - sums[run.first].square;
  }
  Products products = Products::Zero();
  for (int r = 0; r < templ.Height(); ++r) {
    const float* a = templ.padded_.data() + r * templ.stride_;
    const float* b = padded_.data() + (row + r) * image_.width + col;
    for (int c = 0; c < templ.stride_; c += kAtATime)
      products += Eigen::Map<const Products>(a + c) * Eigen::Map<const Products>(b + c);
  }
  return Coefficient(templ.count_, templ.sum_, templ.squares_, i, ii,
                     static_cast<double>(products.sum()));
}

double SpotImage::CorrelateValid(const SpotTemplate& templ, int col, int row,
                                 double min_valid) const {
  double n = 0, t = 0, tt = 0, i = 0, ii = 0, ti = 0;
  for (const MaskRun& run : templ.runs_) {
    for (int c = run.first; c < run.stop; ++c) {
      const auto y = static_cast<double>(image_.At(col + c, row + run.row));
      if (!std::isfinite(y)) continue;
      const auto x = static_cast<double>(templ.image_.At(c, run.row));
      n += 1;
      t += x;
      tt += x * x;
      i += y;
      ii += y * y;
      ti += x * y;
    }
  }
  if (n < std::max(2.0, min_valid * templ.count_)) return std::nan("");
  return Coefficient(n, t, tt, i, ii, ti);
}

}  // namespace orient
