#include "tools/simulate/simulate.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/base/atomic_write.h"
#include "core/base/error.h"
#include "core/files/block_file.h"
#include "core/files/camera_file.h"
#include "core/files/orientation_table.h"
#include "core/raster/raster.h"
#include "core/terrain/ground_surface.h"
#include "core/terrain/photo_view.h"
#include "tests/support/expect_error.h"
#include "tests/support/shared_data.h"

namespace orient {
namespace {

namespace fs = std::filesystem;

// Two photos of 615 px: about a second.
SimulationOptions Small() {
  SimulationOptions options;
  options.photos = 2;
  options.pixel_size_um = 100;
  options.gsd_m = 1;
  options.bits = 8;
  return options;
}

TEST(Simulate, WhatItWritesIsReadByTheProgram) {
  const TemporaryFolder folder;
  SimulationOptions options = Small();
  options.ortho = true;
  const std::string out = folder / "block";
  const SimulationSummary summary = Simulate(options, out);
  WriteFileAtomically(out + "/patches.gpkg", "");  // harvesting makes it
  const BlockFile block = ReadBlockFile(summary.block_file);
  EXPECT_EQ(block.photos.size(), 2u);
  EXPECT_EQ(block.position_sigma_m, options.position_error_m);
  const CameraFile camera = ReadCameraFile(block.camera);
  EXPECT_EQ(camera.fiducials.size(), 4u);
  EXPECT_EQ(ReadCameraFile(out + "/old/camera.toml").camera.kind, CameraKind::kDigital);
  const GroundSurface dem = GroundSurface::FromFile(block.dem, block.crs);
  EXPECT_NEAR(dem.MaxHeight() - dem.MinHeight(), options.relief_m, 0.01);
  EXPECT_TRUE(ReadOrientationTable(block.approximations).crs.has_value());
  EXPECT_EQ(ReadOrientationTable(out + "/old/orientation.csv").rows.size(),
            summary.old_photos.size());
  EXPECT_TRUE(fs::exists(out + "/old/ortho.tif"));
  EXPECT_TRUE(fs::exists(out + "/change.tif"));
  const Image standing = Raster::Open(out + "/truth/standing.tif").ReadGrey().image;
  int marked = 0;
  for (const float value : standing.values) marked += value > 0 ? 1 : 0;
  EXPECT_GT(marked, static_cast<int>(standing.values.size() / 100));
  EXPECT_LT(marked, static_cast<int>(standing.values.size() * 9 / 10));
}

TEST(Simulate, ACrsGivenAsWktIsReadBackFromTheBlockFile) {
  const TemporaryFolder folder;
  SimulationOptions options = Small();
  options.photos = 1;
  options.crs = Crs::Parse(options.crs, "test").Wkt();
  const SimulationSummary summary = Simulate(options, folder / "block");
  WriteFileAtomically(folder / "block/patches.gpkg", "");
  EXPECT_EQ(ReadBlockFile(summary.block_file).crs.Epsg(), 32635);
}

TEST(Simulate, GroundThatDoesNotFitIntoMemoryIsRefusedBeforeAnythingIsWritten) {
  const TemporaryFolder folder;
  SimulationOptions options = Small();
  options.photos = 60;
  options.pixel_size_um = 4;
  options.gsd_m = 0.02;
  options.dem_cell_m = 50;
  options.relief_m = 1;
  ExpectError<UsageError>([&] { Simulate(options, folder / "block"); }, {"--gsd-m", "memory"});
  EXPECT_FALSE(fs::exists(folder / "block"));
}

TEST(Simulate, TruthExplainsEveryCheckPoint) {
  // The film's bend, which no affine transform holds, and nothing else.
  const TemporaryFolder folder;
  SimulationOptions options = Small();
  options.film_bend_um = 0;
  options.orientation = std::nullopt;
  options.polarity = Polarity::kNegative;
  const std::string out = folder / "block";
  const SimulationSummary summary = Simulate(options, out);
  const auto truth = nlohmann::json::parse(ReadFile(summary.truth_file));
  const Camera camera = ReadCameraFile(out + "/camera.toml").camera;
  const OrientationTable table = ReadOrientationTable(out + "/truth/orientation.csv");
  const Crs crs = Crs::Parse(options.crs, "test");
  const GroundSurface dem = GroundSurface::FromFile(out + "/dem.tif", crs);
  int checked = 0;
  for (const auto& photo : truth.at("photos")) {
    const std::string name = photo.at("photo");
    const InteriorResult interior =
        ReadInteriorResult(InteriorResultPath(out + "/truth/interior", name));
    EXPECT_EQ(interior.polarity, Polarity::kNegative);
    const PhotoView view{camera, *interior.photo_from_pixel, table.Find(name)->pose};
    for (const auto& check : photo.at("check")) {
      const auto& p = truth.at("check_points").at(check.at("point").get<size_t>());
      const Eigen::Vector3d ground(p[0], p[1], p[2]);
      const Eigen::Vector2d pixel(check.at("pixel")[0], check.at("pixel")[1]);
      EXPECT_NEAR(*dem.HeightAt(ground.x(), ground.y()), ground.z(), 1e-4);
      EXPECT_LT((*view.PixelFromGround(ground) - pixel).norm(), 1e-3);
      ++checked;
    }
  }
  EXPECT_GT(checked, 100);
}

TEST(Simulate, TheScanOfAFilmThatLiesAcrossShowsAllOfItsMarks) {
  const TemporaryFolder folder;
  SimulationOptions options = Small();
  options.camera = CameraPreset::kUmk;  // 166 x 120 mm
  options.orientation = ScanOrientation::kM90;
  options.photos = 1;
  options.pixel_size_um = 200;
  const SimulationSummary summary = Simulate(options, folder / "block");
  const Raster scan = Raster::Open(summary.photos.at(0));
  EXPECT_LT(scan.Width(), scan.Height());
  const InteriorResult truth =
      ReadInteriorResult(InteriorResultPath(folder / "block/truth/interior", "new_1_1"));
  EXPECT_EQ(truth.width, scan.Width());
  for (const MarkResult& mark : truth.marks) {
    EXPECT_GT(mark.pixel->minCoeff(), 0) << mark.id;
    EXPECT_LT(mark.pixel->x(), scan.Width()) << mark.id;
    EXPECT_LT(mark.pixel->y(), scan.Height()) << mark.id;
  }
}

TEST(Simulate, TheSameSeedMakesTheSameFiles) {
  const TemporaryFolder folder;
  SimulationOptions options = Small();
  options.photos = 1;
  options.pixel_size_um = 200;
  options.gsd_m = 2;
  const SimulationSummary a = Simulate(options, folder / "a"), b = Simulate(options, folder / "b");
  EXPECT_EQ(ReadFile(a.photos[0]), ReadFile(b.photos[0]));
  EXPECT_EQ(ReadFile(a.truth_file), ReadFile(b.truth_file));
  options.seed = 2;
  EXPECT_NE(ReadFile(a.photos[0]), ReadFile(Simulate(options, folder / "c").photos[0]));
}

TEST(Simulate, ApproximationsAreWrongByWhatWasAsked) {
  const TemporaryFolder folder;
  SimulationOptions options = Small();
  options.pixel_size_um = 400;
  options.gsd_m = 4;
  options.photos = 24;
  options.strips = 4;
  options.position_error_m = 20;
  const std::string out = folder / "block";
  Simulate(options, out);
  const auto truth = ReadOrientationTable(out + "/truth/orientation.csv");
  const auto approximate = ReadOrientationTable(out + "/approx.csv");
  double squares = 0;
  for (const OrientationRow& row : truth.rows)
    squares += (approximate.Find(row.photo)->pose.position_m - row.pose.position_m).squaredNorm();
  // 72 differences: their sigma is known to 8 %.
  EXPECT_NEAR(std::sqrt(squares / 72), 20, 5);
}

TEST(Simulate, RefusesAFolderThatIsNotEmpty) {
  const TemporaryFolder folder;
  std::ofstream(folder / "precious.txt") << "not ours";
  SimulationOptions options = Small();
  EXPECT_THROW(Simulate(options, folder.Path()), UsageError);
  options.overwrite = true;  // no simulation made this folder: still refused
  EXPECT_THROW(Simulate(options, folder.Path()), UsageError);
  EXPECT_TRUE(fs::exists(folder / "precious.txt"));
}

TEST(Simulate, OverwritingLeavesNoPhotoOfTheBlockBefore) {
  const TemporaryFolder folder;
  SimulationOptions options = Small();
  const std::string out = folder / "block";
  Simulate(options, out);
  options.photos = 1;
  options.overwrite = true;
  Simulate(options, out);
  WriteFileAtomically(out + "/patches.gpkg", "");
  EXPECT_EQ(ReadBlockFile(out + "/block.toml").photos.size(), 1u);
}

TEST(SimulationOptions, CheckNamesOptionAndValue) {
  SimulationOptions options;
  EXPECT_EQ(options.Check(), std::nullopt);
  options.change = 1.5;
  EXPECT_EQ(options.Check(), "--change 1.5: must lie between 0 and 1");
  options.change = 0.2;
  options.bits = 12;
  EXPECT_EQ(options.Check(), "--bits 12: must be 8 or 16");
  options.bits = 8;
  options.camera = CameraPreset::kDigital;
  options.polarity = Polarity::kNegative;
  EXPECT_TRUE(options.Check().has_value());
}

TEST(Simulate, GroundTooSteepToBeSeenIsRefused) {
  const TemporaryFolder folder;
  SimulationOptions options = Small();
  options.relief_m = 2500;
  EXPECT_THROW(Simulate(options, folder / "block"), UsageError);
}

}  // namespace
}  // namespace orient
