// Names with blanks for programs that cut them there.
#include "tools/convert/program_names.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "core/base/atomic_write.h"
#include "core/files/camera_file.h"
#include "core/files/orientation_table.h"
#include "tests/support/run_orient.h"
#include "tests/support/shared_data.h"
#include "tests/tools/convert/two_photos.h"
#include "tools/convert/export_record.h"
#include "tools/convert/program_folders.h"

namespace orient {
namespace {
namespace fs = std::filesystem;
using Names = std::vector<std::string>;

ExchangeBlock Named(const Names& names) {
  ExchangeBlock block;
  for (const std::string& name : names) block.photos.emplace_back().image = name;
  return block;
}

TEST(ProgramNames, OfColmapAndAspHoldNoBlanksAndStayApart) {
  const ExchangeBlock block = Named({"a b.tif", "a_b.tif", "a\tb.tif", "c.tif"});
  for (const ExchangeFormat format : {ExchangeFormat::kColmap, ExchangeFormat::kAsp})
    EXPECT_EQ(NamesInFiles(block, format), Names({"a_b_2.tif", "a_b.tif", "a_b_3.tif", "c.tif"}));
  EXPECT_EQ(NamesInFiles(block, ExchangeFormat::kOpensfm)[0], "a b.tif");
}

TEST(ProgramNames, AreRestoredWithAndWithoutTheirEnding) {
  ExchangeBlock block = Named({"a_b_2.tif", "a_b_2", "a_b.tif"});
  RestoreNames({{"a_b_2.tif", "a b.tif"}}, &block);
  EXPECT_EQ(block.photos[0].image, "a b.tif");
  EXPECT_EQ(block.photos[1].image, "a b");
  EXPECT_EQ(block.photos[2].image, "a_b.tif");
}

TEST(ProgramNames, OfFormatsWithoutFoldersAreRestoredWithTheirs) {
  ExchangeBlock block = Named({"b_c"});
  RestoreNames({{"sub/b_c.jpg", "sub/b c.jpg"}}, &block);
  EXPECT_EQ(block.photos[0].image, "sub/b c");
}

class NamesWithBlanks : public testing::Test {
 protected:
  NamesWithBlanks() {
    OrientationTable table;
    table.crs = TwoPhotos().crs;
    for (const char* photo : {"flight 3 a", "b"}) {
      table.rows.push_back({photo, PoseOf(TwoPhotos().block.photos[table.rows.size()]), {}});
      std::ofstream(folder_ / (std::string(photo) + ".tif")) << photo;
    }
    WriteOrientationTable(folder_ / "orientation.csv", table);
    WriteCameraFile(folder_ / "camera.toml", {LargeFrameCamera(), {}, {}, std::nullopt, {}});
  }

  ProgramRun Convert() const {
    return RunOrient({"convert", folder_.Path(), "--camera", folder_ / "camera.toml", "--to",
                      "colmap,asp", "--ground-height-m", "300", "--out", folder_ / "out",
                      "--overwrite", "--images", folder_ / "flight 3 a.tif", folder_ / "b.tif"});
  }

  const TemporaryFolder folder_;
};

TEST_F(NamesWithBlanks, LinksHaveTheNamesInTheFilesAndTheWayBackTheTrueOnes) {
  for (int run = 0; run < 2; ++run) {
    const ProgramRun written = Convert();
    EXPECT_EQ(written.exit_code, 0) << written.err;
    EXPECT_NE(written.out.find("1 photos' names hold blanks"), std::string::npos) << written.out;
    EXPECT_EQ(ReadFile(folder_ / "out/colmap/images/flight_3_a.tif"), "flight 3 a");
    EXPECT_EQ(ReadFile(folder_ / "out/colmap/images/b.tif"), "b");
    EXPECT_EQ(ReadFile(folder_ / "out/asp/flight_3_a.tif"), "flight 3 a");
  }
  EXPECT_NE(ReadFile(folder_ / "out/colmap/images.txt").find(" flight_3_a.tif\n"),
            std::string::npos);
  EXPECT_EQ(ReadExportRecord(folder_ / "out/colmap").names.at("flight_3_a.tif"), "flight 3 a.tif");
  for (const ExchangeFormat format : {ExchangeFormat::kColmap, ExchangeFormat::kAsp}) {
    ConvertSourceOptions back;
    back.input = folder_ / ("out/" + Name(format));
    back.camera = back.input + "/camera.toml";
    const ConvertSource read = ReadForeign(format, back);
    std::vector<std::string> photos;
    for (const ExchangePhoto& photo : read.block.photos)
      photos.push_back(fs::path(photo.image).stem().string());
    std::sort(photos.begin(), photos.end());
    EXPECT_EQ(photos, Names({"b", "flight 3 a"}));
    for (const std::string& message : read.messages)
      EXPECT_EQ(message.find("truncated"), std::string::npos) << message;
  }
}

TEST_F(NamesWithBlanks, AFolderOfLinksGivesWayToALinkWhereNamesNeedNone) {
  ASSERT_EQ(Convert().exit_code, 0);
  LinkImagesForPrograms(folder_ / "out", {ExchangeFormat::kColmap}, Named({"b.tif"}));
  EXPECT_TRUE(fs::is_symlink(folder_ / "out/colmap/images"));
  LinkImagesForPrograms(folder_ / "out", {ExchangeFormat::kColmap}, Named({"flight 3 a.tif"}));
  EXPECT_FALSE(fs::is_symlink(folder_ / "out/colmap/images"));
  EXPECT_TRUE(fs::exists(folder_ / "out/images/b.tif")) << "only links were removed";
}

}  // namespace
}  // namespace orient
