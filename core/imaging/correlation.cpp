#include "core/imaging/correlation.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "core/imaging/correlation_sums.h"

namespace orient {
namespace {

using Eigen::Index;

// A window whose variance is below this part of the whole image's sum of squares is flat: below it
// the rounding of the sums decides.
constexpr double kFlat = 1e-10;

// An image less its mean, zero where there is no data, with all that is summed over.
struct Side {
  Plane value, square, mask;  // the mask is empty where all is data
  bool full = true;
  double count = 0;  // valid pixels
  double energy = 0;

  explicit Side(const Image& image) : value(image.height, image.width) {
    double sum = 0;
    for (const float v : image.values) {
      if (!std::isfinite(v)) continue;
      sum += double(v);
      ++count;
    }
    full = count == static_cast<double>(image.values.size());
    if (!full) mask.resize(image.height, image.width);
    const double mean = count > 0 ? sum / count : 0;
    for (size_t i = 0; i < image.values.size(); ++i) {
      const bool valid = std::isfinite(image.values[i]);
      value.data()[i] = valid ? double(image.values[i]) - mean : 0;
      if (!full) mask.data()[i] = valid ? 1 : 0;
    }
    square = value.square();
    energy = square.sum();
  }
};

// One sum at every place, or the same everywhere.
struct PlaneOrConstant {
  Plane plane;
  double constant = 0;
  double operator[](size_t k) const { return plane.size() > 0 ? plane.data()[k] : constant; }
};

// Over the pixels valid on both sides, at every place.
struct Sums {
  PlaneOrConstant count, t, tt;
  Plane i, ii, ti;
};

Sums SumUp(const Side& t, const Side& i, ProductSums* by) {
  const auto over_template = [&t, by](const Plane& plane) {
    return t.full ? BoxSums(plane, t.value.rows(), t.value.cols()) : by->Sum(t.mask, plane);
  };
  Sums s;
  s.ti = by->Sum(t.value, i.value);
  s.i = over_template(i.value);
  s.ii = over_template(i.square);
  s.count.constant = t.count;
  s.t.constant = t.value.sum();
  s.tt.constant = t.energy;
  if (i.full) return s;
  s.count.plane = over_template(i.mask).round();
  s.t.plane = by->Sum(t.value, i.mask);
  s.tt.plane = by->Sum(t.square, i.mask);
  return s;
}

Image CorrelateBy(const Image& templ, const Image& image, double min_valid, bool spatial) {
  if (templ.Empty() || templ.width > image.width || templ.height > image.height) return {};
  const Side t(templ), i(image);
  Image result(image.width - templ.width + 1, image.height - templ.height + 1, kNoData);
  const double needed = std::max(2.0, min_valid * t.count);
  if (t.count < 2 || t.energy <= 0 || i.energy <= 0) return result;
  SpatialSums in_space;
  FftSums by_fft({templ.width, templ.height}, {image.width, image.height});
  const Sums s = SumUp(t, i, spatial ? static_cast<ProductSums*>(&in_space) : &by_fft);
  for (size_t k = 0; k < result.values.size(); ++k) {
    const double n = s.count[k];
    if (n < needed) continue;
    const double st = s.t[k], si = s.i.data()[k];
    const double var_t = s.tt[k] - st * st / n, var_i = s.ii.data()[k] - si * si / n;
    if (var_t <= kFlat * t.energy || var_i <= kFlat * i.energy) continue;
    const double ncc = (s.ti.data()[k] - st * si / n) / std::sqrt(var_t * var_i);
    result.values[k] = static_cast<float>(std::clamp(ncc, -1.0, 1.0));
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
