#include "core/raster/png_bands.h"

#include <fmt/format.h>
#include <libdeflate.h>
#include <spng.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <memory>
#include <new>
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

// Samples of all bands, pixel after pixel, in host byte order.
template <typename T>
std::vector<T> Samples(const std::vector<Image>& bands) {
  constexpr auto kLargest = static_cast<float>(std::numeric_limits<T>::max());
  std::vector<T> samples(bands.size() * bands[0].values.size());
  for (std::size_t band = 0; band < bands.size(); ++band) {
    T* sample = samples.data() + band;
    for (const float value : bands[band].values) {
      if (!std::isnan(value))
        *sample = static_cast<T>(std::lround(std::clamp(value, 0.0f, kLargest)));
      sample += bands.size();
    }
  }
  return samples;
}

// Throws std::bad_alloc for want of memory: zlib cannot be initialised for any other reason.
void CheckEncoder(int error) {
  if (error == SPNG_EMEM || error == SPNG_EZLIB_INIT) throw std::bad_alloc();
  if (error != SPNG_OK)
    throw std::runtime_error(fmt::format("cannot encode the PNG: {}", spng_strerror(error)));
}

template <typename T>
std::vector<unsigned char> Encode(const std::vector<Image>& bands) {
  const std::vector<T> samples = Samples<T>(bands);
  const std::unique_ptr<spng_ctx, decltype(&spng_ctx_free)> encoder(spng_ctx_new(SPNG_CTX_ENCODER),
                                                                    &spng_ctx_free);
  if (!encoder) throw std::bad_alloc();
  CheckEncoder(spng_set_option(encoder.get(), SPNG_ENCODE_TO_BUFFER, 1));
  // Fixed, so that the same picture gives the same bytes.
  constexpr int kLevel = 6, kFiltered = 1;  // zlib's Z_FILTERED
  CheckEncoder(spng_set_option(encoder.get(), SPNG_IMG_COMPRESSION_LEVEL, kLevel));
  CheckEncoder(spng_set_option(encoder.get(), SPNG_IMG_COMPRESSION_STRATEGY, kFiltered));
  CheckEncoder(spng_set_option(encoder.get(), SPNG_FILTER_CHOICE, SPNG_FILTER_CHOICE_ALL));
  spng_ihdr header{};
  header.width = static_cast<std::uint32_t>(bands[0].width);
  header.height = static_cast<std::uint32_t>(bands[0].height);
  header.bit_depth = 8 * sizeof(T);
  header.color_type = bands.size() == 1 ? kGrey : kColour;
  CheckEncoder(spng_set_ihdr(encoder.get(), &header));
  CheckEncoder(spng_encode_image(encoder.get(), samples.data(), samples.size() * sizeof(T),
                                 SPNG_FMT_PNG, SPNG_ENCODE_FINALIZE));
  std::size_t size = 0;
  int error = SPNG_OK;
  const std::unique_ptr<void, decltype(&std::free)> png(
      spng_get_png_buffer(encoder.get(), &size, &error), &std::free);
  CheckEncoder(error);
  const auto* bytes = static_cast<const unsigned char*>(png.get());
  return {bytes, bytes + size};
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

// From 13 bytes: width, height, bits, colour type, three methods.
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

// Checks every chunk before its contents are trusted. The result points into `png`.
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

// The rows, each preceded by its filter's number.
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
// >= the larger one, and likewise the larger one; else the corner. Branch-free, as no
// processor predicts noise; few operations after `left`, on which every next value depends.
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

// Samples of kBytes bytes, kPixel bytes apart: with sizes known when compiling, several are taken
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
  return bits == 8 ? Encode<std::uint8_t>(bands) : Encode<std::uint16_t>(bands);
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
