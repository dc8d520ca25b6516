#include "block/inputs/camera_library.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>

#include "core/base/atomic_write.h"
#include "core/base/error.h"
#include "patchdb/store/patch_database.h"
#include "tests/support/run_orient.h"
#include "tests/support/shared_data.h"
#include "tools/commands/commands.h"
#include "tools/simulate/simulate.h"

namespace orient::block {
namespace {
namespace fs = std::filesystem;

std::vector<LibraryCamera> Library() { return ReadCameraLibrary(ProjectFile("data/cameras")); }

const LibraryCamera& Named(const std::vector<LibraryCamera>& library, const std::string& name) {
  for (const LibraryCamera& camera : library)
    if (camera.name == name) return camera;
  throw std::invalid_argument(name);
}

std::string TextOf(const std::string& path) {
  std::ifstream file(path);
  std::stringstream text;
  text << file.rdbuf();
  return text.str();
}

// Layout, looks and lens of a camera; its name and the order of its fiducials do not count.
std::string Fingerprint(const std::string& path) {
  std::stringstream lines(TextOf(path));
  std::multiset<std::string> kept;
  std::string block;
  for (std::string line; std::getline(lines, line);) {
    const bool ends = line.empty();
    if (!ends && line[0] != '#' && line.rfind("name", 0) != 0 && line.rfind("id", 0) != 0)
      block += line + "\n";
    if (ends) kept.insert(std::exchange(block, ""));
  }
  kept.insert(block);
  std::string all;
  for (const std::string& b : kept) all += b;
  return all;
}

TEST(CameraLibrary, HoldsTheCommonFilmCameras) {
  const auto library = Library();
  for (const char* name :
       {"wild_18cm", "wild_rc8_23", "wild_rc9", "wild_rc10", "wild_rc30", "zeiss_rmk_mid",
        "zeiss_rmk_corner", "zeiss_rmk_top15", "zeiss_jena_mrb", "park_crosshair", "fairchild_t11",
        "fairchild_t12_cross", "fairchild_kc6a", "wild_p31", "hasselblad_mk_reseau"})
    EXPECT_FALSE(Named(library, name).format_only) << name;
  for (const char* name : {"zeiss_jena_lmk", "zeiss_jena_umk", "williamson_f49"})
    EXPECT_TRUE(Named(library, name).format_only) << name;
}

TEST(CameraLibrary, EveryFileNamesItsSourcesAndThatItIsNominal) {
  for (const LibraryCamera& camera : Library()) {
    const std::string text = TextOf(camera.path);
    EXPECT_EQ(text.rfind("# ", 0), 0U) << camera.path;
    EXPECT_GT(text.find("\nname"), 150U) << camera.path;
    EXPECT_NE(camera.file.camera.name.find("nominal"), std::string::npos) << camera.path;
    EXPECT_EQ(camera.file.camera.name.find("(format only)") != std::string::npos,
              camera.format_only)
        << camera.path;
  }
}

TEST(CameraLibrary, MarksLieOnTheFilm) {
  constexpr double kRebate_mm = 7;  // of 24 cm film around a 23 cm frame, and the T-11's far mark
  for (const LibraryCamera& camera : Library()) {
    const Camera& geometry = camera.file.camera;
    for (const Fiducial& mark : camera.file.fiducials) {
      const Eigen::Vector2d beyond =
          (mark.position_mm - geometry.frame_centre_mm).cwiseAbs() - 0.5 * geometry.frame_mm;
      EXPECT_LT(beyond.maxCoeff(), kRebate_mm) << camera.path << " mark " << mark.id;
    }
  }
}

TEST(CameraLibrary, EveryMarkIsDrawnAndUsed) {
  const Eigen::Matrix2d pixel_from_mm = Eigen::Vector2d(20, -20).asDiagonal();
  for (const LibraryCamera& camera : Library()) {
    std::set<std::string> used;
    for (const Fiducial& mark : camera.file.fiducials) used.insert(mark.mark);
    EXPECT_EQ(used.size(), camera.file.marks.size()) << camera.path;
    for (const auto& [name, shape] : camera.shapes) {
      const interior::MarkTemplate drawn = interior::RenderMark(shape, pixel_from_mm);
      float lowest = 2, highest = -2;
      for (const float value : drawn.values.values) {
        if (std::isnan(value)) continue;
        lowest = std::min(lowest, value);
        highest = std::max(highest, value);
      }
      EXPECT_GT(highest - lowest, 0.2F) << camera.path << " mark " << name;
    }
  }
}

TEST(CameraLibrary, NoTwoFilesAreTheSameCamera) {
  std::map<std::string, std::string> known;
  for (const LibraryCamera& camera : Library()) {
    const auto [other, added] = known.emplace(Fingerprint(camera.path), camera.name);
    EXPECT_TRUE(added) << camera.name << " and " << other->second;
  }
}

TEST(CameraLibrary, ANameThatIsNoFileIsLookedUp) {
  EXPECT_EQ(FindCameraFile("wild_rc10", ProjectFile("data/cameras")),
            ProjectFile("data/cameras/wild_rc10.toml"));
  EXPECT_EQ(FindCameraFile("zeiss_jena_umk", ProjectFile("data/cameras")),
            ProjectFile("data/cameras/format_only/zeiss_jena_umk.toml"));
  const std::string file = ProjectFile("data/cameras/wild_rc9.toml");
  EXPECT_EQ(FindCameraFile(file, "nowhere"), file);
}

TEST(CameraLibrary, AnUnknownNameIsToldWithWhatThereIs) {
  try {
    FindCameraFile("wild_rc11", ProjectFile("data/cameras"));
    FAIL() << "found";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("wild_rc10"), std::string::npos) << error.what();
  }
}

TEST(CameraLibrary, TheFolderComesFromTheOptionThenTheEnvironmentThenTheProgram) {
  const TemporaryFolder given, environment;
  EXPECT_EQ(CameraLibraryFolder(given.Path()), given.Path());
  ASSERT_EQ(setenv("ORIENT_CAMERAS", environment.Path().c_str(), 1), 0);
  EXPECT_EQ(CameraLibraryFolder(given.Path()), given.Path());
  EXPECT_EQ(CameraLibraryFolder(""), environment.Path());
  ASSERT_EQ(unsetenv("ORIENT_CAMERAS"), 0);
  EXPECT_TRUE(fs::exists(fs::path(CameraLibraryFolder("")) / "wild_rc10.toml"));
  EXPECT_THROW(CameraLibraryFolder(given / "nowhere"), InputError);
  EXPECT_THROW(ReadCameraLibrary(given.Path()), InputError);
}

TEST(CamerasCommand, ListsNamesAndWhatAutoKnows) {
  CommandList commands;
  commands.push_back(MakeCamerasCommand());
  std::ostringstream out, err;
  EXPECT_EQ(
      RunProgram(commands, {"cameras", "--camera-library", ProjectFile("data/cameras")}, out, err),
      0)
      << err.str();
  EXPECT_NE(out.str().find("wild_rc10"), std::string::npos);
  EXPECT_NE(out.str().find("zeiss_jena_lmk"), std::string::npos);
}

// A film block of one small photo, which nothing could orient.
class BlockCommandOnFilm : public testing::Test {
 protected:
  BlockCommandOnFilm() {
    SimulationOptions simulation;
    simulation.photos = 1;
    simulation.pixel_size_um = 400;
    simulation.gsd_m = 4;
    simulation.objects = false;
    Simulate(simulation, block_);
    patchdb::PatchDatabase::Create(block_ + "/patches.gpkg",
                                   Crs::Parse(simulation.crs, "simulation"));
  }

