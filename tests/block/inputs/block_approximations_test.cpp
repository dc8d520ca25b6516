// Where a person says that photos were taken, beside a table, strips and the flight's height.
#include "block/inputs/block_approximations.h"

#include <gtest/gtest.h>

#include "core/base/atomic_write.h"
#include "core/base/error.h"
#include "tests/support/dem_files.h"
#include "tests/support/expect_error.h"
#include "tests/support/shared_data.h"

namespace orient::block {
namespace {

class SaidInABlock : public testing::Test {
 protected:
  void SetUp() override {
    for (const std::string name : {"patches.gpkg", "camera.toml", "1.tif", "2.tif", "3.tif"})
      WriteFileAtomically(folder_ / name, "");
    DemFile dem;
    dem.heights = Eigen::MatrixXf::Constant(100, 100, 300);
    dem.west = 500000;
    dem.north = 5010000;
    dem.cell_x = dem.cell_y = 100;
    WriteDem(folder_ / "dem", dem);
    camera_.principal_distance_mm = 153;
    camera_.frame_mm = {230, 230};
    camera_.kind = CameraKind::kFilm;
    Say("3", "505100 5005200 60");
  }
  void Say(const std::string& photo, const std::string& value) {
    said_.decisions.push_back({photo, DecisionKind::kPosition, value, "", {}});
  }
  OrientationTable Known(const std::string& more, bool table = true) {
    if (table)
      WriteFileAtomically(folder_ / "approx.csv",
                          "filename,x,y,z,omega,phi,kappa\n1,503000,5005000,1800,0,0,90\n");
    WriteFileAtomically(folder_ / "block.toml",
                        "crs = \"EPSG:32635\"\ndem = \"dem.vrt\"\npatchdb = \"patches.gpkg\"\n"
                        "camera = \"camera.toml\"\nphotos = [\"1.tif\", \"2.tif\", \"3.tif\"]\n" +
                            std::string(table ? "approximations = \"approx.csv\"\n" : "") + more);
    const BlockFile block = ReadBlockFile(folder_ / "block.toml");
    return BlockApproximations(block, camera_, said_).Table();
  }

  TemporaryFolder folder_;
  Camera camera_;
  Measurements said_;
};

constexpr const char* kStrip = "[[strips]]\nphotos = [\"1\", \"2\", \"3\"]\n";

TEST_F(SaidInABlock, APhotoThatItsStripLocatesKeepsTheStripsHeightAndAngles) {
  const OrientationTable said = Known(kStrip);
  said_ = {};
  const OrientationTable unsaid = Known(kStrip);
  const OrientationRow& with = *said.Find("3");
  const OrientationRow& without = *unsaid.Find("3");
  EXPECT_EQ(with.pose.position_m.head<2>(), Eigen::Vector2d(505100, 5005200));
  EXPECT_EQ((*with.sigma)[0], 60);
  EXPECT_EQ(with.pose.position_m.z(), without.pose.position_m.z());
  EXPECT_EQ(with.pose.opk_rad, without.pose.opk_rad);
  EXPECT_EQ((*with.sigma)[2], (*without.sigma)[2]);
  EXPECT_EQ((*with.sigma)[5], (*without.sigma)[5]);
  EXPECT_EQ(said.rows.size(), 3u);
}

TEST_F(SaidInABlock, WithoutATableTheFlightTellsTheHeight) {
  const OrientationTable said = Known("[flight]\nflying_height_m = 1500\n", false);
  ASSERT_EQ(said.rows.size(), 1u);
  EXPECT_NEAR(said.rows[0].pose.position_m.z(), 1800, 1e-6);
  EXPECT_FALSE(said.rows[0].attitude_known);
}

TEST_F(SaidInABlock, WhereNothingTellsAHeightTheDecisionIsNamed) {
  ExpectError<InputError>([&] { Known("", false); },
                          {"decisions.csv", "photo 3", "flying_height_m"});
}

}  // namespace
}  // namespace orient::block
