#include "core/imaging/image_correlator.h"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

namespace orient {
namespace {

// Less than this part of the whole image's variance is flat.
constexpr double kFlat = 1e-4;
constexpr double kLeastData = 0.5;

// An image less its mean, with zeros where there is no data; returns how many pixels have some.
int WithoutMean(const Image& image, cv::Mat* values, cv::Mat* mask) {
  double sum = 0;
  int count = 0;
  for (const float v : image.values) {
    if (!std::isfinite(v)) continue;
    sum += static_cast<double>(v);
    ++count;
  }
  const float mean = count > 0 ? static_cast<float>(sum / count) : 0.0F;
  for (int row = 0; row < image.height; ++row)
    for (int col = 0; col < image.width; ++col) {
      const float v = image.At(col, row);
      values->at<float>(row, col) = std::isfinite(v) ? v - mean : 0.0F;
      if (mask != nullptr) mask->at<float>(row, col) = std::isfinite(v) ? 1.0F : 0.0F;
    }
  return count;
}

// Sums over windows of side x side, one for each place of the window inside.
cv::Mat WindowSums(const cv::Mat& values, int side) {
  cv::Mat sums;
  cv::integral(values, sums, CV_64F);
  const int rows = values.rows - side + 1, cols = values.cols - side + 1;
  const auto corner = [&](int row, int col) { return sums(cv::Rect(col, row, cols, rows)); };
  return corner(side, side) - corner(0, side) - corner(side, 0) + corner(0, 0);
}

}  // namespace

struct ImageCorrelator::Prepared {
  int side = 0, width = 0, height = 0;
  cv::Mat spectrum;   // of the image less its mean
  cv::Mat deviation;  // of the window at each place; zero: flat, or too little data
};

ImageCorrelator::ImageCorrelator(const Image& image, int side) {
  if (side < 2 || side > image.width || side > image.height)
    throw std::invalid_argument("ImageCorrelator: templates larger than the image");
  auto prepared = std::make_shared<Prepared>();
  prepared->side = side;
  prepared->width = image.width;
  prepared->height = image.height;
  const cv::Size size(cv::getOptimalDFTSize(image.width), cv::getOptimalDFTSize(image.height));
  cv::Mat padded = cv::Mat::zeros(size, CV_32F);
  cv::Mat values = padded(cv::Rect(0, 0, image.width, image.height));
  cv::Mat mask(image.height, image.width, CV_32F);
  const int count = WithoutMean(image, &values, &mask);
  const cv::Mat sum = WindowSums(values, side);
  const cv::Mat squares = WindowSums(values.mul(values), side);
  const cv::Mat data = WindowSums(mask, side);
  const double flat = kFlat * cv::norm(values, cv::NORM_L2SQR) / std::max(count, 1);
  prepared->deviation = cv::Mat::zeros(sum.size(), CV_32F);
  for (int row = 0; row < sum.rows; ++row)
    for (int col = 0; col < sum.cols; ++col) {
      const double n = data.at<double>(row, col), s = sum.at<double>(row, col);
      if (n < kLeastData * side * side) continue;
      const double variance = squares.at<double>(row, col) / n - (s / n) * (s / n);
      if (variance > flat)
        prepared->deviation.at<float>(row, col) = static_cast<float>(std::sqrt(variance));
    }
  cv::dft(padded, prepared->spectrum, 0, image.height);
  prepared_ = std::move(prepared);
}

// The circular correlation of an image and a template no larger than it wraps only where the
// template does not lie inside.
Image ImageCorrelator::Scores(const Image& templ) const {
  const Prepared& p = *prepared_;
  if (templ.width != p.side || templ.height != p.side)
    throw std::invalid_argument("ImageCorrelator: a template of another size");
  Image scores(p.width - p.side + 1, p.height - p.side + 1, kNoData);
  cv::Mat padded = cv::Mat::zeros(p.spectrum.size(), CV_32F);
  cv::Mat values = padded(cv::Rect(0, 0, p.side, p.side));
  const int count = WithoutMean(templ, &values, nullptr);
  const double norm = cv::norm(values);
  if (count < 2 || !(norm > 0)) return scores;
  cv::Mat spectrum, product;
  cv::dft(padded, spectrum, 0, p.side);
  cv::mulSpectrums(p.spectrum, spectrum, product, 0, true);
  cv::dft(product, padded, cv::DFT_INVERSE | cv::DFT_SCALE | cv::DFT_REAL_OUTPUT, scores.height);
  const auto scale = static_cast<float>(norm * std::sqrt(static_cast<double>(count)));
  for (int row = 0; row < scores.height; ++row)
    for (int col = 0; col < scores.width; ++col) {
      const float deviation = p.deviation.at<float>(row, col);
      if (deviation > 0)
        scores.At(col, row) =
            std::clamp(padded.at<float>(row, col) / (scale * deviation), -1.0F, 1.0F);
    }
  return scores;
}

}  // namespace orient
