#include "patchdb/store/patch_blobs.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/base/error.h"

namespace orient::patchdb {
namespace {

Image Ramp(int size, float step) {
  Image image(size, size);
  for (std::size_t i = 0; i < image.values.size(); ++i)
    image.values[i] = step * static_cast<float>(i);
  return image;
}

TEST(PatchBlobs, ChipsOfEightAndSixteenBitsAreLossless) {
  const Image small = Ramp(15, 1);
  EXPECT_EQ(DecodeChip(EncodeChip(small, 8), std::nullopt).values, small.values);
  const Image large = Ramp(15, 291);
  EXPECT_EQ(DecodeChip(EncodeChip(large, 16), std::nullopt).values, large.values);
}

TEST(PatchBlobs, OnlyAChipWithGapsHasAMask) {
  Image chip = Ramp(9, 2);
  EXPECT_FALSE(EncodeChipMask(chip));
  chip.At(3, 5) = kNoData;
  const auto mask = EncodeChipMask(chip);
  ASSERT_TRUE(mask);
  const Image read = DecodeChip(EncodeChip(chip, 8), mask);
  for (int row = 0; row < 9; ++row)
    for (int col = 0; col < 9; ++col) {
      EXPECT_EQ(std::isnan(read.At(col, row)), col == 3 && row == 5);
      if (!(col == 3 && row == 5)) {
        EXPECT_EQ(read.At(col, row), chip.At(col, row));
      }
    }
}

TEST(PatchBlobs, GreyValuesAreClampedToTheirBits) {
  Image chip(2, 2);
  chip.values = {-3.0f, 12.6f, 300.0f, 255.0f};
  EXPECT_EQ(DecodeChip(EncodeChip(chip, 8), std::nullopt).values,
            (std::vector<float>{0, 13, 255, 255}));
}

TEST(PatchBlobs, DamagedPngIsRefused) {
  Bytes png = EncodeChip(Ramp(15, 1), 8);
  EXPECT_THROW(DecodeChip(Bytes(png.begin(), png.begin() + 20), std::nullopt), InputError);
  EXPECT_THROW(DecodeChip({}, std::nullopt), InputError);
}

TEST(PatchBlobs, MaskOfAnotherSizeIsRefused) {
  Image other = Ramp(7, 1);
  other.At(0, 0) = kNoData;
  EXPECT_THROW(DecodeChip(EncodeChip(Ramp(9, 1), 8), EncodeChipMask(other)), InputError);
}

TEST(PatchBlobs, HeightsAreLittleEndianFloatsRowByRow) {
  HeightGrid grid{3, 2.5, {1, 2, 3, 4, 5, 6, 7, 8, kNoData}};
  const Bytes bytes = EncodeHeights(grid);
  ASSERT_EQ(bytes.size(), 36u);
  EXPECT_EQ(bytes[2], 0x80);  // 1.0f = 0x3f800000
  EXPECT_EQ(bytes[3], 0x3f);
  const HeightGrid read = DecodeHeights(bytes, 3, 2.5);
  EXPECT_TRUE(std::equal(read.heights_m.begin(), read.heights_m.end() - 1, grid.heights_m.begin()));
  EXPECT_TRUE(std::isnan(read.heights_m.back()));
}

TEST(PatchBlobs, HeightsArePackedIntoEightBitsWhereTheirRangeAllows) {
  for (const float range : {254.f, 255.f, 60000.f}) {
    const HeightGrid grid{3, 2.5, {700, 701, 702, kNoData, 704, 705, 706, 707, 700 + range}};
    const auto packed = PackHeights(grid, 1);
    ASSERT_TRUE(packed);
    EXPECT_EQ(packed->png[24], range < 255 ? 8 : 16);  // as the PNG's header says
    const HeightGrid read = UnpackHeights(*packed, 3, 2.5);
    for (std::size_t i = 0; i < 9; ++i)
      EXPECT_TRUE(i == 3 ? std::isnan(read.heights_m[i]) : read.heights_m[i] == grid.heights_m[i]);
  }
  EXPECT_FALSE(PackHeights({1, 1, {std::numeric_limits<float>::infinity()}}, 1));
  EXPECT_FALSE(PackHeights({3, 1, {0, 1, 2, 3, 4, 5, 6, 7, 65535}}, 1));
}

// What programs wrote before there were packed heights of 8 bits.
TEST(PatchBlobs, HeightsPackedInto16BitsAreReadWhateverTheirRange) {
  Image values(3, 3, 65535);
  for (std::size_t i = 0; i < 8; ++i) values.values[i] = static_cast<float>(250 + i);
  const HeightGrid read = UnpackHeights({EncodeChip(values, 16), 100, 0.5}, 3, 2);
  EXPECT_EQ(read.heights_m[5], 227.5f);  // 255 is a height
  EXPECT_TRUE(std::isnan(read.heights_m[8]));
}

TEST(PatchBlobs, ImpossibleHeightGridsAreRefused) {
  const Bytes nine(36);
  EXPECT_THROW(DecodeHeights(nine, 5, 1), InputError);
  EXPECT_THROW(DecodeHeights(nine, -3, 1), InputError);
  EXPECT_THROW(DecodeHeights(nine, 3, 0), InputError);
  EXPECT_THROW(DecodeHeights(nine, 2000000001, 1), InputError);
}

TEST(PatchBlobs, CovarianceRoundtripAndDamage) {
  Eigen::Matrix3d covariance;
  covariance << 4, 0.5, -0.25, 0.5, 3, 0.125, -0.25, 0.125, 9;
  const Bytes bytes = EncodeCovariance(covariance);
  EXPECT_EQ(bytes.size(), 48u);
  EXPECT_EQ(DecodeCovariance(bytes), covariance);
  EXPECT_THROW(DecodeCovariance(Bytes(40)), InputError);
  EXPECT_THROW(DecodeCovariance(EncodeCovariance(covariance * std::nan(""))), InputError);
  EXPECT_THROW(DecodeCovariance(EncodeCovariance(-covariance)), InputError);
  covariance(0, 1) = covariance(1, 0) = 4;  // of more than the two variances allow
  EXPECT_THROW(DecodeCovariance(EncodeCovariance(covariance)), InputError);
  EXPECT_THROW(DecodeCovariance(EncodeCovariance(Eigen::Matrix3d::Zero())), InputError);
  covariance = Eigen::Vector3d(1, 2, 3) * Eigen::RowVector3d(1, 2, 3);
  EXPECT_EQ(DecodeCovariance(EncodeCovariance(covariance)), covariance) << "singular, but right";
}

}  // namespace
}  // namespace orient::patchdb
