// Film photos as images in the photo system: where a grey value lies, to hundredths of a pixel.
#include "tools/convert/resample_photos.h"

#include <gdal_priv.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>

#include "block/inputs/block_camera.h"
#include "core/base/error.h"
#include "core/files/camera_file.h"
#include "core/files/orientation_table.h"
#include "core/files/results.h"
#include "core/geometry/lens.h"
#include "core/raster/raster.h"
#include "tests/support/expect_error.h"
#include "tests/support/run_orient.h"
#include "tests/support/shared_data.h"
#include "tools/convert/convert_source.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

constexpr int kSide = 900;          // of the scan, px
constexpr double kScan_mm = 0.025;  // its pixels
constexpr double kPerMm = 1500;     // grey values: 37.5 a pixel, so that half a value is 0.013 px

CameraFile FilmCamera() {
  CameraFile file;
  file.camera.name = "film";
  file.camera.principal_distance_mm = 20;
  file.camera.principal_point_mm = {0.03, -0.02};
  file.camera.frame_mm = {18, 16};
  file.camera.frame_centre_mm = {0.5, -0.25};
  file.camera.lens = BrownDistortion{{4e-5, 0, 0}, {1e-5, -2e-5}};
  return file;
}

// A film turned and mirrored, a bit sheared and shifted.
Affine2d PhotoFromScan(ScanOrientation orientation) {
  Affine2d transform;
  transform.A = kScan_mm * PhotoFromPixelAxes(orientation);
  transform.A(0, 0) *= 1.0007;
  transform.A(0, 1) += 2e-6;
  transform.t = -(transform.A * Eigen::Vector2d(0.5 * kSide + 3.3, 0.5 * kSide - 2.7));
  return transform;
}

InteriorResult Interior(ScanOrientation orientation) {
  InteriorResult result;
  result.photo = "p";
  result.status = Status::kOk;
  result.width = result.height = kSide;
  result.orientation = orientation;
  result.possible_orientations = {orientation};
  result.photo_from_pixel = PhotoFromScan(orientation);
  ReseauResult reseau;
  reseau.correction.step_px = {kSide / 2.0, kSide / 2.0};
  reseau.correction.columns = reseau.correction.rows = 3;
  for (int i = 0; i < 9; ++i) reseau.correction.correction_mm.emplace_back(0.002 * (i % 3), 0.004);
  reseau.crosses = 25;
  result.reseau = reseau;
  return result;
}

// Planes over the photo system: bands of different slopes.
double Grey(const Eigen::Vector2d& photo_mm, int band) {
  return 30000 + kPerMm * (band == 0 ? photo_mm.x() : photo_mm.y());
}

void WriteScan(const std::string& path, const InteriorResult& interior, int bands,
               bool white_is_zero = false) {
  CPLStringList options;
  if (white_is_zero) options.SetNameValue("PHOTOMETRIC", "MINISWHITE");
  GDALAllRegister();
  GDALDatasetUniquePtr scan(GetGDALDriverManager()->GetDriverByName("GTiff")->Create(
      path.c_str(), kSide, kSide, bands, GDT_UInt16, options.List()));
  for (int band = 0; band < bands; ++band) {
    std::vector<double> values;
    for (int row = 0; row < kSide; ++row)
      for (int col = 0; col < kSide; ++col)
        values.push_back(Grey(PhotoFromPixel(*interior.photo_from_pixel,
                                             &interior.reseau->correction, {col + 0.5, row + 0.5}),
                              band));
    if (white_is_zero)
      for (double& value : values) value = 65535 - value;
    ASSERT_EQ(scan->GetRasterBand(band + 1)->RasterIO(GF_Write, 0, 0, kSide, kSide, values.data(),
                                                      kSide, kSide, GDT_Float64, 0, 0, nullptr),
              CE_None);
  }
}

std::vector<double> ReadBand(const std::string& path, int band, int* width, int* height) {
  GDALDatasetUniquePtr image(GDALDataset::Open(path.c_str()));
  *width = image->GetRasterXSize();
  *height = image->GetRasterYSize();
  EXPECT_EQ(image->GetRasterBand(band + 1)->GetRasterDataType(), GDT_UInt16);
  std::vector<double> values(static_cast<std::size_t>(*width) * static_cast<std::size_t>(*height));
  EXPECT_EQ(image->GetRasterBand(band + 1)->RasterIO(GF_Read, 0, 0, *width, *height, values.data(),
                                                     *width, *height, GDT_Float64, 0, 0, nullptr),
            CE_None);
  return values;
}

