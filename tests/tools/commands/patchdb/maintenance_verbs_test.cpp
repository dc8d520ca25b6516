// The verbs that look after a patch database, as a user types them.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "core/raster/raster.h"
#include "patchdb/store/schema.h"
#include "tests/support/made_up_patches.h"
#include "tests/support/older_patchdb.h"
#include "tests/support/run_orient.h"
#include "tests/support/shared_data.h"

namespace orient {
namespace {

bool Contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

class MaintenanceVerbsTest : public testing::Test {
 protected:
  MaintenanceVerbsTest() { MadeUpDatabase(path_, 4, 3); }
  ProgramRun Orient(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "patchdb");
    arguments.insert(arguments.begin() + 2, path_);
    return RunOrient(arguments);
  }
  int Lines(const std::vector<std::string>& arguments) {
    const ProgramRun outcome = Orient(arguments);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    return static_cast<int>(std::count(outcome.out.begin(), outcome.out.end(), '\n'));
  }
  TemporaryFolder folder_;
  std::string path_ = folder_ / "patches.gpkg";
};

TEST_F(MaintenanceVerbsTest, QueryByBoxPolygonAndRule) {
  EXPECT_EQ(Lines({"list"}), 13);
  EXPECT_EQ(Lines({"query", "--box", "500050", "4999950", "500250", "5000050"}), 3);
  EXPECT_EQ(Lines({"query", "--box", "-10", "-10", "-5", "-5"}), 1);
  const std::string polygon = folder_ / "area.geojson";
  std::ofstream(polygon) << R"({"type":"Feature","properties":{},"crs":{"type":"name","properties":
      {"name":"urn:ogc:def:crs:EPSG::32635"}},"geometry":{"type":"Polygon","coordinates":
      [[[500050,4999950],[500250,4999950],[500250,5000050],[500050,5000050],[500050,4999950]]]}})";
  EXPECT_EQ(Lines({"query", "--polygon", polygon}), 3);
  EXPECT_EQ(Lines({"query", "--max-quality", "0.5"}), 1);
  EXPECT_EQ(Orient({"query", "--box", "2", "2", "1", "1"}).exit_code, 1);
  EXPECT_EQ(Orient({"query", "--box", "nan", "2", "3", "4"}).exit_code, 1);
  EXPECT_EQ(Orient({"query", "--max-quality", "5"}).exit_code, 1);
  EXPECT_EQ(Orient({"query", "--polygon", folder_ / "none.shp"}).exit_code, 2);
}

TEST_F(MaintenanceVerbsTest, QueryUnderAPhotoGivesThePlaceInThePhoto) {
  const std::string camera = folder_ / "camera.toml", table = folder_ / "opk.csv";
  std::ofstream(camera) << "name = \"test\"\nkind = \"digital\"\nprincipal_distance_mm = 100.0\n"
                           "principal_point_mm = [0.0, 0.0]\nframe_mm = [50.0, 50.0]\n"
                           "image_px = [5000, 5000]\n";
  std::ofstream(table) << "filename,x,y,z,omega,phi,kappa\na,500100,5000100,620,0,0,0\n";
  const ProgramRun seen =
      Orient({"query", "--photo", "a", "--camera", camera, "--orientation", table});
  ASSERT_EQ(seen.exit_code, 0) << seen.err;
  // 500 m above the patches the frame covers 125 m to every side.
  EXPECT_EQ(std::count(seen.out.begin(), seen.out.end(), '\n'), 10) << seen.out;
  EXPECT_TRUE(Contains(seen.out, ",-20.0000,-20.0000\n")) << seen.out;
  EXPECT_EQ(Orient({"query", "--photo", "a"}).exit_code, 1);
  EXPECT_EQ(Orient({"query", "--photo", "b", "--camera", camera, "--orientation", table}).exit_code,
            2);
}

TEST_F(MaintenanceVerbsTest, OnlyWhatWritesBringsAnOlderFileUpToDateAndSaysSo) {
  MakeVersion3(path_);
  EXPECT_EQ(Lines({"list"}), 13);
  EXPECT_EQ(Orient({"check"}).exit_code, 0);
  EXPECT_TRUE(Contains(Orient({"retire", "--id", "3"}).out, "1 patches would be retired"));
  EXPECT_TRUE(Contains(Orient({"info"}).out, "version 3"));
  const std::string now = std::to_string(patchdb::CurrentSchemaVersion());
  const std::string words = "patches.gpkg: upgraded from schema version 3 to " + now + "\n";
  const ProgramRun first = Orient({"retire", "--id", "3", "--apply"});
  EXPECT_TRUE(Contains(first.out, words)) << first.out << first.err;
  EXPECT_TRUE(Contains(first.out, "1 patches retired")) << first.out;
  EXPECT_TRUE(Contains(Orient({"info"}).out, "version " + now));
  EXPECT_FALSE(Contains(Orient({"restore", "--id", "3", "--apply"}).out, "upgraded"));
  EXPECT_EQ(Orient({"check"}).exit_code, 0);
}

