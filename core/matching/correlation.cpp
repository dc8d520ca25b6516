#include "core/matching/correlation.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "core/matching/correlation_sums.h"

namespace orient {
namespace {

using Eigen::Index;

// A window whose variance is below this part of the whole image's sum of squares is flat: below it
// the rounding of the sums dominates.
constexpr double kFlat = 1e-10;

// An image less its mean, zero where there is no data, with all that is summed over.
struct Side {
  Plane value, square, mask;  // the mask is empty where all is data
  std::vector<MaskRun> runs;  // of the pixels with data; empty likewise
  bool full = true;
  double count = 0;  // valid pixels
  double sum = 0;    // of the values, nearly zero
  double energy = 0;

  explicit Side(const Image& image) : value(image.height, image.width) {
    double total = 0;
    for (const float v : image.values) {
      if (!std::isfinite(v)) continue;
      total += double(v);
      ++count;
    }
    full = count == static_cast<double>(image.values.size());
    if (!full) {
      mask.resize(image.height, image.width);
      runs = RunsOf(image);
    }
    const double mean = count > 0 ? total / count : 0;
    for (size_t i = 0; i < image.values.size(); ++i) {
      const bool valid = std::isfinite(image.values[i]);
      value.data()[i] = valid ? double(image.values[i]) - mean : 0;
      if (!full) mask.data()[i] = valid ? 1 : 0;
    }
    square = value.square();
    sum = value.sum();
    energy = square.sum();
  }
};

// Over the pixels valid on both sides, at every place: count, template and its square, image and
// its square, product.
struct Sums {
  double n = 0, t = 0, tt = 0, i = 0, ii = 0, ti = 0;
};

class SumsEverywhere {
 public:
  SumsEverywhere(const Side& t, const Side& i, ProductSums* by) : t_(t), i_(i) {
    const auto over_template = [&t](const Plane& plane) {
      return t.full ? BoxSums(plane, t.value.rows(), t.value.cols())
                    : RunSums(plane, t.value.rows(), t.value.cols(), t.runs);
    };
    ti_ = by->Sum(t.value, i.value);
    value_ = over_template(i.value);
    square_ = over_template(i.square);
    if (i.full) return;
    count_ = over_template(i.mask).round();
    before_ = SumsBefore(t.value);
    squares_before_ = SumsBefore(t.square);
    rows_of_image_.resize(static_cast<size_t>(i.value.rows()));
    for (const MaskRun& run : i.runs) rows_of_image_[static_cast<size_t>(run.row)].push_back(run);
  }

  // Number of template pixels that fall on data.
  double Count(Index row, Index col) const { return i_.full ? t_.count : count_(row, col); }

  Sums At(Index row, Index col) const {
    Sums s{Count(row, col), t_.sum, t_.energy, value_(row, col), square_(row, col), ti_(row, col)};
    if (s.n == t_.count) return s;
    // Only the template's pixels that fall on data.
    s.t = s.tt = 0;
    for (Index r = 0; r < t_.value.rows(); ++r) {
      for (const MaskRun& run : rows_of_image_[static_cast<size_t>(row + r)]) {
        const Index first = std::clamp<Index>(run.first - col, 0, t_.value.cols());
        const Index stop = std::clamp<Index>(run.stop - col, 0, t_.value.cols());
        s.t += before_(r, stop) - before_(r, first);
        s.tt += squares_before_(r, stop) - squares_before_(r, first);
      }
    }
    return s;
  }

 private:
  const Side& t_;
  const Side& i_;
  Plane count_, value_, square_, ti_;
  // If the image has gaps: running sums along the template's rows, and runs of data by image row.
  Plane before_, squares_before_;
  std::vector<std::vector<MaskRun>> rows_of_image_;
};

Image CorrelateBy(const Image& templ, const Image& image, double min_valid, bool spatial) {
  if (templ.Empty() || templ.width > image.width || templ.height > image.height) return {};
  const Side t(templ), i(image);
  Image result(image.width - templ.width + 1, image.height - templ.height + 1, kNoData);
  const double needed = std::max(2.0, min_valid * t.count);
  if (t.count < 2 || t.energy <= 0 || i.energy <= 0) return result;
  SpatialSums in_space;
  FftSums by_fft({templ.width, templ.height}, {image.width, image.height});
  const SumsEverywhere sums(t, i, spatial ? static_cast<ProductSums*>(&in_space) : &by_fft);
  for (int row = 0; row < result.height; ++row) {
    for (int col = 0; col < result.width; ++col) {
      if (sums.Count(row, col) < needed) continue;
      const Sums s = sums.At(row, col);
      const double var_t = s.tt - s.t * s.t / s.n, var_i = s.ii - s.i * s.i / s.n;
      if (var_t <= kFlat * t.energy || var_i <= kFlat * i.energy) continue;
      const double ncc = (s.ti - s.t * s.i / s.n) / std::sqrt(var_t * var_i);
      result.At(col, row) = static_cast<float>(std::clamp(ncc, -1.0, 1.0));
    }
  }
  return result;
}

}  // namespace

Image CorrelateSpatial(const Image& templ, const Image& image, double min_valid) {
  return CorrelateBy(templ, image, min_valid, true);
}

Image CorrelateFft(const Image& templ, const Image& image, double min_valid) {
  return CorrelateBy(templ, image, min_valid, false);
}

Image Correlate(const Image& templ, const Image& image, double min_valid) {
  if (templ.Empty() || templ.width > image.width || templ.height > image.height) return {};
  const Eigen::Vector2i templ_size(templ.width, templ.height);
  const Eigen::Vector2i image_size(image.width, image.height);
  const bool spatial = SpatialCost(templ_size, image_size) <= FftCost(templ_size, image_size);
  return CorrelateBy(templ, image, min_valid, spatial);
}

double CorrelationCoefficient(const Image& a, const Image& b, double min_valid) {
  if (a.width != b.width || a.height != b.height)
    throw std::invalid_argument("CorrelationCoefficient: images of different size");
  if (a.Empty()) return std::numeric_limits<double>::quiet_NaN();
  return double(CorrelateSpatial(a, b, min_valid).At(0, 0));
}

}  // namespace orient
