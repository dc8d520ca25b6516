#include "core/matching/image_correlator.h"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

namespace orient {
namespace {

constexpr double kLeastData = 0.5;
constexpr double kFlat = 1e-4;  // a window is flat below this share of the whole image's variance

// Places of a template in an image: the windows that it covers there.
struct Places {
  int side = 0, width = 0, height = 0;

  Places(const Image& image, int template_side)
      : side(template_side), width(image.width - side + 1), height(image.height - side + 1) {
    if (side < 2 || width < 1 || height < 1)
      throw std::invalid_argument("templates larger than the image, or too small");
  }
  double Pixels() const { return static_cast<double>(side) * side; }
  void Check(const Image& templ) const {
    if (templ.width != side || templ.height != side)
      throw std::invalid_argument("a template of another size");
  }
  // Sums over the windows.
  cv::Mat Sums(const cv::Mat& values) const {
    cv::Mat sums;
    cv::integral(values, sums, CV_64F);
    const auto corner = [&](int row, int col) { return sums(cv::Rect(col, row, width, height)); };
    return corner(side, side) - corner(side, 0) - corner(0, side) + corner(0, 0);
  }
  // Products of a template and the windows, divided by the norms of both: `scale` of
  // the template, `strength` of each window (0: none).
  Image Ratios(const cv::Mat& products, double scale, const cv::Mat& strength) const {
    Image scores(width, height, kNoData);
    const auto of_template = static_cast<float>(scale);
    for (int row = 0; row < height; ++row)
      for (int col = 0; col < width; ++col) {
        const float of_window = strength.at<float>(row, col);
        if (of_window > 0)
          scores.At(col, row) =
              std::clamp(products.at<float>(row, col) / (of_template * of_window), -1.0F, 1.0F);
      }
    return scores;
  }
};

cv::Mat MaskOf(const Image& image) {
  cv::Mat mask(image.height, image.width, CV_32F);
  for (int row = 0; row < image.height; ++row)
    for (int col = 0; col < image.width; ++col)
      mask.at<float>(row, col) = std::isfinite(image.At(col, row)) ? 1.0F : 0.0F;
  return mask;
}

// Values less `mean`, zero where there is no data.
cv::Mat FilledLess(float mean, const Image& image) {
  cv::Mat values(image.height, image.width, CV_32F);
  for (int row = 0; row < image.height; ++row)
    for (int col = 0; col < image.width; ++col) {
      const float value = image.At(col, row);
      values.at<float>(row, col) = std::isfinite(value) ? value - mean : 0.0F;
    }
  return values;
}

int CountOf(const Image& image) {
  return static_cast<int>(std::count_if(image.values.begin(), image.values.end(),
                                        [](float value) { return std::isfinite(value); }));
}

float MeanOf(const Image& image, int count) {
  double sum = 0;
  for (const float value : image.values)
    if (std::isfinite(value)) sum += static_cast<double>(value);
  return count > 0 ? static_cast<float>(sum / count) : 0.0F;
}

// With a spectrum of the image's size, circular correlation with the template wraps only where the
// template does not lie wholly inside the image.
cv::Size SizeOfSpectrum(const Image& image) {
  return {cv::getOptimalDFTSize(image.width), cv::getOptimalDFTSize(image.height)};
}

cv::Mat SpectrumOf(const cv::Mat& values, const cv::Size& size) {
  cv::Mat padded = cv::Mat::zeros(size, CV_32F), spectrum;
  values.copyTo(padded(cv::Rect(0, 0, values.cols, values.rows)));
  cv::dft(padded, spectrum, 0, values.rows);
  return spectrum;
}

cv::Mat ProductsOf(const cv::Mat& spectrum, int rows) {
  cv::Mat products;
  cv::dft(spectrum, products, cv::DFT_INVERSE | cv::DFT_SCALE | cv::DFT_REAL_OUTPUT, rows);
  return products;
}

}  // namespace

struct ImageCorrelator::Prepared {
  Places places;
  cv::Mat spectrum;   // of the image less its mean
  cv::Mat deviation;  // of the window at each place; zero: flat, or too little data
};

ImageCorrelator::ImageCorrelator(const Image& image, int side) {
  Prepared prepared{Places(image, side), {}, {}};
  const Places& places = prepared.places;
  const int count = CountOf(image);
  const cv::Mat values = FilledLess(MeanOf(image, count), image);
  const cv::Mat sum = places.Sums(values), squares = places.Sums(values.mul(values));
  const cv::Mat data = places.Sums(MaskOf(image));
  const double flat = kFlat * cv::norm(values, cv::NORM_L2SQR) / std::max(count, 1);
  prepared.deviation = cv::Mat::zeros(sum.size(), CV_32F);
  for (int row = 0; row < sum.rows; ++row)
    for (int col = 0; col < sum.cols; ++col) {
      const double n = data.at<double>(row, col), s = sum.at<double>(row, col);
      if (n < kLeastData * places.Pixels()) continue;
      const double variance = squares.at<double>(row, col) / n - (s / n) * (s / n);
      if (variance > flat)
        prepared.deviation.at<float>(row, col) = static_cast<float>(std::sqrt(variance));
    }
  prepared.spectrum = SpectrumOf(values, SizeOfSpectrum(image));
  prepared_ = std::make_shared<Prepared>(std::move(prepared));
}

Image ImageCorrelator::Scores(const Image& templ) const {
  const Places& places = prepared_->places;
  places.Check(templ);
  const int count = CountOf(templ);
  const cv::Mat values = FilledLess(MeanOf(templ, count), templ);
  const double norm = cv::norm(values);
  if (count < 2 || !(norm > 0)) return {places.width, places.height, kNoData};
  cv::Mat product;
  cv::mulSpectrums(prepared_->spectrum, SpectrumOf(values, prepared_->spectrum.size()), product, 0,
                   true);
  return places.Ratios(ProductsOf(product, places.height), norm * std::sqrt(count),
                       prepared_->deviation);
}

}  // namespace orient
