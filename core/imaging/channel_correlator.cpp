#include "core/imaging/channel_correlator.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

#include "core/imaging/gradient_channels.h"

namespace orient {
namespace {

constexpr int kBorder = 1;  // of an image, on which the channels have no data
constexpr double kLeastData = 0.5;
// Less than this part of the strength that a window has on average is rounding.
constexpr double kFlat = 1e-6;

// Zero where there is no data; returns how many pixels have some.
int Fill(const Image& channel, cv::Mat* values) {
  int count = 0;
  for (int row = 0; row < channel.height; ++row)
    for (int col = 0; col < channel.width; ++col) {
      const float value = channel.At(col, row);
      values->at<float>(row, col) = std::isfinite(value) ? value : 0.0F;
      count += std::isfinite(value) ? 1 : 0;
    }
  return count;
}

// Sums over windows of side x side whose corner lies `kBorder` inside of each place of a template.
cv::Mat InnerSums(const cv::Mat& values, int side) {
  cv::Mat sums;
  cv::integral(values, sums, CV_64F);
  const int inner = side - 2 * kBorder;
  const int rows = values.rows - side + 1, cols = values.cols - side + 1;
  const auto corner = [&](int row, int col) {
    return sums(cv::Rect(col + kBorder, row + kBorder, cols, rows));
  };
  return corner(inner, inner) - corner(inner, 0) - corner(0, inner) + corner(0, 0);
}

}  // namespace

struct ChannelCorrelator::Prepared {
  int side = 0, width = 0, height = 0;
  std::array<cv::Mat, kGradientChannels> spectra;
  cv::Mat strength;  // of the window at each place: root of the sum of squares; zero: none
};

ChannelCorrelator::ChannelCorrelator(const Image& image, int side) {
  if (side <= 2 * kBorder + 1 || side > image.width || side > image.height)
    throw std::invalid_argument("ChannelCorrelator: templates larger than the image, or too small");
  auto prepared = std::make_shared<Prepared>();
  prepared->side = side;
  prepared->width = image.width;
  prepared->height = image.height;
  const cv::Size size(cv::getOptimalDFTSize(image.width), cv::getOptimalDFTSize(image.height));
  const GradientChannels channels = ChannelsOf(image);
  cv::Mat squares = cv::Mat::zeros(image.height, image.width, CV_32F);
  for (std::size_t k = 0; k < kGradientChannels; ++k) {
    cv::Mat padded = cv::Mat::zeros(size, CV_32F);
    cv::Mat values = padded(cv::Rect(0, 0, image.width, image.height));
    Fill(channels.channels[k], &values);
    squares += values.mul(values);
    cv::dft(padded, prepared->spectra[k], 0, image.height);
  }
  cv::Mat data(image.height, image.width, CV_32F);
  for (int row = 0; row < image.height; ++row)
    for (int col = 0; col < image.width; ++col)
      data.at<float>(row, col) = std::isfinite(channels.channels[0].At(col, row)) ? 1.0F : 0.0F;
  const cv::Mat sum = InnerSums(squares, side), count = InnerSums(data, side);
  const double inner = std::pow(side - 2 * kBorder, 2);
  const double flat = kFlat * inner * cv::mean(squares)[0];
  prepared->strength = cv::Mat::zeros(sum.size(), CV_32F);
  for (int row = 0; row < sum.rows; ++row)
    for (int col = 0; col < sum.cols; ++col)
      if (count.at<double>(row, col) >= kLeastData * inner && sum.at<double>(row, col) > flat)
        prepared->strength.at<float>(row, col) =
            static_cast<float>(std::sqrt(sum.at<double>(row, col)));
  prepared_ = std::move(prepared);
}

// The circular correlation of an image and a template no larger than it wraps only where the
// template does not lie inside.
Image ChannelCorrelator::Scores(const Image& templ) const {
  const Prepared& p = *prepared_;
  if (templ.width != p.side || templ.height != p.side)
    throw std::invalid_argument("ChannelCorrelator: a template of another size");
  Image scores(p.width - p.side + 1, p.height - p.side + 1, kNoData);
  const GradientChannels channels = ChannelsOf(templ);
  cv::Mat product = cv::Mat::zeros(p.spectra[0].size(), CV_32F);
  cv::Mat spectrum, of_channel, padded;
  double squares = 0;
  int count = 0;
  for (std::size_t k = 0; k < kGradientChannels; ++k) {
    padded = cv::Mat::zeros(product.size(), CV_32F);
    cv::Mat values = padded(cv::Rect(0, 0, p.side, p.side));
    count = Fill(channels.channels[k], &values);
    squares += cv::norm(values, cv::NORM_L2SQR);
    cv::dft(padded, spectrum, 0, p.side);
    cv::mulSpectrums(p.spectra[k], spectrum, of_channel, 0, true);
    product += of_channel;
  }
  const double inner = std::pow(p.side - 2 * kBorder, 2);
  if (count < kLeastData * inner || !(squares > 0)) return scores;
  cv::dft(product, padded, cv::DFT_INVERSE | cv::DFT_SCALE | cv::DFT_REAL_OUTPUT, scores.height);
  const auto scale = static_cast<float>(std::sqrt(squares * count / inner));
  for (int row = 0; row < scores.height; ++row)
    for (int col = 0; col < scores.width; ++col) {
      const float strength = p.strength.at<float>(row, col);
      if (strength > 0)
        scores.At(col, row) =
            std::clamp(padded.at<float>(row, col) / (scale * strength), -1.0F, 1.0F);
    }
  return scores;
}

}  // namespace orient
