// Where a person says that photos were taken, beside a table, strips and the flight's height.
#include "block/inputs/block_approximations.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <string>

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
    measurements_.decisions.push_back({photo, DecisionKind::kPosition, value, "", {}});
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
    return BlockApproximations(block, camera_, measurements_).Table();
  }

  TemporaryFolder folder_;
  Camera camera_;
  Measurements measurements_;
};

constexpr const char* kStrip = "[[strips]]\nphotos = [\"1\", \"2\", \"3\"]\n";

TEST_F(SaidInABlock, APhotoThatItsStripLocatesKeepsTheStripsHeightAndAngles) {
  const OrientationTable said = Known(kStrip);
  measurements_ = {};
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

// A block of the photos 1 to 3 over ground at 300 m, with this table.
class TableOfABlock : public SaidInABlock {
 protected:
  BlockApproximations Of(const std::string& table, const std::string& more) {
    WriteFileAtomically(folder_ / "approx.csv", table);
    WriteFileAtomically(folder_ / "block.toml",
                        "crs = \"EPSG:32635\"\ndem = \"dem.vrt\"\npatchdb = \"patches.gpkg\"\n"
                        "camera = \"camera.toml\"\nphotos = [\"1.tif\", \"2.tif\", \"3.tif\"]\n"
                        "approximations = \"approx.csv\"\n" +
                            more);
    block_ = ReadBlockFile(folder_ / "block.toml");
    return BlockApproximations(*block_, camera_);
  }
  std::optional<BlockFile> block_;
};

TEST_F(TableOfABlock, WithoutHeightsTheFlightTellsThem) {
  const std::string text = "filename,x,y\n1,503000,5005000\n2,503500,5005000\n";
  for (const char* flight : {"[flight]\nflying_height_m = 1530\n", "[flight]\nscale = 10000\n"}) {
    const OrientationTable table = Of(text, flight).Table();
    ASSERT_EQ(table.rows.size(), 2u);
    EXPECT_NEAR(table.rows[1].pose.position_m.z(), 1830, 1e-6) << flight;
    EXPECT_FALSE(table.rows[1].attitude_known);
  }
  ExpectError<InputError>([&] { Of(text, ""); }, {"approx.csv", "flying_height_m", "scale"});
}

TEST_F(TableOfABlock, ComputedHeightsAreNoObservations) {
  const auto known = Of("filename,x,y,z\n1,503000,5005000,1800\n2,503500,5005000,\n",
                        "[flight]\nflying_height_m = 1500\n[approximate_accuracy]\n"
                        "observe = true\nposition_m = 5\n");
  const auto& observed = known.Observations().approximations;
  EXPECT_EQ(observed.at("1").covariance(2, 2), 25);
  EXPECT_GT(observed.at("2").covariance(2, 2), 1e6);
}

TEST_F(TableOfABlock, ARowWithoutPositionIsRemarkedAndAbsent) {
  const auto known =
      Of("filename,x,y,z,omega,phi,kappa\n1,503000,5005000,1800,0,0,\n2,,,,,,\n", "");
  EXPECT_EQ(known.Table().Find("2"), nullptr);
  EXPECT_FALSE(known.Table().Find("1")->attitude_known);
  EXPECT_TRUE(Has(known.Remarks(), Reason::kRowsWithoutPosition));
}

TEST_F(TableOfABlock, GnssWithXAndYExchangedIsRefusedBeforeAnythingIsOriented) {
  WriteFileAtomically(folder_ / "gnss.csv", "filename,x,y,z\n1,5005000,503000,1800\n");
  ExpectError<InputError>(
      [&] {
        Of("filename,x,y,z\n1,503001,5005002,1800\n",
           "[gnss]\npositions = \"gnss.csv\"\nsigma_m = 0.1\n");
      },
      {"gnss.csv", "exchanged", "approx.csv"});
}

TEST_F(TableOfABlock, GnssRowsOfOtherPhotosAreNamedAsThoseOfTheTableAre) {
  WriteFileAtomically(folder_ / "gnss.csv",
                      "filename,x,y,z\nIMG_1,503000,5005000,1800\n2,503500,5005000,1800\n"
                      "not_scanned,504000,5005000,1800\n");
  const auto known = Of("filename,x,y,z\n1,503001,5005002,1800\nghost,500000,5005000,1800\n",
                        "[gnss]\npositions = \"gnss.csv\"\nsigma_m = 0.1\n[[strips]]\n"
                        "photos = [\"1\", \"2\", \"not_scanned\"]\n");
  EXPECT_EQ(known.NotThere(), (std::vector<std::string>{"ghost", "IMG_1"}));
  const Finding expected{.reason = Reason::kApproximationsOfOtherPhotos,
                         .value = 1,
                         .where = folder_ / "gnss.csv" + ": IMG_1"};
  EXPECT_EQ(std::count(known.Remarks().begin(), known.Remarks().end(), expected), 1);
}

TEST_F(TableOfABlock, TwoCamerasOfItsPhotosAreRefused) {
  const std::string text = "filename,x,y,z,camera\n1,503000,5005000,1800,c1\n";
  EXPECT_NO_THROW(Of(text + "ghost,503500,5005000,1800,c2\n", ""));
  ExpectError<InputError>([&] { Of(text + "2,503500,5005000,1800,c2\n", ""); },
                          {"approx.csv", "c1, c2"});
}

}  // namespace
}  // namespace orient::block
