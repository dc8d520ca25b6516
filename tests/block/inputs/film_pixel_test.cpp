// The film's own pixel: how finely it was scanned decides whether the earth is taken as flat.
#include "block/inputs/film_pixel.h"

#include <gtest/gtest.h>

#include "block/stages/exterior_stage.h"
#include "core/base/atomic_write.h"
#include "core/files/camera_file.h"
#include "patchdb/store/patch_database.h"
#include "tests/support/shared_data.h"
#include "tools/simulate/simulate.h"

namespace orient::block {
namespace {

// A scan that is nothing but its size.
std::string Scan(const TemporaryFolder& folder, const std::string& name, int width, int height) {
  const std::string path = folder / (name + ".vrt");
  WriteFileAtomically(path, "<VRTDataset rasterXSize=\"" + std::to_string(width) +
                                "\" rasterYSize=\"" + std::to_string(height) +
                                "\"><VRTRasterBand dataType=\"Byte\" band=\"1\"/></VRTDataset>");
  return path;
}

Camera Film(double width_mm, double height_mm) {
  Camera camera;
  camera.kind = CameraKind::kFilm;
  camera.frame_mm = {width_mm, height_mm};
  return camera;
}

TEST(FilmPixel, IsTheFramesSideOverTheScans) {
  const TemporaryFolder folder;
  EXPECT_NEAR(*FilmPixel_mm(Film(230, 230), {Scan(folder, "whole", 11500, 11500)}), 0.02, 1e-9);
  // Lying across; with the data strip beside the frame.
  EXPECT_NEAR(*FilmPixel_mm(Film(180, 120), {Scan(folder, "across", 6000, 9600)}), 0.02, 1e-9);
}

TEST(FilmPixel, OfSeveralScansIsThatOfMostWhateverCannotBeRead) {
  const TemporaryFolder folder;
  const std::vector<std::string> scans = {Scan(folder, "a", 9200, 9200), folder / "missing.tif",
                                          Scan(folder, "preview", 400, 400),
                                          Scan(folder, "b", 9200, 9200)};
  EXPECT_NEAR(*FilmPixel_mm(Film(230, 230), scans), 0.025, 1e-9);
}

TEST(FilmPixel, OfADigitalCameraOrWithoutScansIsNotKnown) {
  const TemporaryFolder folder;
  EXPECT_FALSE(FilmPixel_mm(Film(230, 230), {folder / "missing.tif"}));
  Camera digital = Film(100, 70);
  digital.kind = CameraKind::kDigital;
  EXPECT_FALSE(FilmPixel_mm(digital, {Scan(folder, "a", 9200, 9200)}));
}

// The same photo at 1:10 000: 10 um in the corners that no flying height absorbs.
TEST(FilmPixel, DecidesWhetherTheEarthIsTakenAsFlat) {
  const TemporaryFolder folder;
  SimulationOptions simulation;
  simulation.camera = CameraPreset::kRc10;
  simulation.photos = 1;
  simulation.pixel_size_um = 400;
  simulation.gsd_m = 4;  // the scale of 25 um and 0.25 m
  simulation.objects = false;
  Simulate(simulation, folder / "block");
  ExteriorRunOptions run;
  run.camera = folder / "block/camera.toml";
  run.approximations = folder / "block/approx.csv";
  run.dem = folder / "block/dem.tif";
  run.interior = folder / "block/truth/interior";
  run.patchdb = folder / "patches.gpkg";
  patchdb::PatchDatabase::Create(run.patchdb, Crs::Parse(simulation.crs, "simulation"));
  const auto k1_scanned_at = [&](int side_px) {
    run.photos = {Scan(folder, "new_1_1", side_px, side_px)};
    return EarthK1OfRun(run);
  };
  const double k1 = k1_scanned_at(18400);
  EXPECT_LT(k1, 0);
  const double matters_mm =
      10 * LargestUnabsorbed(ReadCameraFile(run.camera).camera, k1);  // for 0.1 px
  const double frame_mm = ReadCameraFile(run.camera).camera.frame_mm.x();
  EXPECT_EQ(k1_scanned_at(static_cast<int>(1.02 * frame_mm / matters_mm)), k1);
  EXPECT_EQ(k1_scanned_at(static_cast<int>(0.98 * frame_mm / matters_mm)), 0);
  run.earth = EarthMode::kCurved;
  EXPECT_EQ(k1_scanned_at(1000), k1);
}

}  // namespace
}  // namespace orient::block
