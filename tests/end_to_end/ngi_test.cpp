// Real photos: the four NGI frames oriented from each other's orthophotos and photos.
#include "tests/support/ngi.h"

#include <gdal_priv.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <functional>
#include <memory>

#include "core/base/atomic_write.h"
#include "core/raster/raster.h"
#include "core/raster/resample.h"
#include "core/terrain/photo_view.h"
#include "tests/support/run_orient.h"
#include "tests/support/scan_making.h"
#include "tests/support/shared_data.h"

namespace orient {
namespace {

constexpr double kMaxFrameRms = 0.38;  // px, over the whole frame
// The orthophotos do not agree with the published orientation and DEM: back in the photo that each
// was made from, their patches are off by 0.3 to 0.6 px RMS, nearly all of it radial, as heights
// other than this DEM's would do (see DifferFromTheirOwnPhotos...); the fourth is shifted, too.
// What the pose's covariance model cannot absorb of it grows from patches of half a strip towards
// the far side of the frame of 0182.
constexpr double kMaxFrameRmsFromShiftedOrthophoto = 0.9;
constexpr double kMaxPosition = 16;  // m: position and tilt trade against one another
constexpr double kMaxAngle = 0.16;   // degrees

void MakeDatabase(const Ngi& ngi, const std::string& path) {
  const ProgramRun run = RunOrient({"patchdb", "create", path, "--crs", ngi.CrsFile()});
  ASSERT_EQ(run.exit_code, 0) << run.err;
}

void HarvestOrthophotos(const Ngi& ngi, const std::string& path,
                        const std::vector<std::string>& numbers) {
  MakeDatabase(ngi, path);
  std::vector<std::string> arguments = {"patchdb", "harvest-ortho",         path,
                                        "--dem",   ngi.folder + "/dem.tif", "--ortho"};
  for (const std::string& number : numbers) arguments.push_back(ngi.Orthophoto(number));
  const ProgramRun run = RunOrient(arguments);
  ASSERT_EQ(run.exit_code, 0) << run.err;
}

void HarvestPhotos(const Ngi& ngi, const std::string& path,
                   const std::vector<std::string>& numbers) {
  MakeDatabase(ngi, path);
  std::vector<std::string> arguments = {"patchdb",
                                        "harvest",
                                        path,
                                        "--camera",
                                        ngi.folder + "/camera.toml",
                                        "--orientation",
                                        ngi.folder + "/published_orientation.csv",
                                        "--dem",
                                        ngi.folder + "/dem.tif"};
  for (const std::string& number : numbers) arguments.push_back(ngi.Photo(number));
  const ProgramRun run = RunOrient(arguments);
  ASSERT_EQ(run.exit_code, 0) << run.err;
}

// Approximations wrong by 150 m in each coordinate and 2 degrees in each angle.
ProgramRun OrientPhotos(const Ngi& ngi, const TemporaryFolder& folder, const std::string& database,
                        const std::string& camera, const std::vector<std::string>& photos,
                        unsigned signs) {
  ngi.WriteApproximations(folder / "approx.csv", 150, 2, signs);
  std::vector<std::string> arguments = {"exterior",
                                        "--camera",
                                        camera,
                                        "--approximations",
                                        folder / "approx.csv",
                                        "--dem",
                                        ngi.folder + "/dem.tif",
                                        "--patchdb",
                                        database,
                                        "--out",
                                        folder / "out",
                                        "--overwrite",
                                        "--position-sigma-m",
                                        "150",
                                        "--attitude-sigma-deg",
                                        "2"};
  arguments.insert(arguments.end(), photos.begin(), photos.end());
  return RunOrient(arguments);
}

ProgramRun Orient(const Ngi& ngi, const TemporaryFolder& folder, const std::string& database,
                  const std::vector<std::string>& numbers, unsigned signs) {
  std::vector<std::string> photos;
  for (const std::string& number : numbers) photos.push_back(ngi.Photo(number));
  return OrientPhotos(ngi, folder, database, ngi.folder + "/camera.toml", photos, signs);
}

void ExpectAsPublished(const Ngi& ngi, const TemporaryFolder& folder,
                       const std::vector<std::string>& numbers,
                       double max_frame_rms = kMaxFrameRms) {
  for (const std::string& number : numbers) {
    const ExteriorResult result =
        ReadExteriorResult(ExteriorResultPath(folder / "out", PhotoName(ngi.Photo(number))));
    ASSERT_TRUE(result.pose) << number;
    EXPECT_LE(ngi.FrameRms(result), max_frame_rms) << number;
    EXPECT_LE(ngi.PositionError(result), kMaxPosition) << number;
    EXPECT_LE(ngi.AngleErrorDeg(result), kMaxAngle) << number;
    testing::Test::RecordProperty("frame_rms_px_" + number, std::to_string(ngi.FrameRms(result)));
    std::printf(
        "%s: frame rms %.3f px, position %.1f m, angle %.3f deg, sigma0 %.2f px, normalised %.2f\n",
        number.c_str(), ngi.FrameRms(result), ngi.PositionError(result), ngi.AngleErrorDeg(result),
        *result.sigma0_px, ngi.NormalisedError(result));
    for (const std::string& told : Sentences(result.findings)) std::printf("  %s\n", told.c_str());
    EXPECT_GT(ngi.NormalisedError(result), 0.65) << number;
    EXPECT_LT(ngi.NormalisedError(result), 1.35) << number;
    ExpectOkOrPoorlyDetermined(result);
  }
}

constexpr unsigned kSigns = 0x5a3c96e1;

TEST(NgiOrthophotos, OfStrip05OrientStrip06) {
  ORIENT_REQUIRE_SHARED_DATA(data, "ngi");
  const Ngi ngi(data);
  const TemporaryFolder folder;
  HarvestOrthophotos(ngi, folder / "patches.gpkg", {"0182", "0184"});
  const ProgramRun run = Orient(ngi, folder, folder / "patches.gpkg", {"0251", "0253"}, kSigns);
  ASSERT_EQ(run.exit_code, 0) << run.out << run.err;
  ExpectAsPublished(ngi, folder, {"0251", "0253"});
}

TEST(NgiOrthophotos, OfStrip06OrientStrip05) {
  ORIENT_REQUIRE_SHARED_DATA(data, "ngi");
  const Ngi ngi(data);
  const TemporaryFolder folder;
  HarvestOrthophotos(ngi, folder / "patches.gpkg", {"0251", "0253"});
  const ProgramRun run = Orient(ngi, folder, folder / "patches.gpkg", {"0182", "0184"}, kSigns);
  ASSERT_EQ(run.exit_code, 0) << run.out << run.err;
  ExpectAsPublished(ngi, folder, {"0182"}, kMaxFrameRmsFromShiftedOrthophoto);
  ExpectAsPublished(ngi, folder, {"0184"});
}

// Why patches from these orthophotos cannot do as well as patches from the photos: matched into the
// very photo that the orthophoto was made from, they do not lie where the published orientation and
// the DEM say, while they agree with each other to a sixth of a pixel across the radial direction.
TEST(NgiOrthophotos, DifferFromTheirOwnPhotosAlongTheLineOfSight) {
  ORIENT_REQUIRE_SHARED_DATA(data, "ngi");
  const Ngi ngi(data);
  const TemporaryFolder folder;
  HarvestOrthophotos(ngi, folder / "patches.gpkg", {"0184"});
  ASSERT_EQ(Orient(ngi, folder, folder / "patches.gpkg", {"0184"}, kSigns).exit_code, 0);
  const ExteriorResult result =
      ReadExteriorResult(ExteriorResultPath(folder / "out", PhotoName(ngi.Photo("0184"))));
  const PhotoView view{ngi.camera.camera, DigitalPhotoFromPixel(ngi.camera.camera),
                       ngi.Published("0184").pose};
  const Eigen::Vector2d middle = ngi.camera.camera.image_px->cast<double>() / 2;
  double radial = 0, across = 0;
  int count = 0;
  for (const PatchResult& patch : result.patches) {
    if (patch.state != PatchState::kMatched) continue;
    const Eigen::Vector2d expected = *view.PixelFromGround(*patch.ground_m);
    const Eigen::Vector2d outwards = (expected - middle).normalized();
    const Eigen::Vector2d difference = *patch.pixel - expected;
    radial += std::pow(difference.dot(outwards), 2);
    across += std::pow(difference.x() * outwards.y() - difference.y() * outwards.x(), 2);
    ++count;
  }
  ASSERT_GT(count, 400);
  std::printf("radial %.3f px, across %.3f px RMS\n", std::sqrt(radial / count),
              std::sqrt(across / count));
  EXPECT_GT(std::sqrt(radial / count), 0.25);
  EXPECT_LT(std::sqrt(across / count), 0.2);
}

TEST(NgiPhotos, OfStrip05OrientStrip06) {
  ORIENT_REQUIRE_SHARED_DATA(data, "ngi");
  const Ngi ngi(data);
  const TemporaryFolder folder;
  HarvestPhotos(ngi, folder / "patches.gpkg", {"0182", "0184"});
  const ProgramRun run = Orient(ngi, folder, folder / "patches.gpkg", {"0251", "0253"}, kSigns);
  ASSERT_EQ(run.exit_code, 0) << run.out << run.err;
  ExpectAsPublished(ngi, folder, {"0251", "0253"}, 0.28);  // 0.253 and 0.231 where this was written
  // A few patches in large windows show where the many are, in small ones.
  for (const char* number : {"0251", "0253"}) {
    const auto rounds =
        ReadExteriorResult(ExteriorResultPath(folder / "out", PhotoName(ngi.Photo(number))))
            .iterations;
    ASSERT_GE(rounds.size(), 3u);
    EXPECT_LE(rounds[0].searched, 24);
    EXPECT_GE(rounds[1].searched, 100);
    EXPECT_LT(rounds[1].window_px, rounds[0].window_px / 4);
  }
}

// A copy of a photo, worse mostly. Its camera file differs from the photo's by `pixels` only.
struct Worse {
  std::string name, pixels;
  std::function<void(const std::string& photo, const std::string& path)> make;
};
void PrintTo(const Worse& worse, std::ostream* out) { *out << worse.name; }

void MakeCopy(const std::string& photo, const std::string& path) {
  std::filesystem::copy_file(photo, path);
}

void MakeHalfSize(const std::string& photo, const std::string& path) {
  const Raster raster = Raster::Open(photo);
  WriteTiffScan(path, raster.ReadGrey({0, 0, raster.Width(), raster.Height()}, 2).image, {});
}

void MakeBlurred(const std::string& photo, const std::string& path) {
  WriteTiffScan(path, GaussianBlur(Raster::Open(photo).ReadGrey().image, 2), {});
}

void MakeJpeg(const std::string& photo, const std::string& path) {
  GDALAllRegister();
  const std::unique_ptr<GDALDataset> from(GDALDataset::Open(photo.c_str(), GDAL_OF_RASTER));
  const char* const options[] = {"COMPRESS=JPEG", "JPEG_QUALITY=20", "PHOTOMETRIC=YCBCR", nullptr};
  const std::unique_ptr<GDALDataset> made(
      GetGDALDriverManager()->GetDriverByName("GTiff")->CreateCopy(
          path.c_str(), from.get(), 0, const_cast<char**>(options), nullptr, nullptr));
  ASSERT_TRUE(made) << path;
}

class SlowNgiWorsePhotos : public testing::TestWithParam<Worse> {};

// `ok`, or weak where the far corner is too uncertain; as right as their covariances say.
TEST_P(SlowNgiWorsePhotos, AreOrientedByTheOtherStripsPhotos) {
  ORIENT_REQUIRE_SHARED_DATA(data, "ngi");
  const Ngi ngi(data);
  const TemporaryFolder folder;
  const std::string camera = folder / "camera.toml";
  std::string text = ReadFile(ngi.folder + "/camera.toml");
  const std::string pixels = "[640, 1152]";
  WriteFileAtomically(camera, text.replace(text.find(pixels), pixels.size(), GetParam().pixels));
  const std::vector<std::vector<std::string>> strips = {{"0182", "0184"}, {"0251", "0253"}};
  for (std::size_t strip = 0; strip < 2; ++strip) {
    const std::string database = folder / ("patches" + std::to_string(strip) + ".gpkg");
    HarvestPhotos(ngi, database, strips[1 - strip]);
    std::vector<std::string> photos;
    for (const std::string& number : strips[strip]) {
      const std::string photo = ngi.Photo(number);
      photos.push_back(folder / std::filesystem::path(photo).filename().string());
      GetParam().make(photo, photos.back());
    }
    const ProgramRun run = OrientPhotos(ngi, folder, database, camera, photos, kSigns);
    ASSERT_EQ(run.exit_code, 0) << run.out << run.err;
    for (const std::string& photo : photos) {
      const ExteriorResult result =
          ReadExteriorResult(ExteriorResultPath(folder / "out", PhotoName(photo)));
      ASSERT_TRUE(result.pose) << photo;
      ExpectOkOrPoorlyDetermined(result);
      std::printf("%s: %s, frame rms %.3f px of the photo as it was, normalised %.2f\n",
                  result.photo.c_str(), std::string(Name(result.status)).c_str(),
                  ngi.FrameRms(result), ngi.NormalisedError(result));
      EXPECT_LT(ngi.FrameRms(result), 1) << photo;
      EXPECT_LT(ngi.NormalisedError(result), 1.5) << photo;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Ways, SlowNgiWorsePhotos,
                         testing::Values(Worse{"AsItWas", "[640, 1152]", MakeCopy},
                                         Worse{"HalfSize", "[320, 576]", MakeHalfSize},
                                         Worse{"Blurred", "[640, 1152]", MakeBlurred},
                                         Worse{"Jpeg", "[640, 1152]", MakeJpeg}),
                         [](const auto& worse) { return worse.param.name; });

}  // namespace
}  // namespace orient
