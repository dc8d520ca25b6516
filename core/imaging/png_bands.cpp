#include "core/imaging/png_bands.h"

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <stdexcept>

namespace orient {
namespace {

// OpenCV's order is blue, green, red.
int MatChannel(int band, int bands) { return bands == 1 ? 0 : 2 - band; }

template <typename T>
void Fill(const Image& band, int channel, cv::Mat& mat) {
  constexpr auto kLargest = static_cast<float>(std::numeric_limits<T>::max());
  for (int row = 0; row < band.height; ++row)
    for (int col = 0; col < band.width; ++col) {
      const float value = band.At(col, row);
      mat.ptr<T>(row)[col * mat.channels() + channel] =
          std::isnan(value) ? T{0} : static_cast<T>(std::lround(std::clamp(value, 0.0f, kLargest)));
    }
}

}  // namespace

std::vector<unsigned char> EncodePngBands(const std::vector<Image>& bands, int bits) {
  const int count = static_cast<int>(bands.size());
  if ((count != 1 && count != 3) || (bits != 8 && bits != 16) || bands[0].Empty() ||
      std::any_of(bands.begin(), bands.end(), [&](const Image& band) {
        return band.width != bands[0].width || band.height != bands[0].height;
      }))
    throw std::invalid_argument("a PNG has one or three bands of one size, of 8 or 16 bits");
  cv::Mat mat(bands[0].height, bands[0].width, CV_MAKETYPE(bits == 8 ? CV_8U : CV_16U, count));
  for (int band = 0; band < count; ++band) {
    const Image& values = bands[static_cast<size_t>(band)];
    if (bits == 8)
      Fill<unsigned char>(values, MatChannel(band, count), mat);
    else
      Fill<unsigned short>(values, MatChannel(band, count), mat);
  }
  std::vector<unsigned char> png;
  // Level and strategy are fixed so that the same picture gives the same bytes.
  const std::vector<int> settings = {cv::IMWRITE_PNG_COMPRESSION, 6, cv::IMWRITE_PNG_STRATEGY,
                                     cv::IMWRITE_PNG_STRATEGY_DEFAULT};
  if (!cv::imencode(".png", mat, png, settings))
    throw std::runtime_error("the PNG encoder refuses the image");
  return png;
}

Image GreyOfBands(const std::vector<Image>& bands) {
  if (bands.size() == 1) return bands[0];
  Image grey(bands[0].width, bands[0].height);
  for (size_t i = 0; i < grey.values.size(); ++i)
    grey.values[i] =
        0.299f * bands[0].values[i] + 0.587f * bands[1].values[i] + 0.114f * bands[2].values[i];
  return grey;
}

}  // namespace orient