// Of the image's grey values, in its pixels. Two roundings to whole grey values and the kinks of
// the reseau's grid, of which an area average sees some, are a few hundredths of a pixel.
double LargestError_px(const std::string& path, int band, const Camera& film, const Camera& image,
                       bool distortion_removed) {
  int width = 0, height = 0;
  const std::vector<double> values = ReadBand(path, band, &width, &height);
  EXPECT_EQ(Eigen::Vector2i(width, height), *image.image_px);
  const double pixel_mm = image.frame_mm.x() / width;
  double largest = 0;
  for (int row = 20; row < height - 20; row += 7)
    for (int col = 20; col < width - 20; col += 7) {
      // Of the digital camera: its system's origin is the image's centre.
      Eigen::Vector2d photo = DigitalPhotoFromPixel(image) * Eigen::Vector2d(col + 0.5, row + 0.5) +
                              film.frame_centre_mm;
      if (distortion_removed)
        photo = DistortPoint(film.lens, photo - film.principal_point_mm) + film.principal_point_mm;
      const double grey = values[static_cast<std::size_t>(row) * static_cast<std::size_t>(width) +
                                 static_cast<std::size_t>(col)];
      largest = std::max(largest, std::abs(grey - Grey(photo, band)) / (kPerMm * pixel_mm));
    }
  return largest;
}

struct Case {
  ScanOrientation orientation;
  double pixel_mm;
  bool remove_distortion;
};

class Resampled : public testing::TestWithParam<Case> {};

TEST_P(Resampled, GreyValuesLieWhereThePhotoSystemSays) {
  const Case c = GetParam();
  const TemporaryFolder folder;
  const CameraFile camera = FilmCamera();
  const InteriorResult interior = Interior(c.orientation);
  WriteInteriorResult(folder.Path(), interior);
  WriteScan(folder / "p.tif", interior, 2);
  const Camera image = ImageCamera(camera.camera, c.pixel_mm, c.remove_distortion);
  const FilmImage film(camera, "p", folder.Path(), std::nullopt, image, c.remove_distortion);
  const ResampledPhoto made = ResamplePhoto(folder / "p.tif", film, image, folder / "out.tif");
  EXPECT_EQ(made.bands, 2);
  EXPECT_LT(made.largest_difference_px, 1e-6);
  EXPECT_FALSE(fs::exists(folder / "out.tif.part"));
  for (const int band : {0, 1})
    EXPECT_LT(LargestError_px(folder / "out.tif", band, camera.camera, image, c.remove_distortion),
              0.04)
        << "band " << band;
}

INSTANTIATE_TEST_SUITE_P(Scans, Resampled,
                         testing::Values(Case{ScanOrientation::kR0, 0.025, false},
                                         Case{ScanOrientation::kR90, 0.025, true},
                                         Case{ScanOrientation::kM270, 0.02, false},
                                         Case{ScanOrientation::kM180, 0.06, true}));

TEST(ResamplePhoto, OfAScanOfWhichZeroIsWhiteHasBlackForZero) {
  const TemporaryFolder folder;
  const CameraFile camera = FilmCamera();
  const InteriorResult interior = Interior(ScanOrientation::kR0);
  WriteInteriorResult(folder.Path(), interior);
  WriteScan(folder / "p.tif", interior, 1, true);
  const Camera image = ImageCamera(camera.camera, 0.025, false);
  const FilmImage film(camera, "p", folder.Path(), std::nullopt, image, false);
  ResamplePhoto(folder / "p.tif", film, image, folder / "out.tif");
  EXPECT_LT(LargestError_px(folder / "out.tif", 0, camera.camera, image, false), 0.04);
}

TEST(FilmImage, OfAnotherRunThanTheExteriorOrientationIsRefused) {
  const TemporaryFolder folder;
  const CameraFile camera = FilmCamera();
  WriteInteriorResult(folder.Path(), Interior(ScanOrientation::kR90));
  const Camera image = ImageCamera(camera.camera, 0.025, false);
  EXPECT_NO_THROW(FilmImage(camera, "p", folder.Path(), ScanOrientation::kR90, image, false));
  ExpectError<InputError>(
      [&] { FilmImage(camera, "p", folder.Path(), ScanOrientation::kR0, image, false); },
      {"p.interior.json", "r90", "r0", "two runs"});
}

