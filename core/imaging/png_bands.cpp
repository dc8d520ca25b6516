#include "core/imaging/png_bands.h"

#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <stdexcept>
#include <string>
#include <string_view>

#include "core/error.h"

namespace orient {
namespace {

constexpr std::uint32_t kLargestSide = 4096;
constexpr std::string_view kSignature("\x89PNG\r\n\x1a\n", 8);
constexpr std::size_t kAroundData = 12;          // of a chunk: length, type and checksum
constexpr unsigned char kGrey = 0, kColour = 2;  // colour types of the header

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

InputError Damaged(std::size_t bytes, const std::string& how) {
  return InputError("PNG chip of " + std::to_string(bytes) + " bytes: " + how);
}

std::uint32_t BigEndian(const unsigned char* b) {
  return std::uint32_t{b[0]} << 24 | std::uint32_t{b[1]} << 16 | std::uint32_t{b[2]} << 8 |
         std::uint32_t{b[3]};
}

// Of 13 bytes: width, height, bits, colour type, three methods.
void CheckHeader(const unsigned char* header, std::size_t bytes) {
  const std::uint32_t width = BigEndian(header), height = BigEndian(header + 4);
  if (width == 0 || height == 0 || width > kLargestSide || height > kLargestSide)
    throw InputError("PNG chip of " + std::to_string(width) + " x " + std::to_string(height) +
                     " pixels: at most " + std::to_string(kLargestSide) + " a side are taken");
  if ((header[8] != 8 && header[8] != 16) || (header[9] != kGrey && header[9] != kColour))
    throw Damaged(bytes, "neither grey nor RGB of 8 or 16 bits");
}

// Chunk by chunk, before any decoder believes what they claim: it would print what it dislikes.
void Check(const std::vector<unsigned char>& png) {
  const auto starts_with = [&](std::size_t at, std::string_view text) {
    return png.size() >= at + text.size() && std::memcmp(&png[at], text.data(), text.size()) == 0;
  };
  if (!starts_with(0, kSignature) || !starts_with(kSignature.size() + 4, "IHDR"))
    throw Damaged(png.size(), "not a PNG; the database or file that holds it is damaged");
  std::size_t at = kSignature.size();
  while (true) {
    if (png.size() < at + kAroundData) throw Damaged(png.size(), "damaged (it is cut off)");
    const std::size_t length = BigEndian(&png[at]), type = at + 4;
    if (png.size() - at - kAroundData < length)
      throw Damaged(png.size(), "damaged (it is cut off)");
    const auto sum = crc32(0, &png[type], static_cast<uInt>(length + 4));
    if (sum != BigEndian(&png[type + 4 + length]))
      throw Damaged(png.size(), "damaged (a checksum is wrong)");
    if (at == kSignature.size()) {
      if (length != 13) throw Damaged(png.size(), "damaged (its header is of another size)");
      CheckHeader(&png[type + 4], png.size());
    }
    if (starts_with(type, "IEND")) return;
    at += length + kAroundData;
  }
}

template <typename T>
Image Band(const cv::Mat& mat, int channel) {
  Image band(mat.cols, mat.rows);
  for (int row = 0; row < mat.rows; ++row) {
    const T* values = mat.ptr<T>(row);
    for (int col = 0; col < mat.cols; ++col)
      band.At(col, row) = static_cast<float>(values[col * mat.channels() + channel]);
  }
  return band;
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
    const Image& values = bands[static_cast<std::size_t>(band)];
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

std::vector<Image> DecodePngBands(const std::vector<unsigned char>& png) {
  Check(png);
  cv::Mat mat;
  try {
    mat = cv::imdecode(png, cv::IMREAD_UNCHANGED);
  } catch (const cv::Exception&) {
    // Empty, as where the decoder gives up.
  }
  if (mat.empty()) throw Damaged(png.size(), "damaged (its picture cannot be decoded)");
  const int count = mat.channels();
  if (count != 1 && count != 3) throw Damaged(png.size(), "it has an alpha channel");
  std::vector<Image> bands;
  for (int band = 0; band < count; ++band)
    bands.push_back(mat.depth() == CV_8U ? Band<unsigned char>(mat, MatChannel(band, count))
                                         : Band<unsigned short>(mat, MatChannel(band, count)));
  return bands;
}

Image GreyOfBands(const std::vector<Image>& bands) {
  if (bands.size() == 1) return bands[0];
  Image grey(bands[0].width, bands[0].height);
  for (std::size_t i = 0; i < grey.values.size(); ++i)
    grey.values[i] =
        0.299f * bands[0].values[i] + 0.587f * bands[1].values[i] + 0.114f * bands[2].values[i];
  return grey;
}

}  // namespace orient
