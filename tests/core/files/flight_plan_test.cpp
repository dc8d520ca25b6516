#include "core/files/flight_plan.h"

#include <gtest/gtest.h>

#include "core/base/atomic_write.h"
#include "core/base/error.h"
#include "core/files/block_file.h"
#include "core/geometry/rotation.h"
#include "tests/support/expect_error.h"
#include "tests/support/shared_data.h"

namespace orient {
namespace {

const std::string kBlock = R"(crs = "EPSG:32635"
dem = "dem.tif"
patchdb = "patches.gpkg"
camera = "camera.toml"
photos = ["*.tif"]
)";

class FlightPlanOf : public testing::Test {
 protected:
  FlightPlanOf() {
    for (const std::string name :
         {"patches.gpkg", "camera.toml", "a_1.tif", "a_2.tif", "a_10.tif", "b_1.tif", "dem.tif"})
      WriteFileAtomically(folder_ / name, "");
  }
  FlightPlan Read(const std::string& further) const {
    WriteFileAtomically(folder_ / "block.toml", kBlock + further);
    return ReadBlockFile(folder_ / "block.toml").flight;
  }
  void ExpectRefused(const std::string& further, std::initializer_list<std::string> parts) const {
    ExpectError<InputError>([&] { Read(further); }, parts);
  }
  const TemporaryFolder folder_;
};

TEST_F(FlightPlanOf, ABlockFileWithoutStripsIsEmpty) { EXPECT_TRUE(Read("").Empty()); }

TEST_F(FlightPlanOf, PatternsStandForPhotosInTheirNaturalOrder) {
  const FlightPlan plan = Read(
      "[[strips]]\nphotos = [\"a_*\"]\n[[strips]]\nname = \"B\"\nphotos = "
      "[\"b_1\", \"b_2.tif\"]\nazimuth_deg = 270\n");
  ASSERT_EQ(plan.strips.size(), 2u);
  EXPECT_EQ(plan.strips[0].name, "1");
  EXPECT_EQ(plan.strips[0].photos, (std::vector<std::string>{"a_1", "a_2", "a_10"}));
  EXPECT_FALSE(plan.strips[0].azimuth_rad);
  EXPECT_EQ(plan.strips[1].photos, (std::vector<std::string>{"b_1", "b_2"}))
      << "b_2 was not scanned";
  EXPECT_DOUBLE_EQ(*plan.strips[1].azimuth_rad, RadFromDeg(270));
  EXPECT_DOUBLE_EQ(plan.overlap, 0.6);
  EXPECT_DOUBLE_EQ(plan.side_lap, 0.3);
  EXPECT_TRUE(plan.back_and_forth);
}

TEST_F(FlightPlanOf, NamesMayHaveDots) {
  WriteFileAtomically(folder_ / "1961.0182.tif", "");
  const FlightPlan plan = Read("[[strips]]\nphotos = [\"1961.0182\", \"a_1.tif\"]\n");
  EXPECT_EQ(plan.strips.at(0).photos, (std::vector<std::string>{"1961.0182", "a_1"}));
}

TEST_F(FlightPlanOf, NumbersMayRunAgainstTheFlight) {
  const FlightPlan plan = Read("[[strips]]\nphotos = [\"a_*\"]\nreversed = true\n");
  EXPECT_EQ(plan.strips.at(0).photos, (std::vector<std::string>{"a_10", "a_2", "a_1"}));
}

TEST_F(FlightPlanOf, WhatAllStripsShareStandsInFlight) {
  const FlightPlan plan = Read(
      "[flight]\noverlap = 0.8\nside_lap = 0.2\nazimuth_deg = 12\nnext_strip = \"west\"\n"
      "back_and_forth = false\nscale = 20000\n");
  EXPECT_DOUBLE_EQ(plan.overlap, 0.8);
  EXPECT_DOUBLE_EQ(plan.side_lap, 0.2);
  EXPECT_EQ(*plan.next_strip, Eigen::Vector2d(-1, 0));
  EXPECT_FALSE(plan.back_and_forth);
  EXPECT_DOUBLE_EQ(*plan.FlyingHeight(150), 3000);
}

TEST_F(FlightPlanOf, MistakesNameStripAndPhoto) {
  ExpectRefused(
      "[[strips]]\nphotos = [\"a_1\", \"a_2\"]\n[[strips]]\nname = \"05\"\nphotos = "
      "[\"b_1\", \"a_2\"]\n",
      {"line", "strip 05", "photo a_2", "strip 1, too"});
  ExpectRefused("[[strips]]\nphotos = [\"a_1\", \"a_*\"]\n", {"strip 1", "a_1", "twice"});
  ExpectRefused("[[strips]]\nname = \"07\"\nphotos = [\"c_*\"]\n", {"strip 07", "c_*"});
  ExpectRefused("[[strips]]\nname = \"07\"\n", {"strip 07", "order of exposure"});
  ExpectRefused("[flight]\nnext_strip = \"left\"\n", {"next_strip", "left", "north"});
  ExpectRefused("[flight]\noverlap = 60\n", {"overlap", "0.95"});
  ExpectRefused("[flight]\nscale = 20000\nflying_height_m = 3000\n", {"scale", "one of them"});
}

TEST(NaturalOrder, CountsRunsOfDigits) {
  for (const auto& [a, b] : std::vector<std::pair<std::string, std::string>>{
           {"a2", "a10"}, {"a2", "a2b"}, {"a", "b"}, {"a09", "a10"}, {"1_9", "1_10"}, {"", "a"}}) {
    EXPECT_TRUE(NaturallyLess(a, b)) << a << " " << b;
    EXPECT_FALSE(NaturallyLess(b, a)) << a << " " << b;
  }
  EXPECT_FALSE(NaturallyLess("a2", "a2"));
  EXPECT_NE(NaturallyLess("a02", "a2"), NaturallyLess("a2", "a02")) << "an order of all names";
}

}  // namespace
}  // namespace orient
