#include "core/raster/png_bands.h"

#include <gtest/gtest.h>
#include <libdeflate.h>

#include <fstream>
#include <random>
#include <stdexcept>

#include "core/base/error.h"
#include "core/raster/raster.h"
#include "tests/support/shared_data.h"

namespace orient {
namespace {

Image Noise(int width, int height, int largest, std::mt19937& random) {
  Image image(width, height);
  for (float& value : image.values)
    value = static_cast<float>(random() % static_cast<unsigned>(largest + 1));
  return image;
}

TEST(PngBands, GreyAndColourOf8And16BitsAreLossless) {
  std::mt19937 random(TestSeed());
  for (const int bits : {8, 16})
    for (const int count : {1, 3}) {
      std::vector<Image> bands;
      for (int i = 0; i < count; ++i) bands.push_back(Noise(13, 7, (1 << bits) - 1, random));
      const auto read = DecodePngBands(EncodePngBands(bands, bits));
      ASSERT_EQ(read.size(), bands.size());
      for (std::size_t i = 0; i < bands.size(); ++i) {
        EXPECT_EQ(read[i].width, 13);
        EXPECT_EQ(read[i].values, bands[i].values);
      }
    }
}

TEST(PngBands, GreyIsTheRastersGrey) {
  std::mt19937 random(TestSeed());
  const std::vector<Image> bands = {Noise(9, 9, 255, random), Noise(9, 9, 255, random),
                                    Noise(9, 9, 255, random)};
  const TemporaryFolder folder;
  const auto png = EncodePngBands(bands, 8);
  std::ofstream(folder / "a.png", std::ios::binary)
      .write(reinterpret_cast<const char*>(png.data()), static_cast<std::streamsize>(png.size()));
  const Image grey = GreyOfBands(bands), raster = Raster::Open(folder / "a.png").ReadGrey().image;
  for (std::size_t i = 0; i < grey.values.size(); ++i)
    EXPECT_NEAR(grey.values[i], raster.values[i], 1e-4);
}

TEST(PngBands, EncodingIsDeterministic) {
  std::mt19937 random(TestSeed());
  const std::vector<Image> bands(3, Noise(64, 64, 255, random));
  EXPECT_EQ(EncodePngBands(bands, 8), EncodePngBands(bands, 8));
}

TEST(PngBands, EveryTruncationIsRefusedWithoutNoise) {
  std::mt19937 random(TestSeed());
  const auto png = EncodePngBands({Noise(21, 21, 255, random)}, 8);
  testing::internal::CaptureStderr();
  for (std::size_t size = 0; size < png.size(); ++size)
    EXPECT_THROW(DecodePngBands({png.begin(), png.begin() + static_cast<std::ptrdiff_t>(size)}),
                 InputError)
        << size;
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

TEST(PngBands, DamagedBytesAreRefusedWithoutNoise) {
  std::mt19937 random(TestSeed());
  const auto png = EncodePngBands({Noise(40, 30, 255, random)}, 8);
  testing::internal::CaptureStderr();
  EXPECT_THROW(DecodePngBands({'G', 'I', 'F', '8', '9', 'a'}), InputError);
  for (int round = 0; round < 500; ++round) {
    auto damaged = png;
    for (int i = 0; i < 3; ++i)
      damaged[random() % damaged.size()] = static_cast<unsigned char>(random());
    if (damaged == png) continue;
    EXPECT_THROW(DecodePngBands(damaged), InputError);
  }
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

void AppendChunk(const std::string& type, const std::vector<unsigned char>& data,
                 std::vector<unsigned char>& png) {
  const auto append = [&](std::uint32_t value) {
    for (const unsigned shift : {24u, 16u, 8u, 0u})
      png.push_back(static_cast<unsigned char>(value >> shift));
  };
  append(static_cast<std::uint32_t>(data.size()));
  const std::size_t start = png.size();
  png.insert(png.end(), type.begin(), type.end());
  png.insert(png.end(), data.begin(), data.end());
  append(libdeflate_crc32(0, &png[start], png.size() - start));
}

// Rows, each behind its filter's number, of 8-bit grey; packed by zlib's own rules, unpacked here:
// stored blocks.
std::vector<unsigned char> PngOf(const std::vector<std::vector<unsigned char>>& rows) {
  std::vector<unsigned char> raw;
  for (const auto& row : rows) raw.insert(raw.end(), row.begin(), row.end());
  const auto size = static_cast<unsigned>(raw.size());
  std::vector<unsigned char> packed = {0x78, 0x01, 1};
  for (const unsigned part : {size, size >> 8, ~size, ~size >> 8})
    packed.push_back(static_cast<unsigned char>(part));
  packed.insert(packed.end(), raw.begin(), raw.end());
  const std::uint32_t sum = libdeflate_adler32(1, raw.data(), raw.size());
  for (const unsigned shift : {24u, 16u, 8u, 0u})
    packed.push_back(static_cast<unsigned char>(sum >> shift));
  std::vector<unsigned char> png = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
  const auto width = static_cast<unsigned char>(rows[0].size() - 1);
  AppendChunk("IHDR",
              {0, 0, 0, width, 0, 0, 0, static_cast<unsigned char>(rows.size()), 8, 0, 0, 0, 0},
              png);
  const auto half = packed.begin() + static_cast<std::ptrdiff_t>(packed.size() / 2);
  AppendChunk("IDAT", {packed.begin(), half}, png);  // pieces of any size are one stream
  AppendChunk("IDAT", {half, packed.end()}, png);
  AppendChunk("IEND", {}, png);
  return png;
}

// PNG specification 1.2, section 6, worked by hand.
TEST(PngBands, EveryFilterIsUndone) {
  const Image image = DecodePngBands(PngOf({{0, 10, 20, 250},
                                            {1, 5, 250, 10},     // left
                                            {2, 1, 2, 3},        // up
                                            {3, 7, 7, 7},        // mean of left and up, down
                                            {4, 1, 1, 1}}))[0];  // Paeth
  const std::vector<float> expected = {10, 20,  250,             // as they stand
                                       5,  255, 9,               // 5, 5 + 250, 255 + 10
                                       6,  1,   12,              // 5 + 1, 255 + 2, 9 + 3
                                       10, 12,  19,              // 3 + 7, (10 + 1) / 2 + 7, 12 + 7
                                       11, 13,  20};             // near up: 10, 12, 19
  EXPECT_EQ(image.values, expected);
  EXPECT_THROW(DecodePngBands(PngOf({{5, 1, 2, 3}})), InputError);
}

// A chunk with its checksum: damage that was made with care.
std::vector<unsigned char> WithHeaderByte(std::vector<unsigned char> png, std::size_t at,
                                          unsigned char value) {
  constexpr std::size_t kType = 12, kLength = 13;
  png[kType + 4 + at] = value;
  const auto sum = libdeflate_crc32(0, &png[kType], kLength + 4);
  for (std::size_t i = 0; i < 4; ++i)
    png[kType + 4 + kLength + i] = static_cast<unsigned char>(sum >> (24 - 8 * i));
  return png;
}

TEST(PngBands, WhatTheHeaderClaimsIsNotBelieved) {
  std::mt19937 random(TestSeed());
  const auto png = EncodePngBands({Noise(40, 30, 255, random)}, 8);
  EXPECT_NO_THROW(DecodePngBands(WithHeaderByte(png, 8, 8)));
  EXPECT_THROW(DecodePngBands(WithHeaderByte(png, 0, 0x7f)), InputError);  // width
  EXPECT_THROW(DecodePngBands(WithHeaderByte(png, 3, 0)), InputError);
  EXPECT_THROW(DecodePngBands(WithHeaderByte(png, 9, 3)), InputError);   // a palette
  EXPECT_THROW(DecodePngBands(WithHeaderByte(png, 9, 6)), InputError);   // alpha
  EXPECT_THROW(DecodePngBands(WithHeaderByte(png, 12, 1)), InputError);  // interlaced
  for (const int rows : {1, 29, 31, 255}) {
    try {
      EXPECT_EQ(DecodePngBands(WithHeaderByte(png, 7, static_cast<unsigned char>(rows)))[0].height,
                rows);
    } catch (const InputError&) {
    }
  }
}

TEST(PngBands, TransparencyIsRefused) {
  auto png = PngOf({{0, 1, 2, 3}});
  constexpr std::size_t kEnd = 12;  // bytes of the last chunk, which is empty
  png.resize(png.size() - kEnd);
  AppendChunk("tRNS", {0, 2}, png);  // of the grey value 2
  AppendChunk("IEND", {}, png);
  EXPECT_THROW(DecodePngBands(png), InputError);
}

TEST(PngBands, SidesHaveALimit) {
  EXPECT_EQ(DecodePngBands(EncodePngBands({Image(4096, 1)}, 8))[0].width, 4096);
  EXPECT_THROW(DecodePngBands(EncodePngBands({Image(4097, 1)}, 8)), InputError);
  EXPECT_THROW(DecodePngBands(EncodePngBands({Image(1, 4097)}, 8)), InputError);
}

TEST(PngBands, BandsOfDifferentSizesAreRefused) {
  EXPECT_THROW(EncodePngBands({Image(3, 3), Image(3, 3), Image(3, 4)}, 8), std::invalid_argument);
  EXPECT_THROW(EncodePngBands({Image(3, 3), Image(3, 3)}, 8), std::invalid_argument);
  EXPECT_THROW(EncodePngBands({}, 8), std::invalid_argument);
}

}  // namespace
}  // namespace orient
