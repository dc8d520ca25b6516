#include "block/stages/exterior_job.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <limits>
#include <numbers>

#include "patchdb/store/patch_database.h"
#include "tests/support/made_up_patches.h"
#include "tests/support/textured_photo.h"

namespace orient::block {
namespace {

using exterior::HillsAt;
using exterior::TexturedPhoto;

constexpr int kSide = 260;

// Made once for all tests: a photo, and patch databases of its ground and of another place's.
class Ground {
 public:
  Ground() {
    const auto around = world.File().Around(Eigen::Vector2d::Constant(kSide / 2.0),
                                            Eigen::Vector2d::Constant(kSide / 2.0), 1);
    std::vector<unsigned char> grey;
    for (int row = 0; row < kSide; ++row)
      for (int col = 0; col < kSide; ++col) {
        const Eigen::Vector2d origin = around.RasterFromImage(Eigen::Vector2d::Zero());
        grey.push_back(static_cast<unsigned char>(around.image.At(
            col - static_cast<int>(origin.x()), row - static_cast<int>(origin.y()))));
      }
    WritePng(photo, kSide, kSide, 1, grey);
    Store(patchdb, world.Patches(world.Ground(), 4, 60));
    Store(of_another_place, world.Patches(Texture(6, 6), 1, 100));
    Store(empty, {});
  }

 private:
  TemporaryFolder folder_;
  static void Store(const std::string& path, std::vector<patchdb::Patch> patches) {
    patchdb::PatchDatabase database = patchdb::PatchDatabase::Create(path, MadeUpCrs());
    for (patchdb::Patch& patch : patches) {
      patch.id = 0;
      patch.covariance_m2 = 0.04 * Eigen::Matrix3d::Identity();
    }
    patchdb::PatchSource source = MadeUpSource("1990.tif");
    if (!patches.empty()) database.AddSource(source, patches);
  }

 public:
  const TexturedPhoto world{kSide, HillsAt, false};
  const std::string photo = folder_ / "4711.png";
  const std::string patchdb = folder_ / "patches.gpkg", empty = folder_ / "empty.gpkg",
                    of_another_place = folder_ / "elsewhere.gpkg";
};

const Ground& TheGround() {
  static const Ground ground;
  return ground;
}

Eigen::MatrixXf Heights() {
  Eigen::MatrixXf heights(150, 150);
  for (int row = 0; row < 150; ++row)
    for (int col = 0; col < 150; ++col)
      heights(row, col) =
          static_cast<float>(HillsAt(20 * (col + 0.5) - 1500, 1500 - 20 * (row + 0.5)));
  return heights;
}

// A digital photo whose approximation is good to 10 m and a degree, as is said of it.
class OrientFromFilesTest : public testing::Test {
 protected:
  OrientFromFilesTest() {
    options_.photos = {TheGround().photo};
    options_.patchdb = TheGround().patchdb;
    options_.dem = "dem.tif";
    options_.out = folder_.Path();
    row_.photo = "4711";
    row_.pose = truth_;
    row_.pose.position_m += Eigen::Vector3d(8, -7, 5);
    row_.pose.opk_rad += Eigen::Vector3d(0.015, -0.012, 0.02);
    SetSigma(10, 0.02, 0.02);
  }
  void SetSigma(double position_m, double tilt_rad, double kappa_rad) {
    Vector6d sigma;
    sigma << position_m, position_m, position_m, tilt_rad, tilt_rad, kappa_rad;
    row_.sigma = sigma;
  }

  // Of the DEM, a square about the ground's origin.
  void MakeHole(double half_m) {
    const int nodes = static_cast<int>(half_m / 20);
    heights_.block(75 - nodes, 75 - nodes, 2 * nodes, 2 * nodes)
        .setConstant(std::numeric_limits<float>::quiet_NaN());
  }

  ExteriorResult Orient(const std::string& path = TheGround().photo) const {
    CameraFile camera;
    camera.camera = TheGround().world.View().camera;
    camera.camera.image_px = image_px_;
    OrientationTable table;
    table.rows = {row_};
    const ExteriorSetting setting{options_,
                                  camera,
                                  0,
                                  {},
                                  table,
                                  MadeUpCrs(),
                                  GroundSurface::FromGrid(heights_, -1500, 1500, 20)};
    ExteriorResult result = OrientFromFiles(setting, path);
    EXPECT_EQ(result.status == Status::kFailed, !result.pose);
    EXPECT_EQ(result.photo, std::filesystem::path(path).stem());
    return result;
  }
  // The first round of a search of the whole photo has it all for its window.
  static bool IsSearchedWhole(const ExteriorResult& result) {
    return !result.iterations.empty() && result.iterations[0].window_px == kSide / 2.0;
  }
  static void ExpectFailed(const ExteriorResult& result, const std::vector<Reason>& reasons) {
    EXPECT_EQ(result.status, Status::kFailed);
    std::vector<Reason> said;
    for (const Finding& finding : result.findings) said.push_back(finding.reason);
    EXPECT_EQ(said, reasons) << JoinedSentences(result.findings);
  }
  double OffPosition(const ExteriorResult& result) const {
    return result.pose ? (result.pose->position_m - truth_.position_m).norm() : 1e9;
  }

