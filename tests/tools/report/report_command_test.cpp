#include <gdal_priv.h>
#include <gtest/gtest.h>
#include <ogrsf_frmts.h>

#include <filesystem>
#include <fstream>
#include <sstream>

#include "core/base/atomic_write.h"
#include "tests/support/shared_data.h"
#include "tests/tools/report/example_block.h"
#include "tools/commands/commands.h"

namespace orient {
namespace {

int RunReport(const std::string& directory, std::string* out, std::string* err) {
  std::ostringstream out_stream, err_stream;
  const int code = RunProgram(MakeCommands(), {"report", directory}, out_stream, err_stream);
  *out = out_stream.str();
  *err = err_stream.str();
  return code;
}

TEST(ReportCommand, WritesPageAndGeopackageAndNamesThem) {
  const TemporaryFolder folder;
  WriteExampleBlock(folder.Path());
  std::string out, err;
  EXPECT_EQ(RunReport(folder.Path(), &out, &err), 0) << err;
  std::string paths;
  for (const char* file : {"report.html", "block.gpkg", "block.qgz"}) {
    paths += (folder / file) + "\n";
    EXPECT_TRUE(std::filesystem::exists(folder / file)) << file;
  }
  EXPECT_EQ(out, paths);
}

TEST(ReportCommand, PosesOfTwoRunsAreBadInput) {
  const TemporaryFolder folder;
  WriteExampleBlock(folder.Path());
  const std::string path = ExteriorResultPath(folder.Path(), "4711");
  ExteriorResult moved = ReadExteriorResult(path);
  moved.pose->position_m.x() += 0.01;
  WriteExteriorResult(folder.Path(), moved);
  std::string out, err;
  EXPECT_EQ(RunReport(folder.Path(), &out, &err), 2);
  EXPECT_NE(err.find("state different poses of 4711"), std::string::npos) << err;
  EXPECT_TRUE(std::filesystem::exists(folder / "report.html"));
}

TEST(ReportCommand, APatchDatabaseIsNotReplaced) {
  const TemporaryFolder folder;
  WriteExampleBlock(folder.Path());
  std::ostringstream ignored;
  ASSERT_EQ(RunProgram(MakeCommands(),
                       {"patchdb", "create", folder / "block.gpkg", "--crs", "EPSG:32635"}, ignored,
                       ignored),
            0);
  const std::string before = ReadFile(folder / "block.gpkg");
  std::string out, err;
  EXPECT_EQ(RunReport(folder.Path(), &out, &err), 1);
  EXPECT_NE(err.find("block.gpkg is a patch database"), std::string::npos) << err;
  EXPECT_EQ(ReadFile(folder / "block.gpkg"), before);
}

TEST(ReportCommand, SaysThatTheBlocksRunHasNotEnded) {
  const TemporaryFolder folder;
  WriteExampleBlock(folder.Path());
  const std::string said = "the last run into " + folder.Path() + " has not ended";
  std::string out, err;
  EXPECT_EQ(RunReport(folder.Path(), &out, &err), 0) << err;
  EXPECT_EQ(ReadFile(folder / "report.html").find(said), std::string::npos);
  std::filesystem::create_directory(folder / "stages");
  std::ofstream(folder / "stages/unfinished") << "\n";
  EXPECT_EQ(RunReport(folder.Path(), &out, &err), 0) << err;
  EXPECT_NE(ReadFile(folder / "report.html").find(said), std::string::npos);
}

TEST(ReportCommand, WithoutCrsThereIsNoGeopackage) {
  const TemporaryFolder folder;
  WriteExampleBlock(folder.Path());
  std::filesystem::remove(folder / "orientation.prj");
  std::string out, err;
  EXPECT_EQ(RunReport(folder.Path(), &out, &err), 0) << err;
  EXPECT_EQ(out, (folder / "report.html") + "\n");
  EXPECT_FALSE(std::filesystem::exists(folder / "block.gpkg"));
}

TEST(ReportCommand, DamagedFileIsBadInputButTheReportIsThere) {
  const TemporaryFolder folder;
  WriteExampleBlock(folder.Path());
  std::ofstream(folder / "4714.exterior.json") << "{";
  std::string out, err;
  EXPECT_EQ(RunReport(folder.Path(), &out, &err), 2);
  EXPECT_NE(err.find("4714.exterior.json"), std::string::npos) << err;
  EXPECT_TRUE(std::filesystem::exists(folder / "report.html"));
}

TEST(ReportCommand, TheGeopackageHasPhotosWithoutAResultWithTheirReason) {
  const TemporaryFolder folder;
  WriteExampleBlock(folder.Path());
  std::ofstream(folder / "4721.exterior.json") << "{";
  InteriorResult failed;
  failed.photo = "4722";
  failed.findings = {{.reason = Reason::kStated, .where = "no marks were found"}};
  WriteInteriorResult(folder.Path(), failed);
  std::ofstream(folder / "orientation.csv", std::ios::app) << "4723,500000,5000000,1800,0,0,0\n";
  std::string out, err;
  RunReport(folder.Path(), &out, &err);
  const GDALDatasetUniquePtr file(
      GDALDataset::Open((folder / "block.gpkg").c_str(), GDAL_OF_VECTOR));
  OGRLayer* layer = file->GetLayerByName("photos");
  const auto expect = [&](const std::string& photo, const char* status, const char* word) {
    layer->SetAttributeFilter(("name = '" + photo + "'").c_str());
    layer->ResetReading();
    const OGRFeatureUniquePtr row(layer->GetNextFeature());
    ASSERT_TRUE(row) << photo;
    EXPECT_EQ(row->GetGeometryRef(), nullptr) << photo;
    EXPECT_STREQ(row->GetFieldAsString("status"), status) << photo;
    const std::string message = row->GetFieldAsString("message");
    EXPECT_NE(message.find(word), std::string::npos) << message;
  };
  expect("4721", "failed", "4721.exterior.json");
  expect("4722", "failed", "mark");
  expect("4723", "weak", "only orientation.csv has this photo");
}

}  // namespace
}  // namespace orient
