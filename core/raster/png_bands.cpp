#include "core/raster/png_bands.h"

#include <fmt/format.h>
#include <libdeflate.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <memory>
#include <new>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>

#include "core/base/error.h"

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
  return InputError(fmt::format("PNG chip of {} bytes: {}", bytes, how));
}

std::uint32_t BigEndian(const unsigned char* b) {
  return std::uint32_t{b[0]} << 24 | std::uint32_t{b[1]} << 16 | std::uint32_t{b[2]} << 8 |
         std::uint32_t{b[3]};
}

struct Header {
  std::size_t width = 0, height = 0, bands = 1, bytes = 1;  // of a sample
  std::size_t PixelBytes() const { return bands * bytes; }
  std::size_t RowBytes() const { return 1 + width * PixelBytes(); }  // with the filter's number
};

// Of 13 bytes: width, height, bits, colour type, three methods.
Header ReadHeader(const unsigned char* header, std::size_t bytes) {
  const std::uint32_t width = BigEndian(header), height = BigEndian(header + 4);
  if (width == 0 || height == 0 || width > kLargestSide || height > kLargestSide)
    throw InputError(fmt::format("PNG chip of {} x {} pixels: at most {} per side are accepted",
                                 width, height, kLargestSide));
  if ((header[8] != 8 && header[8] != 16) || (header[9] != kGrey && header[9] != kColour))
    throw Damaged(bytes, "neither grey nor RGB of 8 or 16 bits");
  if (header[10] != 0 || header[11] != 0 || header[12] != 0)
    throw Damaged(bytes, "interlaced, or packed in an unknown way");
  return {width, height, header[9] == kColour ? std::size_t{3} : std::size_t{1},
          header[8] == 16 ? std::size_t{2} : std::size_t{1}};
}

struct Contents {
  Header header;
  std::span<const unsigned char> packed;
  std::vector<unsigned char> joined;  // holds `packed` where the PNG has it in several chunks

  void Add(std::span<const unsigned char> chunk) {
    if (packed.empty()) {
      packed = chunk;
      return;
    }
    if (joined.empty()) joined.assign(packed.begin(), packed.end());
    joined.insert(joined.end(), chunk.begin(), chunk.end());
    packed = joined;
  }
};

// Chunk by chunk, before anything believes what they claim. What is read points into `png`.
Contents ReadChunks(const std::vector<unsigned char>& png) {
  const auto starts_with = [&](std::size_t at, std::string_view text) {
    return png.size() >= at + text.size() && std::memcmp(&png[at], text.data(), text.size()) == 0;
  };
  if (!starts_with(0, kSignature) || !starts_with(kSignature.size() + 4, "IHDR"))
    throw Damaged(png.size(), "not a PNG; the database or file that holds it is damaged");
  Contents contents;
  std::size_t at = kSignature.size();
  while (true) {
    if (png.size() < at + kAroundData) throw Damaged(png.size(), "damaged (it is cut off)");
    const std::size_t length = BigEndian(&png[at]), type = at + 4;
    if (png.size() - at - kAroundData < length)
      throw Damaged(png.size(), "damaged (it is cut off)");
    const auto sum = libdeflate_crc32(0, &png[type], length + 4);
    if (sum != BigEndian(&png[type + 4 + length]))
      throw Damaged(png.size(), "damaged (a checksum is wrong)");
    const unsigned char* data = &png[type + 4];
    if (at == kSignature.size()) {
      if (length != 13) throw Damaged(png.size(), "damaged (its header has the wrong size)");
      contents.header = ReadHeader(data, png.size());
    }
    if (starts_with(type, "IDAT")) contents.Add({data, length});
    if (starts_with(type, "tRNS")) throw Damaged(png.size(), "it has transparency");
    if (starts_with(type, "IEND")) return contents;
    at += length + kAroundData;
  }
}

// Rows, each behind its filter's number.
std::vector<unsigned char> Unpack(const Contents& contents, std::size_t bytes) {
  using Unpacker = std::unique_ptr<libdeflate_decompressor, void (*)(libdeflate_decompressor*)>;
  thread_local const Unpacker unpacker(libdeflate_alloc_decompressor(),
                                       libdeflate_free_decompressor);
  std::vector<unsigned char> rows(contents.header.RowBytes() * contents.header.height);
  if (!unpacker) throw std::bad_alloc();
  if (libdeflate_zlib_decompress(unpacker.get(), contents.packed.data(), contents.packed.size(),
                                 rows.data(), rows.size(), nullptr) != LIBDEFLATE_SUCCESS)
    throw Damaged(bytes, "damaged (its picture cannot be decoded)");
  return rows;
}

