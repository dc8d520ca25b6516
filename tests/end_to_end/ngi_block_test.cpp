// The four NGI frames as one block, with patches of the orthophotos of one strip only.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "core/base/atomic_write.h"
#include "core/terrain/photo_view.h"
#include "tests/support/ngi.h"
#include "tests/support/run_orient.h"
#include "tests/support/shared_data.h"

namespace orient {
namespace {

const std::vector<std::string> kNumbers = {"0182", "0184", "0251", "0253"};
constexpr unsigned kSigns = 0x5a3c96e1;

void Harvest(const Ngi& ngi, const std::string& path, const std::vector<std::string>& numbers) {
  const ProgramRun made = RunOrient({"patchdb", "create", path, "--crs", ngi.CrsFile()});
  ASSERT_EQ(made.exit_code, 0) << made.err;
  std::vector<std::string> arguments = {"patchdb", "harvest-ortho",         path,
                                        "--dem",   ngi.folder + "/dem.tif", "--ortho"};
  for (const std::string& number : numbers) arguments.push_back(ngi.Orthophoto(number));
  const ProgramRun run = RunOrient(arguments);
  ASSERT_EQ(run.exit_code, 0) << run.err;
}

// Approximations wrong by 150 m in each coordinate and 2 degrees in each angle.
void WriteBlock(const Ngi& ngi, const TemporaryFolder& folder, const std::string& further) {
  ngi.WriteApproximations(folder / "approx.csv", 150, 2, kSigns);
  std::string wkt;
  for (const char c : ReadFile(ngi.CrsFile())) {
    if (c == '"') wkt += '\\';
    if (c != '\n') wkt += c;
  }
  std::string text = "crs = \"" + wkt + "\"\n";
  text += "dem = \"" + ngi.folder + "/dem.tif\"\n";
  text += "patchdb = \"patches.gpkg\"\n";
  text += "camera = \"" + ngi.folder + "/camera.toml\"\n";
  text += "photos = [\"" + ngi.folder + "/photos/*.tif\"]\n";
  text += "approximations = \"approx.csv\"\n";
  text += "[approximate_accuracy]\nposition_m = 150\nattitude_deg = 2\n" + further;
  WriteFileAtomically(folder / "block.toml", text);
}

std::vector<ExteriorResult> Results(const Ngi& ngi, const TemporaryFolder& folder) {
  std::vector<ExteriorResult> results;
  for (const std::string& number : kNumbers)
    results.push_back(
        ReadExteriorResult(ExteriorResultPath(folder / "out", PhotoName(ngi.Photo(number)))));
  return results;
}

// RMS of where patches of other orthophotos lie in the photos beside where the block's final poses
// put them. These patches know nothing of the block.
struct CheckRms {
  double block_px = 0, published_px = 0;  // under the block's poses and the published ones
};

CheckRms CheckPatches(const Ngi& ngi, const TemporaryFolder& folder, const std::string& database) {
  std::vector<std::string> arguments = {"exterior",
                                        "--camera",
                                        ngi.folder + "/camera.toml",
                                        "--approximations",
                                        folder / "out/orientation.csv",
                                        "--dem",
                                        ngi.folder + "/dem.tif",
                                        "--patchdb",
                                        database,
                                        "--out",
                                        folder / "check",
                                        "--overwrite",
                                        "--no-feedback"};
  for (const std::string& number : kNumbers) arguments.push_back(ngi.Photo(number));
  const ProgramRun run = RunOrient(arguments);
  EXPECT_EQ(run.exit_code, 0) << run.out << run.err;
  const OrientationTable block = ReadOrientationTable(folder / "out/orientation.csv");
  CheckRms sum;
  int count = 0;
  for (const std::string& number : kNumbers) {
    const std::string name = PhotoName(ngi.Photo(number));
    const ExteriorResult found = ReadExteriorResult(ExteriorResultPath(folder / "check", name));
    const Affine2d photo_from_pixel = DigitalPhotoFromPixel(ngi.camera.camera);
    const PhotoView view{ngi.camera.camera, photo_from_pixel, block.Find(name)->pose};
    const PhotoView published{ngi.camera.camera, photo_from_pixel, ngi.Published(number).pose};
    CheckRms photo;
    int photo_count = 0;
    Eigen::Vector2d shift = Eigen::Vector2d::Zero();
    for (const PatchResult& patch : found.patches) {
      if (patch.state != PatchState::kMatched) continue;
      const Eigen::Vector2d off = *patch.pixel - *view.PixelFromGround(*patch.ground_m);
      shift += off;
      photo.block_px += off.squaredNorm();
      photo.published_px +=
          (*patch.pixel - *published.PixelFromGround(*patch.ground_m)).squaredNorm();
      ++photo_count;
    }
    const double n = std::max(photo_count, 1);
    shift /= n;
    std::printf(
        "check patches in %s: %d, RMS %.3f px, under the published orientation %.3f px; "
        "without their mean of %.2f %.2f px %.3f px\n",
        number.c_str(), photo_count, std::sqrt(photo.block_px / n),
        std::sqrt(photo.published_px / n), shift.x(), shift.y(),
        std::sqrt(std::max(0.0, photo.block_px / n - shift.squaredNorm())));
    sum.block_px += photo.block_px;
    sum.published_px += photo.published_px;
    count += photo_count;
  }
  EXPECT_GT(count, 200);
  return {std::sqrt(sum.block_px / std::max(count, 1)),
          std::sqrt(sum.published_px / std::max(count, 1))};
}

struct Strip {
  std::string name;
  std::vector<std::string> numbers, others;
  double most_px = 0;          // RMS over a frame
  double most_normalised = 0;  // errors over their sigmas
  double most_checks = 0;      // check patches' RMS over that of the published orientation
};
void PrintTo(const Strip& strip, std::ostream* out) { *out << strip.name; }

class SlowNgiBlock : public testing::TestWithParam<Strip> {};

TEST_P(SlowNgiBlock, IsOrientedByOneStripsOrthophotos) {
  ORIENT_REQUIRE_SHARED_DATA(data, "ngi");
  const Ngi ngi(data);
  const TemporaryFolder folder;
  Harvest(ngi, folder / "patches.gpkg", GetParam().numbers);
  WriteBlock(ngi, folder, "");
  const ProgramRun run = RunOrient({"block", folder / "block.toml", "--no-feedback"});
  ASSERT_EQ(run.exit_code, 0) << run.out << run.err;
  std::printf("%s", run.out.c_str());
  double chi2 = 0;
  for (const ExteriorResult& result : Results(ngi, folder)) {
    ASSERT_TRUE(result.pose);
    ASSERT_TRUE(result.alone && result.alone->pose);
    ExteriorResult alone = result;
    alone.pose = result.alone->pose;
    const Vector6d off = PoseDifference(*result.pose, ngi.published.Find(result.photo)->pose);
    chi2 += off.dot(result.covariance->ldlt().solve(off));
    std::printf("%s: frame rms %.3f px (alone %.3f), position %.1f m, %d ties used, rms %.2f px\n",
                result.photo.c_str(), ngi.FrameRms(result), ngi.FrameRms(alone),
                ngi.PositionError(result), result.ties->used, result.ties->rms_px.value_or(0));
    EXPECT_LE(ngi.FrameRms(result), GetParam().most_px) << result.photo;
  }
  const double normalised = std::sqrt(chi2 / 24);
  std::printf("normalised errors of the poses: RMS %.2f\n", normalised);
  EXPECT_LT(normalised, GetParam().most_normalised);
  Harvest(ngi, folder / "check.gpkg", GetParam().others);
  const CheckRms check = CheckPatches(ngi, folder, folder / "check.gpkg");
  std::printf("check patches: RMS %.3f px, under the published orientation %.3f px\n",
              check.block_px, check.published_px);
  // Not the 0.5 px that was hoped for: these orthophotos differ from the published orientation by
  // as much themselves (NgiOrthophotos.DifferFromTheirOwnPhotos...).
  EXPECT_LE(check.block_px, GetParam().most_checks * check.published_px);
}

// The scale of strip 06's orthophotos is wrong by 0.1 %, which is more than they state and nothing
// within the block shows: the other strip is tilted about their common edge.
INSTANTIATE_TEST_SUITE_P(
    Strips, SlowNgiBlock,
    testing::Values(Strip{"Strip05", {"0182", "0184"}, {"0251", "0253"}, 0.3, 1.5, 1.1},
                    Strip{"Strip06", {"0251", "0253"}, {"0182", "0184"}, 0.75, 2.1, 1.5}),
    [](const auto& strip) { return strip.param.name; });

}  // namespace
}  // namespace orient
