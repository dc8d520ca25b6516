// Real photos whose approximations are worth little or are wrong: found all the same, or refused in
// words that say what is wrong.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <numbers>
#include <random>

#include "core/base/atomic_write.h"
#include "tests/support/ngi.h"
#include "tests/support/run_orient.h"
#include "tests/support/shared_data.h"
#include "tools/simulate/geotiff.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

// How wrong the approximations are, and how wrong they say they are.
struct Start {
  double position_m, tilt_deg, turn_deg;
  double stated = 1;  // times the error
};
constexpr Start kKilometres{2000, 10, 137};

class WideSearch : public testing::Test {
 protected:
  void SetUp() override {
    const auto data = SharedData("ngi");
    if (!data) GTEST_SKIP() << "real data absent (ORIENT_SHARED_DATA): ngi";
    ngi_.emplace(*data);
    camera_ = ngi_->folder + "/camera.toml";
    dem_ = ngi_->folder + "/dem.tif";
  }

  void Harvest(const std::vector<std::string>& numbers) {
    fs::remove(folder_ / "patches.gpkg");
    Run({"patchdb", "create", folder_ / "patches.gpkg", "--crs", ngi_->CrsFile()});
    std::vector<std::string> arguments = {
        "patchdb", "harvest-ortho", folder_ / "patches.gpkg", "--dem", dem_, "--ortho"};
    for (const std::string& number : numbers) arguments.push_back(ngi_->Orthophoto(number));
    Run(arguments);
  }

  void WriteStart(const Start& start, unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> unit(-1, 1);
    OrientationTable table = ngi_->published;
    for (OrientationRow& row : table.rows) {
      const Eigen::Rotation2Dd east(std::numbers::pi * unit(random));
      const Eigen::Rotation2Dd tilt(std::numbers::pi * unit(random));
      const double height_m = std::min(start.position_m, 900.0);
      row.pose.position_m.head<2>() += east * Eigen::Vector2d(start.position_m, 0);
      row.pose.position_m.z() += height_m * unit(random);
      row.pose.opk_rad.head<2>() += tilt * Eigen::Vector2d(RadFromDeg(start.tilt_deg), 0);
      row.pose.opk_rad.z() =
          NormalizeAngle(row.pose.opk_rad.z() + RadFromDeg(start.turn_deg) * unit(random));
      Vector6d sigma;
      sigma << start.position_m, start.position_m, height_m, RadFromDeg(start.tilt_deg),
          RadFromDeg(start.tilt_deg), RadFromDeg(start.turn_deg > 90 ? 180 : start.turn_deg);
      row.sigma = start.stated * sigma;
    }
    WriteOrientationTable(folder_ / "approx.csv", table);
  }

  ExteriorResult Orient(const std::string& photo) {
    const ProgramRun run =
        RunOrient({"exterior", photo, "--camera", camera_, "--approximations",
                   folder_ / "approx.csv", "--dem", dem_, "--patchdb", folder_ / "patches.gpkg",
                   "--out", folder_ / "out", "--overwrite", "--no-feedback"});
    EXPECT_NE(run.exit_code, 2) << run.err;
    ExteriorResult result =
        ReadExteriorResult(ExteriorResultPath(folder_ / "out", PhotoName(photo)));
    for (const std::string& message : Sentences(result.findings))
      std::printf("%s\n", message.c_str());
    return result;
  }

  void ExpectFound(const std::string& number, double max_rms_px) {
    const ExteriorResult result = Orient(ngi_->Photo(number));
    ASSERT_TRUE(result.pose) << number;
    ExpectOkOrPoorlyDetermined(result);
    std::printf("%s: frame rms %.3f px\n", number.c_str(), ngi_->FrameRms(result));
    EXPECT_LE(ngi_->FrameRms(result), max_rms_px) << number;
  }

  static void ExpectSaid(const ExteriorResult& result, const std::string& word) {
    std::string said;
    for (const std::string& message : Sentences(result.findings)) said += message + "\n";
    EXPECT_NE(said.find(word), std::string::npos) << said << "lacks " << word;
  }

  static void Run(const std::vector<std::string>& arguments) {
    const ProgramRun run = RunOrient(arguments);
    ASSERT_EQ(run.exit_code, 0) << run.err;
  }

  std::optional<Ngi> ngi_;
  TemporaryFolder folder_;
  std::string camera_, dem_;
};

using SlowWideSearch = WideSearch;

constexpr double kMaxFrameRms = 0.4;  // as from good approximations, see ngi_test.cpp

TEST_F(WideSearch, FindsAPhotoKilometresOffAtAnUnknownKappa) {
  Harvest({"0182", "0184"});
  WriteStart(kKilometres, 3);
  ExpectFound("0253", kMaxFrameRms);
}

TEST_F(SlowWideSearch, OfAnAccuracyThatWasOptimisticSaysSo) {
  Harvest({"0182", "0184"});
  WriteStart({600, 6, 137, 0.02}, 4);
  const ExteriorResult result = Orient(ngi_->Photo("0253"));
  EXPECT_EQ(result.status, Status::kWeak);
  ASSERT_TRUE(result.pose);
  EXPECT_LE(ngi_->FrameRms(result), kMaxFrameRms);
  ExpectSaid(result, "sigma from its approximation");
}

