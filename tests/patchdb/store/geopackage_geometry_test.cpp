#include "patchdb/store/geopackage_geometry.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace orient::patchdb {
namespace {

TEST(GeoPackagePoint, Roundtrip) {
  const Eigen::Vector3d point(500123.25, 5000321.5, -12.125);
  const auto blob = EncodePointZ(point, 32635);
  EXPECT_EQ(blob.size(), 37u);
  EXPECT_EQ(DecodePointZ(blob.data(), blob.size()), point);
}

TEST(GeoPackagePoint, BytesAreTheOnesOfTheStandard) {
  const auto blob = EncodePointZ({1, 2, 3}, 32635);
  const std::vector<unsigned char> head = {'G', 'P', 0, 1, 0x7b, 0x7f, 0, 0, 1, 0xe9, 3, 0, 0};
  EXPECT_TRUE(std::equal(head.begin(), head.end(), blob.begin()));
  EXPECT_EQ(blob[13 + 6], 0xf0);  // 1.0 = 0x3ff0000000000000, little-endian
  EXPECT_EQ(blob[13 + 7], 0x3f);
}

TEST(GeoPackagePoint, BigEndianWithEnvelopeIsRead) {
  const auto little = EncodePointZ({1, 2, 3}, 5);
  std::vector<unsigned char> blob = {'G', 'P', 0, 2, 0, 0, 0, 5};  // big-endian, xy envelope
  blob.resize(8 + 32, 0);
  blob.insert(blob.end(), {0, 0, 0, 3, 0xe9});
  for (int i = 0; i < 3; ++i)
    for (int k = 7; k >= 0; --k) blob.push_back(little[static_cast<std::size_t>(13 + 8 * i + k)]);
  EXPECT_EQ(DecodePointZ(blob.data(), blob.size()), Eigen::Vector3d(1, 2, 3));
}

TEST(GeoPackagePoint, EveryTruncationIsRefused) {
  const auto blob = EncodePointZ({1, 2, 3}, 5);
  for (std::size_t size = 0; size < blob.size(); ++size)
    EXPECT_FALSE(DecodePointZ(blob.data(), size)) << size;
  EXPECT_FALSE(DecodePointZ(nullptr, 0));
}

TEST(GeoPackagePoint, OtherGeometriesAndNotANumberAreRefused) {
  auto blob = EncodePointZ({1, 2, 3}, 5);
  blob[9] = 2;  // line string
  blob[10] = 0;
  EXPECT_FALSE(DecodePointZ(blob.data(), blob.size()));
  const auto nan = EncodePointZ({std::nan(""), 2, 3}, 5);
  EXPECT_FALSE(DecodePointZ(nan.data(), nan.size()));
}

}  // namespace
}  // namespace orient::patchdb
