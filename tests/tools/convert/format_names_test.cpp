// How formats are named to orient convert.
#include <gtest/gtest.h>

#include <filesystem>

#include "core/files/camera_file.h"
#include "core/files/orientation_table.h"
#include "tests/support/run_orient.h"
#include "tests/support/shared_data.h"
#include "tests/tools/convert/two_photos.h"

namespace orient {
namespace {

class FormatNames : public testing::Test {
 protected:
  FormatNames() {
    WriteCameraFile(folder_ / "camera.toml", {LargeFrameCamera(), {}, {}, std::nullopt, {}});
    OrientationTable table;
    table.crs = TwoPhotos().crs;
    for (const ExchangePhoto& photo : TwoPhotos().block.photos)
      table.rows.push_back({PhotoName(photo.image), PoseOf(photo), std::nullopt});
    WriteOrientationTable(folder_ / "orientation.csv", table);
  }

  ProgramRun Convert(const std::string& input, const std::vector<std::string>& more) const {
    std::vector<std::string> words = {
        "convert", input,           "--camera",   folder_ / "camera.toml",
        "--out",   folder_ / "out", "--overwrite"};
    words.insert(words.end(), more.begin(), more.end());
    return RunOrient(words);
  }

  const TemporaryFolder folder_;
};

TEST_F(FormatNames, MayBeInUpperCaseAndWithBlanks) {
  const ProgramRun run = Convert(folder_.Path(), {"--from", "OPK", "--to", "COLMAP, ori"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_TRUE(std::filesystem::exists(folder_ / "out/colmap/images.txt"));
  EXPECT_TRUE(std::filesystem::exists(folder_ / "out/ori/orientation.ori"));
}

TEST_F(FormatNames, ThatAreNoneGetTheNearest) {
  for (const char* option : {"--from", "--to"}) {
    const ProgramRun run = Convert(folder_.Path(), {option, "colamp"});
    EXPECT_EQ(run.exit_code, 1);
    EXPECT_NE(run.err.find("did you mean colmap?"), std::string::npos) << run.err;
    EXPECT_NE(run.err.find(option), std::string::npos) << run.err;
  }
  const ProgramRun far = Convert(folder_.Path(), {"--to", "shapefile"});
  EXPECT_NE(far.err.find("formats are opk, ori,"), std::string::npos) << far.err;
}

TEST_F(FormatNames, OfAnExportAreSaidWhereTheyWereLeftOut) {
  ASSERT_EQ(Convert(folder_.Path(), {"--to", "colmap,opk"}).exit_code, 0);
  const ProgramRun run = Convert(folder_ / "out/colmap", {"--to", "ori"});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_NE(run.err.find("holds colmap files: add --from colmap"), std::string::npos) << run.err;
  EXPECT_EQ(Convert(folder_ / "out/opk", {"--to", "ori"}).exit_code, 0);
}

}  // namespace
}  // namespace orient