TEST_F(SlowWideSearch, FindsEveryPhotoFromTheOtherStripWhateverTheStart) {
  const std::vector<std::string> strip05 = {"0182", "0184"}, strip06 = {"0251", "0253"};
  for (const auto& [from, to] : {std::pair(strip05, strip06), std::pair(strip06, strip05)}) {
    Harvest(from);
    for (const Start& start : {Start{150, 2, 2}, Start{600, 6, 6}, kKilometres})
      for (const std::string& number : to) {
        WriteStart(start, 7);
        ExpectFound(number, number == "0182" ? 0.9 : kMaxFrameRms);
      }
  }
}

// What a flight index has: positions, as accurate as nobody says otherwise (10 m), no attitudes.
TEST_F(SlowWideSearch, NeedsPositionsAlone) {
  Harvest({"0182", "0184"});
  std::string text = "filename,x,y,z\n";
  for (const char* number : {"0251", "0253"}) {
    const Eigen::Vector3d at = ngi_->Published(number).pose.position_m;
    text += PhotoName(ngi_->Photo(number)) + "," + std::to_string(at.x() + 8) + "," +
            std::to_string(at.y() - 6) + "," + std::to_string(at.z() + 5) + "\n";
  }
  WriteFileAtomically(folder_ / "approx.csv", text);
  std::filesystem::remove(folder_ / "approx.prj");
  ExpectFound("0251", kMaxFrameRms);
  ExpectFound("0253", kMaxFrameRms);
}

TEST_F(SlowWideSearch, FindsNothingInClouds) {
  Harvest({"0182", "0184"});
  const Camera& camera = ngi_->camera.camera;
  const int width = camera.image_px->x(), height = camera.image_px->y();
  std::vector<std::uint16_t> grey;
  for (int row = 0; row < height; ++row)
    for (int col = 0; col < width; ++col)
      grey.push_back(static_cast<std::uint16_t>(
          std::lround(200 + 20 * std::sin(col / 37.0) * std::cos(row / 51.0 + col / 90.0))));
  simulation::WriteGreyTiff(folder_ / (PhotoName(ngi_->Photo("0253")) + ".tif"), width, height,
                            grey, 8, std::nullopt, std::nullopt);
  WriteStart(kKilometres, 3);
  const ExteriorResult result = Orient(folder_ / (PhotoName(ngi_->Photo("0253")) + ".tif"));
  EXPECT_EQ(result.status, Status::kFailed);
  EXPECT_FALSE(result.pose);
  ExpectSaid(result, "nothing like");
}

TEST_F(WideSearch, OfApproximationsOfAnotherPlaceSaysThatThereAreNoPatches) {
  Harvest({"0182", "0184"});
  OrientationTable table = ngi_->published;
  for (OrientationRow& row : table.rows) row.pose.position_m.y() -= 30000;
  WriteOrientationTable(folder_ / "approx.csv", table);
  dem_ = folder_ / "dem.tif";
  const Eigen::Vector3d middle = ngi_->Published("0253").pose.position_m;
  simulation::WriteFloatTiff(dem_, 100, 100, std::vector<float>(10000, 400),
                             {middle.x() - 50000, middle.y() + 50000, 1000, *table.crs});
  const ExteriorResult result = Orient(ngi_->Photo("0253"));
  EXPECT_EQ(result.status, Status::kFailed);
  ExpectSaid(result, "no control patch under the photo's footprint");
}

// The patches are right and the photo is found; the DEM that came with it is not.
TEST_F(SlowWideSearch, NamesADemOfAnotherHeightDatumOrWithAHole) {
  Harvest({"0182", "0184"});
  WriteStart({150, 2, 2}, 3);
  const Bounds extent = ngi_->surface.Extent();
  const double cell = ngi_->surface.CellSize();
  const int width = static_cast<int>((extent.max_x - extent.min_x) / cell);
  const int height = static_cast<int>((extent.max_y - extent.min_y) / cell);
  const double middle_y = ngi_->Published("0253").pose.position_m.y();
  std::vector<float> raised, holed;
  for (int row = 0; row < height; ++row)
    for (int col = 0; col < width; ++col) {
      const double y = extent.max_y - (row + 0.5) * cell;
      const float h = static_cast<float>(
          ngi_->surface.HeightAt(extent.min_x + (col + 0.5) * cell, y).value_or(std::nan("")));
      raised.push_back(h + 50);
      holed.push_back(y > middle_y + 500 ? std::nanf("") : h);
    }
  const simulation::GeoReference place{extent.min_x, extent.max_y, cell, *ngi_->published.crs};
  dem_ = folder_ / "dem.tif";
  simulation::WriteFloatTiff(dem_, width, height, raised, place);
  const ExteriorResult above = Orient(ngi_->Photo("0253"));
  EXPECT_EQ(above.status, Status::kWeak);
  ExpectSaid(above, "the DEM lies 50 m above the matched patches");
  simulation::WriteFloatTiff(dem_, width, height, holed, place);
  ExpectSaid(Orient(ngi_->Photo("0253")), "the DEM has no height under");
}

TEST_F(SlowWideSearch, OfAnotherCameraDoesNotAcceptAPose) {
  Harvest({"0182", "0184"});
  WriteStart({150, 2, 2}, 3);
  std::string text = ReadFile(camera_);
  text.replace(text.find("120.0"), 5, "152.0");
  camera_ = folder_ / "camera.toml";
  WriteFileAtomically(camera_, text);
  const ExteriorResult result = Orient(ngi_->Photo("0253"));
  EXPECT_NE(result.status, Status::kOk);
  EXPECT_FALSE(result.findings.empty());
}

}  // namespace
}  // namespace orient