TEST(ResamplePhoto, RefusesAnotherScan) {
  const TemporaryFolder folder;
  InteriorResult interior = Interior(ScanOrientation::kR0);
  WriteScan(folder / "p.tif", interior, 1);
  interior.width = kSide + 1;
  WriteInteriorResult(folder.Path(), interior);
  const CameraFile camera = FilmCamera();
  const Camera image = ImageCamera(camera.camera, 0.025, false);
  const FilmImage film(camera, "p", folder.Path(), std::nullopt, image, false);
  ExpectError<InputError>([&] { ResamplePhoto(folder / "p.tif", film, image, folder / "out.tif"); },
                          {"p.tif", "has 900 x 900 px", "901"});
  EXPECT_FALSE(fs::exists(folder / "out.tif"));
}

// The poses of a block are true with its own camera file, whichever else is named.
TEST(ResamplePhoto, TakesOutTheLensThatTheBlocksPosesAreTrueWith) {
  const TemporaryFolder folder;
  const InteriorResult interior = Interior(ScanOrientation::kR0);
  WriteInteriorResult(folder.Path(), interior);
  WriteScan(folder / "p.tif", interior, 1);
  const CameraFile given = FilmCamera();
  CameraFile of_block = given;
  of_block.camera.lens = BrownDistortion{{-2e-4, 0, 0}, {0, 0}};
  WriteCameraFile(folder / "given.toml", given);
  WriteCameraFile(block::BlockCameraPath(folder.Path()), of_block);
  OrientationTable table;
  table.crs = Crs::Parse("EPSG:32635", "test");
  table.rows.push_back({"p", {{500000, 5000000, 900}, {0, 0, 0}}, std::nullopt});
  WriteOrientationTable(folder / "orientation.csv", table);
  const Camera image = ImageCamera(of_block.camera, kScan_mm, true);
  for (const bool named : {false, true}) {
    std::vector<std::string> words = {
        "convert", folder.Path(),         "--images",    folder / "p.tif", "--pixel-size-um",
        "25",      "--remove-distortion", "--overwrite", "--out",          folder / "out"};
    if (named) words.insert(words.end(), {"--camera", folder / "given.toml"});
    const ProgramRun run = RunOrient(words);
    ASSERT_EQ(run.exit_code, 0) << run.err;
    EXPECT_LT(LargestError_px(folder / "out/images/p.tif", 0, of_block.camera, image, true), 0.04);
  }
}

// A scan that took another one's name and size, and one that is damaged: each fails alone.
TEST(ResamplePhoto, OfADamagedScanOrAnotherOneFailsThatPhotoOnly) {
  const TemporaryFolder folder;
  WriteCameraFile(folder / "camera.toml", FilmCamera());
  OrientationTable table;
  table.crs = Crs::Parse("EPSG:32635", "test");
  for (const char* name : {"good", "cut", "other"}) {
    const std::string scan = folder / (std::string(name) + ".tif");
    InteriorResult interior = Interior(ScanOrientation::kR0);
    interior.photo = name;
    WriteScan(scan, interior, 1);
    if (name == std::string("other")) interior.made_from = {{"scan", "0123456789abcdef"}};
    WriteInteriorResult(folder.Path(), interior);
    table.rows.push_back({name, {{500000, 5000000, 900}, {0, 0, 0}}, std::nullopt});
  }
  WriteOrientationTable(folder / "orientation.csv", table);
  fs::resize_file(folder / "cut.tif", fs::file_size(folder / "cut.tif") / 2);
  const ProgramRun run = RunOrient({"convert", folder.Path(), "--camera", folder / "camera.toml",
                                    "--images", folder / "*.tif", "--out", folder / "out"});
  EXPECT_EQ(run.exit_code, 3) << run.err;
  EXPECT_NE(run.out.find("failed  cut: "), std::string::npos) << run.out;
  EXPECT_NE(run.out.find("failed  other: "), std::string::npos) << run.out;
  EXPECT_NE(run.out.find("other.tif (the same size, other content)"), std::string::npos) << run.out;
  EXPECT_TRUE(fs::exists(folder / "out/images/good.tif"));
  for (const char* file : {"cut.tif", "cut.tif.part", "other.tif", "other.tif.part"})
    EXPECT_FALSE(fs::exists(folder / (std::string("out/images/") + file))) << file;
}

TEST(ImageCamera, HoldsTheFrameInWholePixels) {
  const CameraFile file = FilmCamera();
  const Camera image = ImageCamera(file.camera, 0.07, false);
  EXPECT_EQ(*image.image_px, Eigen::Vector2i(258, 229));
  EXPECT_NEAR(image.principal_point_mm.x(), 0.03 - 0.5, 1e-12);
  EXPECT_NEAR(image.principal_point_mm.y(), -0.02 + 0.25, 1e-12);
  EXPECT_TRUE(std::holds_alternative<std::monostate>(ImageCamera(file.camera, 0.07, true).lens));
}

}  // namespace
}  // namespace orient