  const Pose truth_ = TheGround().world.View().pose;
  const TemporaryFolder folder_;
  ExteriorRunOptions options_;
  OrientationRow row_;
  Eigen::MatrixXf heights_ = Heights();
  Eigen::Vector2i image_px_ = Eigen::Vector2i(kSide, kSide);
};

TEST_F(OrientFromFilesTest, AGoodApproximationIsSearchedWithinItsAccuracy) {
  const ExteriorResult result = Orient();
  EXPECT_EQ(result.status, Status::kOk) << JoinedSentences(result.findings);
  EXPECT_LT(OffPosition(result), 1);
  EXPECT_FALSE(IsSearchedWhole(result));
  EXPECT_EQ(result.width, kSide);
  EXPECT_EQ(result.height, kSide);
  EXPECT_GT(result.footprint_m.size(), 4u);
  EXPECT_TRUE(std::filesystem::exists(folder_ / "4711.patches.png"));
}

TEST_F(OrientFromFilesTest, WhereKappaIsOpenTheWholePhotoIsSearched) {
  row_.pose.opk_rad = {0, 0, 0};
  SetSigma(20, 0.1, std::numbers::pi);
  const ExteriorResult result = Orient();
  EXPECT_EQ(result.status, Status::kOk) << JoinedSentences(result.findings);
  EXPECT_LT(OffPosition(result), 1);
  EXPECT_TRUE(IsSearchedWhole(result));
}

TEST_F(OrientFromFilesTest, AnApproximationThatIsWrongIsSearchedWholeNextAndThePoseIsWeak) {
  row_.pose.opk_rad.z() += 1.5;
  const ExteriorResult result = Orient();
  EXPECT_EQ(result.status, Status::kWeak);
  EXPECT_LT(OffPosition(result), 1);
  EXPECT_TRUE(IsSearchedWhole(result));
  EXPECT_TRUE(Has(result.findings, Reason::kContradictsApproximation));
}

TEST_F(OrientFromFilesTest, WhatIsFoundNeitherWayIsToldInTheOrderOfTheSearches) {
  options_.patchdb = TheGround().of_another_place;
  ExpectFailed(Orient(), {Reason::kNoConsensus, Reason::kNothingAlikeAfterPrior,
                          Reason::kHarvestMoreDensely});
}

TEST_F(OrientFromFilesTest, WhatIsNotFoundInTheWholePhotoIsToldOnce) {
  options_.patchdb = TheGround().of_another_place;
  SetSigma(20, 0.1, std::numbers::pi);
  ExpectFailed(Orient(), {Reason::kNothingAlike, Reason::kHarvestMoreDensely});
}

// Ten metres and three degrees that nobody stated are no reason to doubt the patches.
TEST_F(OrientFromFilesTest, APoseFarFromItsApproximationIsWeakOnlyWhereItsAccuracyIsStated) {
  row_.pose = truth_;
  row_.pose.position_m.x() += 62;
  ExteriorResult stated = Orient();
  EXPECT_EQ(stated.status, Status::kWeak) << JoinedSentences(stated.findings);
  EXPECT_TRUE(Has(stated.findings, Reason::kContradictsApproximation));
  EXPECT_FALSE(IsSearchedWhole(stated));
  options_.accuracy_is_stated = false;
  EXPECT_EQ(Orient().status, Status::kOk);
  options_.accuracy_is_stated = true;
  row_.sigma.reset();
  const ExteriorResult assumed = Orient();
  EXPECT_EQ(assumed.status, Status::kOk) << JoinedSentences(assumed.findings);
  EXPECT_TRUE(Has(assumed.findings, Reason::kContradictsApproximation)) << "it is said";
  options_.position_sigma_m = 10;
  EXPECT_EQ(Orient().status, Status::kWeak) << "stated for all photos";
}

TEST_F(OrientFromFilesTest, WithoutARowInTheTableHasNoApproximation) {
  row_.photo = "4712";
  options_.approximations = "approx.csv";
  const ExteriorResult by_table = Orient();
  ExpectFailed(by_table, {Reason::kNoApproximation});
  EXPECT_EQ(by_table.findings[0].where.find("approx.csv has no row '4711'"), 0u);
  options_.approximations.clear();
  const ExteriorResult by_file = Orient();
  ExpectFailed(by_file, {Reason::kNoApproximation});
  EXPECT_NE(by_file.findings[0].where.find("EXIF"), std::string::npos);
}

TEST_F(OrientFromFilesTest, AnApproximationBelowTheGroundIsSaidToBeThere) {
  row_.pose = {{200, 100, -40}, {0, 0, 0}};
  options_.approximations = "approx.csv";
  const ExteriorResult result = Orient();
  ExpectFailed(result, {Reason::kBelowGround});
  EXPECT_EQ(result.findings[0].value, -40);
  EXPECT_NEAR(*result.findings[0].limit, HillsAt(200, 100), 1);
  EXPECT_EQ(result.findings[0].where, " in approx.csv");
}

TEST_F(OrientFromFilesTest, AnApproximationOutsideTheDemIsSaidToBeThere) {
  row_.pose.position_m.x() = 5000;
  const ExteriorResult result = Orient();
  ExpectFailed(result, {Reason::kOutsideDem});
  EXPECT_NE(result.findings[0].where.find("dem.tif does not cover the photo"), std::string::npos);
  EXPECT_NE(result.findings[0].where.find("x 5000"), std::string::npos);
}

TEST_F(OrientFromFilesTest, AHoleInTheDemUnderThePhotosCentreCostsItNothing) {
  const ExteriorResult without = Orient();
  MakeHole(160);
  const ExteriorResult result = Orient();
  EXPECT_EQ(result.status, Status::kOk) << JoinedSentences(result.findings);
  ASSERT_TRUE(result.pose && without.pose);
  EXPECT_LT((result.pose->position_m - without.pose->position_m).norm(), 0.1);
}

TEST_F(OrientFromFilesTest, ADemWithoutAnyHeightInTheFrameIsNamed) {
  MakeHole(700);
  const ExteriorResult result = Orient();
  ExpectFailed(result, {Reason::kOutsideDem});
  EXPECT_NE(result.findings[0].where.find("no height anywhere in the frame"), std::string::npos);
}

TEST_F(OrientFromFilesTest, AnApproximationBelowAHoleAndAllGroundIsBelowTheGround) {
  row_.pose = {{0, 0, -40}, {0, 0, 0}};
  MakeHole(160);
  ExpectFailed(Orient(), {Reason::kBelowGround});
}

// Four points, of which one is 40 px off: too few to tell which.
TEST_F(OrientFromFilesTest, PointsThatContradictOneAnotherAreDrawnOnTheScan) {
  row_.photo = "another";
  const PhotoView view = TheGround().world.View();
  for (const Eigen::Vector2d& at : {Eigen::Vector2d(-150, -140), Eigen::Vector2d(160, -150),
                                    Eigen::Vector2d(-140, 150), Eigen::Vector2d(150, 160)}) {
    const std::string name = "p" + std::to_string(options_.measurements.points.size());
    const Eigen::Vector3d ground(at.x(), at.y(), HillsAt(at.x(), at.y()));
    Eigen::Vector2d pixel = view.PixelFromGround(ground).value();
    if (name == "p0") pixel.x() += 40;
    options_.measurements.points.push_back({name, ground, Eigen::Vector3d::Constant(0.5)});
    options_.measurements.image_points.push_back({"4711", name, pixel, std::nullopt, 1, {}});
  }
  ExpectFailed(Orient(), {Reason::kPointsOnNoPose});
  EXPECT_TRUE(std::filesystem::exists(folder_ / "4711.patches_overview.png"));
}

// Eight points all over the photo, whose coordinates are those of another datum.
class PointsOfAnotherDatum : public OrientFromFilesTest {
 protected:
  void Measure(const Eigen::Vector3d& datum_m) {
    const PhotoView view = TheGround().world.View();
    for (int i = 0; i < 8; ++i) {
      const Eigen::Vector2d at(-170 + 113 * (i % 4), -150 + 290 * (i / 4) + 17 * (i % 3));
      const std::string name = "p" + std::to_string(i);
      const Eigen::Vector3d ground(at.x(), at.y(), HillsAt(at.x(), at.y()));
      options_.measurements.points.push_back(
          {name, ground + datum_m, Eigen::Vector3d::Constant(0.1)});
      options_.measurements.image_points.push_back(
          {"4711", name, view.PixelFromGround(ground).value(), std::nullopt, 0.2, {}});
    }
  }
};

TEST_F(PointsOfAnotherDatum, AreOutweighedByPatchesWhereTheApproximationIs) {
  Measure({30, 30, 0});
  const ExteriorResult result = Orient();
  EXPECT_EQ(result.status, Status::kWeak);
  EXPECT_LT(OffPosition(result), 1);
  EXPECT_TRUE(Has(result.findings, Reason::kPointsOffPose)) << JoinedSentences(result.findings);
  EXPECT_FALSE(Has(result.findings, Reason::kStartedByPoints));
}

TEST_F(PointsOfAnotherDatum, WithoutPatchesContradictTheApproximation) {
  options_.patchdb = TheGround().empty;
  Measure({0, 0, 0});
  options_.target_m = 3;
  const ExteriorResult right = Orient();
  EXPECT_EQ(right.status, Status::kOk) << JoinedSentences(right.findings);
  options_.measurements = {};
  Measure({300, 300, 0});
  const ExteriorResult wrong = Orient();
  EXPECT_EQ(wrong.status, Status::kWeak);
  EXPECT_TRUE(Has(wrong.findings, Reason::kContradictsApproximation));
}

TEST_F(PointsOfAnotherDatum, OfHeightsContradictTheDem) {
  options_.patchdb = TheGround().empty;
  options_.target_m = 3;
  row_.photo = "another";  // no approximation
  Measure({0, 0, 40});
  const ExteriorResult result = Orient();
  EXPECT_EQ(result.status, Status::kWeak);
  ASSERT_TRUE(Has(result.findings, Reason::kPointsOffDem)) << JoinedSentences(result.findings);
  for (const Finding& finding : result.findings)
    if (finding.reason == Reason::kPointsOffDem) {
      EXPECT_NEAR(*finding.value, 40, 2);
      EXPECT_EQ(finding.where, "below");
    }
}

// Its result had no name, and a block waited for it without end.
TEST_F(OrientFromFilesTest, PointsThatHardlyDetermineAPoseGiveOneThatSaysSo) {
  options_.patchdb = TheGround().empty;
  row_.photo = "another";
  const PhotoView view = TheGround().world.View();
  for (int i = 0; i < 4; ++i) {
    const Eigen::Vector2d at(20 * (i % 2), 20 * (i / 2));
    const std::string name = "p" + std::to_string(i);
    const Eigen::Vector3d ground(at.x(), at.y(), HillsAt(at.x(), at.y()));
    options_.measurements.points.push_back({name, ground, Eigen::Vector3d::Constant(1)});
    options_.measurements.image_points.push_back(
        {"4711", name, view.PixelFromGround(ground).value(), std::nullopt, 1, {}});
  }
  const ExteriorResult result = Orient();
  EXPECT_EQ(result.photo, "4711");
  EXPECT_EQ(result.status, Status::kWeak);
  EXPECT_TRUE(Has(result.findings, Reason::kByPointsAlone)) << JoinedSentences(result.findings);
}

TEST_F(OrientFromFilesTest, WithoutPatchesUnderItSaysWhichDatabaseHasNone) {
  options_.patchdb = TheGround().empty;
  ExteriorResult result = Orient();
  ExpectFailed(result, {Reason::kNoPatches});
  EXPECT_EQ(result.findings[0].where, options_.patchdb);
  SetSigma(20, 0.1, std::numbers::pi);
  ExpectFailed(Orient(), {Reason::kNoPatches});
  EXPECT_TRUE(std::filesystem::exists(folder_ / "4711.patches_overview.png"));
}

TEST_F(OrientFromFilesTest, PatchesLentByNeighboursDo) {
  options_.patchdb = TheGround().empty;
  Bounds asked = Bounds::OfNothing();
  options_.further_patches = [&](const std::string& photo, const Bounds& footprint) {
    EXPECT_EQ(photo, "4711");
    asked = footprint;
    return TheGround().world.Patches(TheGround().world.Ground(), 4, 60);
  };
  const ExteriorResult result = Orient();
  EXPECT_EQ(result.status, Status::kOk) << JoinedSentences(result.findings);
  EXPECT_LT(asked.min_x, -250);
  EXPECT_GT(asked.max_x, 250);
}

TEST_F(OrientFromFilesTest, AScanThatCannotBeReadFailsThisPhotoOnly) {
  row_.photo = "gone";
  const ExteriorResult result = Orient(folder_ / "gone.tif");
  ExpectFailed(result, {Reason::kPhotoUnusable});
  EXPECT_NE(result.findings[0].where.find("gone.tif"), std::string::npos);
}

TEST_F(OrientFromFilesTest, AnImageOfAnotherSizeThanItsCamerasIsUnusableAndBothSizesAreSaid) {
  image_px_.x() += 1;
  const ExteriorResult result = Orient();
  ExpectFailed(result, {Reason::kPhotoUnusable});
  for (const char* said : {"4711.png", "260 x 260", "261 x 260"})
    EXPECT_NE(result.findings[0].where.find(said), std::string::npos) << said;
}

}  // namespace
}  // namespace orient::block