  void Replace(const std::string& from, const std::string& to) const {
    std::string text = ReadFile(block_ + "/block.toml");
    text.replace(text.find(from), from.size(), to);
    WriteFileAtomically(block_ + "/block.toml", text);
  }

  std::pair<int, std::string> Plan(const std::vector<std::string>& more = {}) const {
    std::vector<std::string> words = {"block", block_ + "/block.toml", "--plan", "--camera-library",
                                      ProjectFile("data/cameras")};
    words.insert(words.end(), more.begin(), more.end());
    const ProgramRun run = RunOrient(words);
    return {run.exit_code, run.out + run.err};
  }

  const TemporaryFolder folder_;
  const std::string block_ = folder_ / "block";
};

TEST_F(BlockCommandOnFilm, TakesACameraByItsNameInTheLibrary) {
  Replace("\"camera.toml\"", "\"wild_rc10\"");
  const auto [code, said] = Plan();
  EXPECT_EQ(code, 0) << said;
  EXPECT_NE(said.find("interior  new_1_1"), std::string::npos) << said;  // a film camera
  Replace("wild_rc10", "wild_rc11");
  const auto [wrong, why] = Plan();
  EXPECT_EQ(wrong, 2);
  EXPECT_NE(why.find("wild_rc10"), std::string::npos) << why;
}

TEST_F(BlockCommandOnFilm, PlansWhatARunWouldDo) {
  const ProgramRun interior = RunOrient(
      {"interior", block_ + "/scans/new_1_1.tif", "--camera", block_ + "/camera.toml", "--out",
       block_ + "/out", "--pixel-size-um", "400", "--polarity", "positive", "--orientation", "r0"});
  ASSERT_EQ(interior.err, "");
  EXPECT_NE(Plan({"--resume"}).second.find("keep  interior  new_1_1"), std::string::npos);
  Replace("\"positive\"", "\"negative\"");
  EXPECT_NE(Plan({"--resume"}).second.find("do    interior  new_1_1"), std::string::npos);
  Replace("EPSG:32635", "EPSG:32631");
  const auto [code, said] = Plan({"--resume"});
  EXPECT_EQ(code, 2) << said;
  EXPECT_NE(said.find("use a patch database in the block's CRS"), std::string::npos) << said;
}

}  // namespace
}  // namespace orient::block
