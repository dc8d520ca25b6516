#include "core/matching/image_correlator.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

#include "core/matching/gradient_channels.h"

namespace orient {
namespace {

constexpr double kLeastData = 0.5;
// A window is flat below this share of the whole image's variance; for gradients, below this share
// of the mean sum of squares of a window, which is rounding.
constexpr double kFlat = 1e-4, kFlatGradients = 1e-6;
constexpr int kBorder = 1;  // of an image, on which the channels have no data

// Places of a template in an image: the windows that it covers there, less a border.
struct Places {
  int side = 0, border = 0, width = 0, height = 0;

  Places(const Image& image, int template_side, int template_border)
      : side(template_side),
        border(template_border),
        width(image.width - side + 1),
        height(image.height - side + 1) {
    if (Inner() < 2 || width < 1 || height < 1)
      throw std::invalid_argument("templates larger than the image, or too small");
  }
  int Inner() const { return side - 2 * border; }
  double Pixels() const { return static_cast<double>(Inner()) * Inner(); }
  void Check(const Image& templ) const {
    if (templ.width != side || templ.height != side)
      throw std::invalid_argument("a template of another size");
  }
  // Sums over the windows.
  cv::Mat Sums(const cv::Mat& values) const {
    cv::Mat sums;
    cv::integral(values, sums, CV_64F);
    const auto corner = [&](int row, int col) {
      return sums(cv::Rect(col + border, row + border, width, height));
    };
    const int inner = Inner();
    return corner(inner, inner) - corner(inner, 0) - corner(0, inner) + corner(0, 0);
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
  Prepared prepared{Places(image, side, 0), {}, {}};
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

struct ChannelCorrelator::Prepared {
  Places places;
  std::array<cv::Mat, kGradientChannels> spectra;
  cv::Mat strength;  // of the window at each place: root of the sum of squares; zero: none
};

ChannelCorrelator::ChannelCorrelator(const Image& image, int side) {
  Prepared prepared{Places(image, side, kBorder), {}, {}};
  const Places& places = prepared.places;
  const GradientChannels channels = ChannelsOf(image);
  cv::Mat squares = cv::Mat::zeros(image.height, image.width, CV_32F);
  for (std::size_t k = 0; k < kGradientChannels; ++k) {
    const cv::Mat values = FilledLess(0, channels.channels[k]);
    squares += values.mul(values);
    prepared.spectra[k] = SpectrumOf(values, SizeOfSpectrum(image));
  }
  const cv::Mat sum = places.Sums(squares), count = places.Sums(MaskOf(channels.channels[0]));
  const double flat = kFlatGradients * places.Pixels() * cv::mean(squares)[0];
  prepared.strength = cv::Mat::zeros(sum.size(), CV_32F);
  for (int row = 0; row < sum.rows; ++row)
    for (int col = 0; col < sum.cols; ++col)
      if (count.at<double>(row, col) >= kLeastData * places.Pixels() &&
          sum.at<double>(row, col) > flat)
        prepared.strength.at<float>(row, col) =
            static_cast<float>(std::sqrt(sum.at<double>(row, col)));
  prepared_ = std::make_shared<Prepared>(std::move(prepared));
}

struct ChannelCorrelator::Template {
  std::array<cv::Mat, kGradientChannels> spectra;
  double scale = 0;  // zero: too little data, or no gradients
};

std::shared_ptr<const ChannelCorrelator::Template> ChannelCorrelator::Prepare(
    const Image& templ) const {
  const Places& places = prepared_->places;
  places.Check(templ);
  const GradientChannels channels = ChannelsOf(templ);
  const int count = CountOf(channels.channels[0]);
  Template prepared;
  double squares = 0;
  for (std::size_t k = 0; k < kGradientChannels; ++k) {
    const cv::Mat values = FilledLess(0, channels.channels[k]);
    squares += cv::norm(values, cv::NORM_L2SQR);
    prepared.spectra[k] = SpectrumOf(values, prepared_->spectra[0].size());
  }
  if (count >= kLeastData * places.Pixels())
    prepared.scale = std::sqrt(squares * count / places.Pixels());
  return std::make_shared<Template>(std::move(prepared));
}

Image ChannelCorrelator::Scores(const std::shared_ptr<const Template>& templ) const {
  const Places& places = prepared_->places;
  if (templ->spectra[0].size() != prepared_->spectra[0].size())
    throw std::invalid_argument("a template prepared for images of another size");
  if (!(templ->scale > 0)) return {places.width, places.height, kNoData};
  cv::Mat sum, product;
  cv::mulSpectrums(prepared_->spectra[0], templ->spectra[0], sum, 0, true);
  for (std::size_t k = 1; k < kGradientChannels; ++k) {
    cv::mulSpectrums(prepared_->spectra[k], templ->spectra[k], product, 0, true);
    sum += product;
  }
  return places.Ratios(ProductsOf(sum, places.height), templ->scale, prepared_->strength);
}

}  // namespace orient