// Which of its neighbours to the left, above and above to the left a value is nearest (PNG 1.2,
// 6.6): with p = left + above - corner the smaller one where p <= it, hence 3 corner - left - above
// >= the larger one, and likewise the larger one; else the corner. Without a jump, since no
// processor guesses noise; short after `left`, on which every next value waits.
int Paeth(int left, int above, int corner) {
  const int threshold = 3 * corner - above - left;
  const int low = std::min(left, above), high = std::max(left, above);
  const int low_or_corner = high <= threshold ? low : corner;
  return threshold <= low ? high : low_or_corner;
}

// `row` in place; `above` the row before, zero for the first; kPixel bytes a pixel.
template <std::size_t kPixel>
bool Unfilter(unsigned char filter, const unsigned char* above, std::size_t length,
              unsigned char* row) {
  const auto add = [&](auto predict) {
    std::array<int, kPixel> left{}, corner{};
    for (std::size_t i = 0; i < length; i += kPixel)
      for (std::size_t k = 0; k < kPixel; ++k) {
        const int up = above[i + k];
        row[i + k] = static_cast<unsigned char>(row[i + k] + predict(left[k], up, corner[k]));
        left[k] = row[i + k];
        corner[k] = up;
      }
  };
  switch (filter) {
    case 0:
      return true;
    case 1:
      add([](int left, int, int) { return left; });
      return true;
    case 2:
      for (std::size_t i = 0; i < length; ++i)
        row[i] = static_cast<unsigned char>(row[i] + above[i]);
      return true;
    case 3:
      add([](int left, int up, int) { return (left + up) / 2; });
      return true;
    case 4:
      add(Paeth);
      return true;
    default:
      return false;
  }
}

bool UnfilterRow(unsigned char filter, const unsigned char* above, const Header& header,
                 unsigned char* row) {
  const std::size_t length = header.RowBytes() - 1;
  switch (header.PixelBytes()) {
    case 1:
      return Unfilter<1>(filter, above, length, row);
    case 2:
      return Unfilter<2>(filter, above, length, row);
    case 3:
      return Unfilter<3>(filter, above, length, row);
    default:
      return Unfilter<6>(filter, above, length, row);
  }
}

// Samples of kBytes bytes, kPixel bytes apart: of so many that the compiler knows, it takes several
// at a time.
template <std::size_t kPixel, std::size_t kBytes>
void Take(const unsigned char* sample, std::size_t count, float* values) {
  for (std::size_t i = 0; i < count; ++i, sample += kPixel)
    values[i] = static_cast<float>(kBytes == 1 ? int{sample[0]} : sample[0] << 8 | sample[1]);
}

void TakeRow(const unsigned char* row, const Header& header, std::size_t number,
             std::vector<Image>* bands) {
  for (std::size_t band = 0; band < header.bands; ++band) {
    float* values = (*bands)[band].Row(static_cast<int>(number));
    const unsigned char* sample = row + band * header.bytes;
    switch (header.PixelBytes()) {
      case 1:
        Take<1, 1>(sample, header.width, values);
        break;
      case 2:
        Take<2, 2>(sample, header.width, values);
        break;
      case 3:
        Take<3, 1>(sample, header.width, values);
        break;
      default:
        Take<6, 2>(sample, header.width, values);
        break;
    }
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
  const Contents contents = ReadChunks(png);
  const Header& header = contents.header;
  std::vector<unsigned char> rows = Unpack(contents, png.size());
  std::vector<Image> bands;
  bands.reserve(header.bands);
  for (std::size_t band = 0; band < header.bands; ++band)
    bands.emplace_back(static_cast<int>(header.width), static_cast<int>(header.height));
  const std::vector<unsigned char> nothing(header.RowBytes());
  const unsigned char* above = nothing.data();
  for (std::size_t row = 0; row < header.height; ++row) {
    unsigned char* values = &rows[row * header.RowBytes()] + 1;
    if (!UnfilterRow(values[-1], above, header, values))
      throw Damaged(png.size(), "damaged (a row's filter is unknown)");
    TakeRow(values, header, row, &bands);
    above = values;
  }
  return bands;
}

Image GreyOfBands(std::vector<Image> bands) {
  if (bands.size() == 1) return std::move(bands[0]);
  Image grey(bands[0].width, bands[0].height);
  for (std::size_t i = 0; i < grey.values.size(); ++i)
    grey.values[i] =
        0.299f * bands[0].values[i] + 0.587f * bands[1].values[i] + 0.114f * bands[2].values[i];
  return grey;
}

}  // namespace orient
