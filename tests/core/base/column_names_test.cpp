#include "core/base/column_names.h"

#include <gtest/gtest.h>

namespace orient {
namespace {

TEST(WithoutImageEnding, LosesAnImagesEndingAndNoOtherPoint) {
  EXPECT_EQ(WithoutImageEnding("dir/4711.tif"), "4711");
  EXPECT_EQ(WithoutImageEnding("0182.v2"), "0182.v2");
  EXPECT_EQ(WithoutImageEnding("flug.0001.TIF"), "flug.0001");
}

TEST(WithoutImageEnding, LosesTheFolderOfAWindowsPath) {
  EXPECT_EQ(WithoutImageEnding("D:\\flug\\bild1.tif"), "bild1");
  EXPECT_EQ(WithoutImageEnding("\\\\server\\flug\\bild1"), "bild1");
  EXPECT_EQ(WithoutImageEnding("bild\\1"), "bild\\1") << "a name here";
}

TEST(BareImageName, LosesEveryFolder) {
  EXPECT_EQ(BareImageName("flight/4711"), "4711");
  EXPECT_EQ(BareImageName("flight/flug.0001.tif"), "flug.0001");
  EXPECT_EQ(BareImageName("4711"), "4711");
}

TEST(ColumnOfOtherUnit, IsNamedWithoutIt) {
  EXPECT_EQ(ColumnOfOtherUnit("Z [ft]"), "z");
  EXPECT_EQ(ColumnOfOtherUnit("height_feet"), "z");
  EXPECT_EQ(ColumnOfOtherUnit("Omega(gon)"), "omega");
  EXPECT_EQ(ColumnOfOtherUnit("kappa rad"), "kappa");
  EXPECT_EQ(ColumnOfOtherUnit("height_above_ground"), "");
  EXPECT_EQ(ColumnOfOtherUnit("z"), "");
  EXPECT_EQ(ColumnOfOtherUnit("z_"), "");
  EXPECT_EQ(ColumnOfOtherUnit(""), "");
}

TEST(NamesAngle, OfAnyConventionAndUnit) {
  for (const char* name :
       {"kappa_rad", "K [gon]", "Yaw", "heading (deg)", "ROLL", "pitch", "Azimuth"})
    EXPECT_TRUE(NamesAngle(name)) << name;
  for (const char* name : {"", "photographer", "sigma_kappa", "rollfilm", "z [ft]"})
    EXPECT_FALSE(NamesAngle(name)) << name;
}

}  // namespace
}  // namespace orient
