#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <sstream>

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

}  // namespace
}  // namespace orient