TEST_F(MaintenanceVerbsTest, NoOutputTakesADatabasesPlace) {
  for (const std::vector<std::string>& words :
       {std::vector<std::string>{"export", "--overwrite", "--csv", path_},
        {"export", "--overwrite", "--geojson", path_},
        {"show", "--out", path_},
        {"stats", "--density", path_}}) {
    const ProgramRun outcome = Orient(words);
    EXPECT_EQ(outcome.exit_code, 1) << words[0];
    EXPECT_TRUE(Contains(outcome.err, path_ + " is a database")) << outcome.err;
  }
  EXPECT_EQ(Lines({"list"}), 13);
}

TEST_F(MaintenanceVerbsTest, DryRunChangesNothing) {
  const ProgramRun dry = Orient({"retire", "--id", "3,5", "--reason", "a roof"});
  EXPECT_TRUE(Contains(dry.out, "2 patches would be retired")) << dry.out << dry.err;
  EXPECT_TRUE(Contains(dry.out, "ids 3 5")) << dry.out;
  EXPECT_EQ(Lines({"list", "--state", "retired"}), 1);
}

TEST_F(MaintenanceVerbsTest, RetireRestorePrune) {
  EXPECT_EQ(Orient({"retire", "--id", "3,5", "--reason", "a roof", "--apply"}).exit_code, 0);
  EXPECT_TRUE(Contains(Orient({"list", "--state", "retired"}).out, "a roof"));
  EXPECT_TRUE(Contains(Orient({"restore", "--id", "3", "--apply"}).out, "1 patches restored"));
  EXPECT_TRUE(Contains(Orient({"prune", "--id", "3,5", "--apply"}).out, "1 patches deleted"));
  EXPECT_EQ(Lines({"list"}), 12);
}

TEST_F(MaintenanceVerbsTest, NumbersThatNoPatchHasAreNamedAndNothingIsDone) {
  for (const std::vector<std::string>& words :
       {std::vector<std::string>{"retire", "--id", "3,998,999", "--apply"},
        {"retire", "--id", "3,998,999"},
        {"query", "--id", "3,998,999"}}) {
    const ProgramRun run = Orient(words);
    EXPECT_EQ(run.exit_code, 2) << run.out;
    EXPECT_TRUE(Contains(run.err, "has no patch 998, 999")) << run.err;
    EXPECT_EQ(run.out, "");
  }
  EXPECT_EQ(Lines({"list", "--state", "retired"}), 1) << "patch 3 is not retired, either";
  EXPECT_TRUE(Contains(Orient({"prune", "--id", "998", "--apply"}).out, "0 patches deleted"))
      << "a repeated run finds nothing left to do";
}

TEST_F(MaintenanceVerbsTest, WithoutARuleNothingIsRetiredOrDeleted) {
  for (const char* verb : {"retire", "restore", "prune"})
    EXPECT_EQ(Orient({verb, "--apply"}).exit_code, 1) << verb;
}

TEST_F(MaintenanceVerbsTest, ShowDrawsASheet) {
  const std::string sheet = folder_ / "sheet.png";
  const ProgramRun outcome = Orient({"show", "--out", sheet, "--max", "5"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_TRUE(Contains(outcome.out, "5 of 12")) << outcome.out;
  const Raster raster = Raster::Open(sheet);
  EXPECT_EQ(raster.Bands(), 3);
  const ImageWindow window = raster.ReadGrey();
  const auto [low, high] =
      std::minmax_element(window.image.values.begin(), window.image.values.end());
  EXPECT_LT(*low, 10);
  EXPECT_GT(*high, 250);
  EXPECT_EQ(Orient({"show", "--out", sheet}).exit_code, 1) << "it would be replaced";
  EXPECT_EQ(Orient({"show", "--out", sheet, "--overwrite", "--id", "99"}).exit_code, 2);
}

TEST_F(MaintenanceVerbsTest, StatsWritesADensityMap) {
  const std::string map = folder_ / "density.tif";
  const ProgramRun outcome = Orient({"stats", "--density", map, "--cell-m", "100"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_TRUE(Contains(outcome.out, "1990.tif")) << outcome.out;
  const Raster raster = Raster::Open(map);
  EXPECT_EQ(raster.Width(), 4);
  EXPECT_EQ(raster.Height(), 3);
  for (const float count : raster.ReadGrey().image.values) EXPECT_EQ(count, 1);
  EXPECT_FALSE(std::filesystem::exists(map + ".part"));
  EXPECT_EQ(Orient({"stats", "--density", folder_ / "nowhere/d.tif"}).exit_code, 2);
}

}  // namespace
}  // namespace orient
