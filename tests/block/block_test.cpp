#include "block/block.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <string>

#include "core/base/atomic_write.h"
#include "core/geometry/collinearity.h"
#include "core/raster/raster.h"
#include "patchdb/store/patch_database.h"
#include "tests/support/dem_files.h"
#include "tests/support/shared_data.h"

namespace orient::block {
namespace {

constexpr int kSide_px = 200;
constexpr double kPixel_mm = 0.5, kGround_m = 300;

// Two photos without any texture and a database without patches: six surveyed points in each of
// them, none in both, are all that orients them.
class TwoBlankPhotos : public testing::Test {
 protected:
  TwoBlankPhotos() {
    camera_.camera.name = "blank";
    camera_.camera.kind = CameraKind::kDigital;
    camera_.camera.principal_distance_mm = 100;
    camera_.camera.frame_mm = Eigen::Vector2d::Constant(kSide_px * kPixel_mm);
    camera_.camera.image_px = {kSide_px, kSide_px};
    WriteCameraFile(folder_ / "camera.toml", camera_);
    for (const auto& [photo, pose] : truth_)
      WritePng(folder_ / (photo + ".png"), kSide_px, kSide_px, 1,
               std::vector<unsigned char>(kSide_px * kSide_px, 128));
    DemFile dem;
    dem.heights = Eigen::MatrixXf::Constant(60, 60, kGround_m);
    dem.west = 498500;
    dem.north = 5001500;
    dem.cell_x = dem.cell_y = 50;
    WriteDem(folder_ / "dem", dem);
    patchdb::PatchDatabase::Create(folder_ / "patches.gpkg", Crs::Parse("EPSG:32635", "test"));
    for (int i = 0; i < 6; ++i) {
      Survey("west", "w" + std::to_string(i), {499600 + 90 * (i % 3), 4999700 + 600 * (i / 3)});
      Survey("east", "e" + std::to_string(i), {500620 + 90 * (i % 3), 4999700 + 600 * (i / 3)});
    }
  }

  void See(const std::string& photo, const std::string& point, const Eigen::Vector2d& place) {
    const Eigen::Vector2d mm =
        PhotoFromGround(camera_.camera, truth_.at(photo), {place.x(), place.y(), kGround_m})
            .value();
    measurements_.image_points.push_back(
        {photo,
         point,
         Eigen::Vector2d(kSide_px / 2.0 + mm.x() / kPixel_mm, kSide_px / 2.0 - mm.y() / kPixel_mm),
         std::nullopt,
         0.2,
         {}});
  }
  void Survey(const std::string& photo, const std::string& point, const Eigen::Vector2d& place) {
    See(photo, point, place);
    measurements_.points.push_back({point,
                                    {place.x(), place.y(), kGround_m},
                                    Eigen::Vector3d::Constant(0.2),
                                    PointRole::kControl,
                                    {}});
  }
  void SeeTies() {
    for (int i = 0; i < 12; ++i)
      for (const char* photo : {"west", "east"})
        See(photo, "t" + std::to_string(i), {499950 + 90 * (i % 4), 4999750 + 250 * (i / 4)});
  }
  OrientedBlock Oriented() const {
    WriteImagePoints(folder_.Path(), measurements_.image_points);
    WritePoints(folder_.Path(), measurements_.points);
    WriteFileAtomically(folder_ / "block.toml",
                        "crs = \"EPSG:32635\"\ndem = \"dem.vrt\"\npatchdb = \"patches.gpkg\"\n"
                        "camera = \"camera.toml\"\nphotos = [\"*.png\"]\nmeasurements = \".\"\n"
                        "earth = \"flat\"\n");
    const BlockInputs inputs({.block = ReadBlockFile(folder_ / "block.toml"), .jobs = 1});
    return Orient(inputs, BlockFolder(inputs.OutputDirectory(), false));
  }

  const TemporaryFolder folder_;
  const std::map<std::string, Pose> truth_ = {{"west", {{499900, 5000000, 1300}, {0.01, 0, 0}}},
                                              {"east", {{500350, 5000000, 1300}, {0, 0.01, 0}}}};
  CameraFile camera_;
  Measurements measurements_;
};

TEST_F(TwoBlankPhotos, AreAdjustedByTiesThatWereMeasuredByHand) {
  SeeTies();
  const OrientedBlock block = Oriented();
  ASSERT_TRUE(block.adjusted);
  EXPECT_EQ(block.summary->ties, 12);
  for (const ExteriorResult& result : block.results) {
    ASSERT_TRUE(result.pose) << JoinedSentences(result.findings);
    ASSERT_TRUE(result.ties);
    EXPECT_EQ(result.ties->used, 12);
    ASSERT_TRUE(result.alone && result.alone->covariance);
    EXPECT_LT((*result.covariance)(0, 0), (*result.alone->covariance)(0, 0));
  }
}

TEST_F(TwoBlankPhotos, KeepTheirOwnResultsWhereNoPointIsInBoth) {
  const OrientedBlock block = Oriented();
  EXPECT_FALSE(block.adjusted);
  for (const ExteriorResult& result : block.results) EXPECT_TRUE(result.pose);
}

}  // namespace
}  // namespace orient::block
