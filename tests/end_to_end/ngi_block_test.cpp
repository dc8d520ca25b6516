// The four NGI frames as one block, with patches of the orthophotos of strip 05 only.
#include <gtest/gtest.h>

#include <cmath>

#include "core/files/atomic_write.h"
#include "core/geometry/photo_view.h"
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
double CheckRms(const Ngi& ngi, const TemporaryFolder& folder, const std::string& database) {
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
  const OrientationTable block = ReadOrientationTable(folder / "out/orientation.csv");
  double sum = 0;
  int count = 0;
  for (const std::string& number : kNumbers) {
    const std::string name = PhotoName(ngi.Photo(number));
    const ExteriorResult found = ReadExteriorResult(ExteriorResultPath(folder / "check", name));
    const PhotoView view{ngi.camera.camera, DigitalPhotoFromPixel(ngi.camera.camera),
                         block.Find(name)->pose};
    double photo_sum = 0;
    int photo_count = 0;
    for (const PatchResult& patch : found.patches) {
      if (patch.state != PatchState::kMatched) continue;
      photo_sum += (*patch.pixel - *view.PixelFromGround(*patch.ground_m)).squaredNorm();
      ++photo_count;
    }
    std::printf("check patches in %s: %d, RMS %.3f px\n", number.c_str(), photo_count,
                std::sqrt(photo_sum / std::max(photo_count, 1)));
    sum += photo_sum;
    count += photo_count;
  }
  return std::sqrt(sum / std::max(count, 1));
}

TEST(NgiBlock, PatchesOfStrip05OrientBothStrips) {
  ORIENT_REQUIRE_SHARED_DATA(data, "ngi");
  const Ngi ngi(data);
  const TemporaryFolder folder;
  Harvest(ngi, folder / "patches.gpkg", {"0182", "0184"});
  WriteBlock(ngi, folder, "");
  const ProgramRun run = RunOrient({"block", folder / "block.toml", "--no-feedback"});
  ASSERT_EQ(run.exit_code, 0) << run.out << run.err;
  std::printf("%s", run.out.c_str());
  for (const ExteriorResult& result : Results(ngi, folder)) {
    ASSERT_TRUE(result.pose);
    ASSERT_TRUE(result.alone && result.alone->pose);
    ExteriorResult alone = result;
    alone.pose = result.alone->pose;
    std::printf("%s: frame rms %.3f px (alone %.3f), position %.1f m, %d ties used, rms %.2f px\n",
                result.photo.c_str(), ngi.FrameRms(result), ngi.FrameRms(alone),
                ngi.PositionError(result), result.ties->used, result.ties->rms_px.value_or(0));
    EXPECT_LE(ngi.FrameRms(result), 0.3) << result.photo;
  }
  Harvest(ngi, folder / "check.gpkg", {"0251", "0253"});
  const double check = CheckRms(ngi, folder, folder / "check.gpkg");
  std::printf("check patches: RMS %.3f px\n", check);
  EXPECT_LE(check, 0.5);
}

}  // namespace
}  // namespace orient
