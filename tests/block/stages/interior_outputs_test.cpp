#include "block/stages/interior_outputs.h"

#include <gtest/gtest.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <random>
#include <sstream>

#include "block/inputs/digest.h"
#include "core/base/atomic_write.h"
#include "tests/support/film_frame.h"
#include "tests/support/shared_data.h"
#include "tools/commands/commands.h"

namespace orient::block {
namespace {
namespace fs = std::filesystem;

int Lines(const std::string& path) {
  const std::string text = ReadFile(path);
  return static_cast<int>(std::count(text.begin(), text.end(), '\n'));
}

int Orient(const std::vector<std::string>& arguments) {
  CommandList commands;
  commands.push_back(MakeInteriorCommand());
  std::ostringstream out, err;
  const int code = RunProgram(commands, arguments, out, err);
  EXPECT_NE(code, 1) << err.str();
  return code;
}

// Twelve photos of one roll, the last one stretched by 1 %.
std::vector<InteriorResult> Roll() {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  std::vector<InteriorResult> results;
  for (int i = 0; i < 12; ++i) {
    InteriorResult result;
    result.photo = "p" + std::to_string(10 + i);
    result.status = Status::kOk;
    result.photo_from_pixel = Affine2d{
        Eigen::Matrix2d{{0.025 * (1 + 1e-4 * normal(random)), 0}, {0, -0.025}}, {-100, 100}};
    if (i == 11) result.photo_from_pixel->A(0, 0) *= 1.01;
    result.sigma0_um = 4 + 0.3 * normal(random);
    for (int mark = 0; mark < 4; ++mark) {
      result.marks.push_back({std::to_string(mark + 1), MarkState::kUsed,
                              Eigen::Vector2d(100 * mark, 50), Eigen::Vector2d(0.1, 0.1),
                              Eigen::Vector2d(normal(random), normal(random)), 0.9});
    }
    results.push_back(result);
  }
  return results;
}

TEST(InteriorOutputs, APhotoThatStandsOutIsWeakInItsFileToo) {
  TemporaryFolder folder;
  std::vector<InteriorResult> results = Roll();
  for (const InteriorResult& result : results) WriteInteriorResult(folder.Path(), result);
  const CameraFile camera = RingCamera(30, 70);
  WriteInteriorOutputs(folder.Path(), &camera, {}, &results);
  const InteriorResult odd = ReadInteriorResult(InteriorResultPath(folder.Path(), "p21"));
  EXPECT_EQ(odd.status, Status::kWeak);
  EXPECT_EQ(odd.status_alone, Status::kOk);
  EXPECT_FALSE(odd.findings.empty());
  EXPECT_EQ(ReadInteriorResult(InteriorResultPath(folder.Path(), "p10")).status, Status::kOk);
  EXPECT_NE(ReadFile(folder / "interior.csv").find("p21,weak"), std::string::npos);
  EXPECT_EQ(Lines(folder / "marks.csv"), 1 + 12 * 4);

  // Resumed without it, everything follows from the results alone.
  const std::string before = ReadFile(folder / "interior.csv");
  std::vector<InteriorResult> again;
  for (const InteriorResult& result : Roll())
    again.push_back(ReadInteriorResult(InteriorResultPath(folder.Path(), result.photo)));
  WriteInteriorOutputs(folder.Path(), &camera, {}, &again);
  EXPECT_EQ(ReadFile(folder / "interior.csv"), before);
}

TEST(InteriorOutputs, ARunOfSeveralScansLeavesTablesSheetAndMicmacFiles) {
  TemporaryFolder folder;
  const std::string camera = folder / "camera.toml", out = folder / "out";
  WriteCameraFile(camera, RingCamera(30, 70));
  std::vector<std::string> arguments = {"interior", "--camera",        camera, "--out",
                                        out,        "--pixel-size-um", "100",  "--micmac"};
  for (unsigned seed = 1; seed <= 3; ++seed) {
    FilmFrameSpec spec;
    spec.camera = RingCamera(30, 70);
    spec.seed = seed;
    const std::string scan = folder / ("scan" + std::to_string(seed) + ".png");
    WriteScan(scan, RenderFilmFrame(spec).scan);
    arguments.push_back(scan);
  }
  EXPECT_EQ(Orient(arguments), 0);
  EXPECT_EQ(Lines(out + "/interior.csv"), 4);
  EXPECT_EQ(Lines(out + "/marks.csv"), 13);
  EXPECT_TRUE(fs::exists(out + "/contact_sheet.png"));
  EXPECT_NE(ReadFile(out + "/Ori-InterneScan/MeasuresCamera.xml").find("<NamePt>4</NamePt>"),
            std::string::npos);
  EXPECT_NE(ReadFile(out + "/Ori-InterneScan/MeasuresIm-scan2.png.xml").find("scan2.png"),
            std::string::npos);
  for (const auto& entry : fs::directory_iterator(out))
    EXPECT_FALSE(entry.path().string().ends_with(".part")) << entry.path();

  // What a kill leaves: results of some photos, none of the tables.
  for (const char* name : {"/interior.csv", "/contact_sheet.png", "/scan2.interior.json"})
    fs::remove(out + name);
  arguments.push_back("--resume");
  EXPECT_EQ(Orient(arguments), 0);
  EXPECT_EQ(Lines(out + "/interior.csv"), 4);
  EXPECT_TRUE(fs::exists(out + "/contact_sheet.png"));
}

// The damage lies between the pieces of the file that a resumed run compares.
TEST(InteriorOutputs, ADamagedScanReplacedByASoundOneThatLooksTheSameIsReadOnResume) {
  TemporaryFolder folder;
  const std::string camera = folder / "camera.toml", scan = folder / "scan.png";
  WriteCameraFile(camera, RingCamera(30, 70));
  FilmFrameSpec spec;
  spec.camera = RingCamera(30, 70);
  WriteScan(scan, RenderFilmFrame(spec).scan);
  const std::string sound = ReadFile(scan), digest = DigestOfFile(scan);
  ASSERT_GT(sound.size(), std::size_t{4} << 16);
  WriteFileAtomically(scan, std::string(sound).replace(std::size_t{1} << 16, 20000, 20000, '\0'));
  ASSERT_EQ(DigestOfFile(scan), digest);
  const std::vector<std::string> arguments = {
      "interior", "--camera", camera, "--pixel-size-um", "100", "--out", folder / "out", scan};
  EXPECT_EQ(Orient(arguments), 3);
  WriteFileAtomically(scan, sound);
  std::vector<std::string> resumed = arguments;
  resumed.push_back("--resume");
  EXPECT_EQ(Orient(resumed), 0);
  EXPECT_EQ(ReadInteriorResult(InteriorResultPath(folder / "out", "scan")).status, Status::kOk);
}

}  // namespace
}  // namespace orient::block
