#include "core/raster/resample.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

#include "core/raster/area_average.h"

namespace orient {
namespace {

constexpr int kTaps = 4;

// Weights of up to four neighbouring pixels along one axis, for the value and its derivative.
struct Taps {
  int first = 0;
  int count = 0;
  std::array<double, kTaps> value{};
  std::array<double, kTaps> slope{};
};

Taps LinearTaps(int below, double t, int size) {
  if (below == size - 1) {  // exactly the last centre: continue the last interval
    if (size == 1) return {0, 1, {1}, {0}};
    return {size - 2, 2, {0, 1}, {-1, 1}};
  }
  return {below, 2, {1 - t, t}, {-1, 1}};
}

// Catmull-Rom: Keys' cubic with a = -1/2.
std::array<double, kTaps> CubicWeights(double t) {
  const double t2 = t * t, t3 = t2 * t;
  return {-0.5 * t3 + t2 - 0.5 * t, 1.5 * t3 - 2.5 * t2 + 1, -1.5 * t3 + 2 * t2 + 0.5 * t,
          0.5 * t3 - 0.5 * t2};
}

Taps CubicTaps(int below, double t) {
  const double t2 = t * t;
  return {below - 1,
          4,
          CubicWeights(t),
          {-1.5 * t2 + 2 * t - 0.5, 4.5 * t2 - 5 * t, -4.5 * t2 + 4 * t + 0.5, 1.5 * t2 - t}};
}

// False where the position is not between two pixel centres.
bool Locate(double position, int size, int* below, double* t) {
  const double index = position - 0.5;  // pixel centres are whole numbers
  if (!(index >= 0 && index <= size - 1)) return false;
  *below = static_cast<int>(index);
  *t = index - *below;
  return true;
}

bool HasCubicSupport(int below, int size) { return below >= 1 && below + 2 < size; }

// Weighted sums; a pixel with no weight at all may be NaN.
bool Sum(const Image& image, const Taps& x, const Taps& y, float* value, Eigen::Vector2f* slope) {
  double v = 0, dx = 0, dy = 0;
  for (int j = 0; j < y.count; ++j) {
    const auto sj = static_cast<size_t>(j);
    const float* pixel = image.Row(y.first + j) + x.first;
    double row = 0, row_slope = 0;
    for (int i = 0; i < x.count; ++i) {
      const auto si = static_cast<size_t>(i);
      const bool used = slope == nullptr ? x.value[si] != 0 && y.value[sj] != 0
                                         : (x.value[si] != 0 || x.slope[si] != 0) &&
                                               (y.value[sj] != 0 || y.slope[sj] != 0);
      if (!used) continue;
      row += x.value[si] * double(pixel[i]);
      row_slope += x.slope[si] * double(pixel[i]);
    }
    v += y.value[sj] * row;
    dx += y.value[sj] * row_slope;
    dy += y.slope[sj] * row;
  }
  if (std::isnan(v) || (slope != nullptr && (std::isnan(dx) || std::isnan(dy)))) return false;
  *value = static_cast<float>(v);
  if (slope != nullptr) *slope = {static_cast<float>(dx), static_cast<float>(dy)};
  return true;
}

// The value alone, where no pixel is NaN: several times as fast as Sum, and the same to the bit.
double SumOfSixteen(const Image& image, int col, int row, double tx, double ty) {
  const std::array<double, kTaps> x = CubicWeights(tx), y = CubicWeights(ty);
  double v = 0;
  for (int j = 0; j < kTaps; ++j) {
    const float* p = image.Row(row - 1 + j) + col - 1;
    double sum = 0;
    for (int i = 0; i < kTaps; ++i) sum += x[static_cast<size_t>(i)] * double(p[i]);
    v += y[static_cast<size_t>(j)] * sum;
  }
  return v;
}

bool Sample(const Image& image, const Eigen::Vector2d& pixel, bool cubic, float* value,
            Eigen::Vector2f* slope) {
  int col = 0, row = 0;
  double tx = 0, ty = 0;
  if (!Locate(pixel.x(), image.width, &col, &tx) || !Locate(pixel.y(), image.height, &row, &ty))
    return false;
  cubic = cubic && HasCubicSupport(col, image.width) && HasCubicSupport(row, image.height);
  if (cubic && slope == nullptr) {
    const double v = SumOfSixteen(image, col, row, tx, ty);
    *value = static_cast<float>(v);
    if (!std::isnan(v)) return true;
  }
  const Taps x = cubic ? CubicTaps(col, tx) : LinearTaps(col, tx, image.width);
  const Taps y = cubic ? CubicTaps(row, ty) : LinearTaps(row, ty, image.height);
  return Sum(image, x, y, value, slope);
}

// Convolution with a symmetric kernel in both directions; NaN and what lies beyond the border take
// no part, NaN pixels stay NaN.
Image ConvolveNormalised(const Image& image, const cv::Mat& kernel) {
  cv::Mat values(image.height, image.width, CV_32F), mask(image.height, image.width, CV_32F);
  for (int r = 0; r < image.height; ++r) {
    for (int c = 0; c < image.width; ++c) {
      const float v = image.At(c, r);
      mask.at<float>(r, c) = std::isnan(v) ? 0.0f : 1.0f;
      values.at<float>(r, c) = std::isnan(v) ? 0.0f : v;
    }
  }
  cv::Mat sum, share;
  const cv::Point centre(-1, -1);
  cv::sepFilter2D(values, sum, CV_64F, kernel, kernel, centre, 0, cv::BORDER_CONSTANT);
  cv::sepFilter2D(mask, share, CV_64F, kernel, kernel, centre, 0, cv::BORDER_CONSTANT);
  Image result(image.width, image.height, kNoData);
  for (int r = 0; r < image.height; ++r)
    for (int c = 0; c < image.width; ++c)
      if (mask.at<float>(r, c) > 0)
        result.At(c, r) = static_cast<float>(sum.at<double>(r, c) / share.at<double>(r, c));
  return result;
}

float MeanOfFour(const Image& image, int col, int row) {
  double sum = 0;
  int valid = 0, inside = 0;
  for (int r = row; r < std::min(row + 2, image.height); ++r) {
    for (int c = col; c < std::min(col + 2, image.width); ++c) {
      const float v = image.At(c, r);
      ++inside;
      if (std::isnan(v)) continue;
      sum += double(v);
      ++valid;
    }
  }
  return 2 * (inside - valid) >= inside ? kNoData : static_cast<float>(sum / valid);
}

}  // namespace

float SampleBilinear(const Image& image, const Eigen::Vector2d& pixel) {
  float value = kNoData;
  return Sample(image, pixel, false, &value, nullptr) ? value : kNoData;
}

float SampleBicubic(const Image& image, const Eigen::Vector2d& pixel) {
  float value = kNoData;
  return Sample(image, pixel, true, &value, nullptr) ? value : kNoData;
}

bool SampleBicubicWithGradient(const Image& image, const Eigen::Vector2d& pixel, float* value,
                               Eigen::Vector2f* gradient) {
  return Sample(image, pixel, true, value, gradient);
}

Image MiddleOf(const Image& image, int width, int height) {
  Image part(width, height);
  const int col0 = (image.width - width) / 2, row0 = (image.height - height) / 2;
  for (int row = 0; row < height; ++row)
    std::copy_n(image.Row(row0 + row) + col0, width, part.Row(row));
  return part;
}

Image Mirrored(Image image) {
  for (int row = 0; row < image.height; ++row)
    std::reverse(image.Row(row), image.Row(row) + image.width);
  return image;
}

Image GaussianBlur(const Image& image, double sigma_px) {
  if (!(sigma_px >= 0)) throw std::invalid_argument("GaussianBlur: a negative sigma");
  if (image.Empty() || sigma_px == 0) return image;
  const int radius = std::max(1, static_cast<int>(std::ceil(4 * sigma_px)));
  return ConvolveNormalised(image, cv::getGaussianKernel(2 * radius + 1, sigma_px, CV_64F));
}

Image ReduceByTwo(const Image& image) {
  if (image.Empty()) return image;
  const Image blurred = ConvolveNormalised(image, (cv::Mat_<double>(3, 1) << 0.25, 0.5, 0.25));
  Image result((image.width + 1) / 2, (image.height + 1) / 2);
  for (int r = 0; r < result.height; ++r)
    for (int c = 0; c < result.width; ++c) result.At(c, r) = MeanOfFour(blurred, 2 * c, 2 * r);
  return result;
}

std::vector<Image> BuildPyramid(const Image& image, int levels) {
  if (levels < 1) throw std::invalid_argument("BuildPyramid: less than one level");
  std::vector<Image> pyramid = {image};
  while (static_cast<int>(pyramid.size()) < levels) pyramid.push_back(ReduceByTwo(pyramid.back()));
  return pyramid;
}

Image EnlargeBy(const Image& image, int factor) {
  if (factor < 1) throw std::invalid_argument("EnlargeBy: a factor below 1");
  if (image.Empty() || factor == 1) return image;
  Image result(factor * image.width, factor * image.height);
  const cv::Mat source(image.height, image.width, CV_32F, const_cast<float*>(image.values.data()));
  cv::Mat target(result.height, result.width, CV_32F, result.values.data());
  cv::resize(source, target, target.size(), 0, 0, cv::INTER_CUBIC);
  return result;
}

Image ReduceBy(const Image& image, double factor) {
  if (!(factor >= 1)) throw std::invalid_argument("ReduceBy: a factor below 1");
  if (image.Empty() || factor == 1) return image;
  const auto cells = [factor](int size) {
    return AreaWeights(0, factor, static_cast<int>(std::ceil(size / factor - 1e-9)), size);
  };
  AreaAverager averager(cells(image.width), cells(image.height), 0);
  for (int r = 0; r < image.height; ++r) averager.AddRow(r, image.Row(r));
  // Like ReduceByTwo: NaN if at least half of the area inside is.
  constexpr double kMoreThanHalf = 0.5 + 1e-6;
  return averager.Result(kMoreThanHalf, true);
}

}  // namespace orient
