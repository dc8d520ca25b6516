#include "tools/report/ortho_section.h"

#include <fmt/format.h>
#include <gdal_priv.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <map>

#include "block/inputs/block_files.h"
#include "core/base/atomic_write.h"
#include "core/files/orientation_table.h"
#include "core/geometry/rotation.h"
#include "tests/support/shared_data.h"
#include "tests/tools/report/example_block.h"
#include "tests/tools/report/report_page.h"
#include "tools/report/report.h"
#include "tools/report/run_record.h"

namespace orient {
namespace {

// A map of `values` from 0 to 99 with a corner without data, and this metadata.
void WriteMap(const std::string& path, GDALDataType type,
              const std::map<std::string, std::string>& metadata) {
  GDALAllRegister();
  std::filesystem::create_directories(std::filesystem::path(path).parent_path());
  constexpr int kSide = 100;
  const GDALDatasetUniquePtr map(GetGDALDriverManager()->GetDriverByName("GTiff")->Create(
      path.c_str(), kSide, kSide, 1, type, nullptr));
  ASSERT_TRUE(map);
  for (const auto& [name, text] : metadata) map->SetMetadataItem(name.c_str(), text.c_str());
  map->GetRasterBand(1)->SetNoDataValue(0);
  std::vector<float> row(kSide);
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x)
      row[static_cast<std::size_t>(x)] = x + y < 50 ? 0 : 100.0f + static_cast<float>(x);
    ASSERT_EQ(map->GetRasterBand(1)->RasterIO(GF_Write, 0, y, kSide, 1, row.data(), kSide, 1,
                                              GDT_Float32, 0, 0, nullptr),
              CE_None);
  }
}

class OrthoSection : public testing::Test {
 protected:
  OrthoSection() { WriteExampleBlock(folder_.Path()); }
  std::string Html() const { return ReadFile(WriteReport(folder_.Path())); }
  // Two orthophotos, one without CE90, a mosaic of them, seamlines.
  void WriteOrthophotos() const {
    WriteMap(folder_ / "ortho/4711 a.ortho.tif", GDT_Byte,
             {{"ORIENT_GSD_M", "0.25"},
              {"ORIENT_DEM", "dem.tif"},
              {"ORIENT_CE90_MEDIAN_M", "0.19"},
              {"ORIENT_CE90_WORST_M", "0.32"}});
    WriteMap(folder_ / "ortho/4712.ortho.tif", GDT_UInt16, {{"ORIENT_GSD_M", "0.25"}});
    WriteMap(folder_ / "ortho/mosaic.tif", GDT_UInt16,
             {{"ORIENT_CE90_MEDIAN_M", "0.18"}, {"ORIENT_CE90_WORST_M", "0.41"}});
    WriteFileAtomically(folder_ / "ortho/seamlines.gpkg", "");
  }
  TemporaryFolder folder_;
};

TEST_F(OrthoSection, ShowsTheQuicklook) {
  EXPECT_FALSE(Contains(Html(), "<h2>Orthophotos</h2>"));
  WritePng(folder_ / block::kQuicklookFile, 60, 20, false);
  WritePng(folder_ / block::kSeamsFile, 50, 20, false);
  const std::string html = Html();
  EXPECT_EQ(Malformed(html), "");
  EXPECT_TRUE(Contains(html, "<h2>Orthophotos</h2>"));
  EXPECT_TRUE(Contains(html, "width=\"50\" height=\"20\""));
}

TEST_F(OrthoSection, SaysWhatTheOrthophotosSayOfThemselves) {
  WriteOrthophotos();
  const std::string html = Html();
  EXPECT_EQ(Malformed(html), "");
  for (const char* part :
       {"2 orthophotos of 0.25 m a pixel over dem.tif · CE90 0.19 m, at worst 0.32 m",
        "href=\"./ortho/4711%20a.ortho.tif\"", ">0.19</td>", "100 × 100",
        "width=\"100\" height=\"100\" src=\"data:image/jpeg", "CE90 0.18 m, at worst 0.41 m",
        "href=\"./ortho/seamlines.gpkg\">its seamlines<"})
    EXPECT_TRUE(Contains(html, part)) << part;
  const auto json = ReportJsonOf(folder_.Path());
  const auto& ortho = json["orthophotos"];
  EXPECT_EQ(ortho["photos"][0]["ce90_m"]["median"], 0.19);
  EXPECT_TRUE(ortho["photos"][1]["ce90_m"].is_null());
  EXPECT_EQ(ortho["mosaic"]["file"], "ortho/mosaic.tif");
  EXPECT_EQ(ortho["seamlines"], "ortho/seamlines.gpkg");
  EXPECT_TRUE(ortho["tones"].is_null());
}

TEST_F(OrthoSection, AMosaicOfOtherOrthophotosIsNotShownAsCurrent) {
  WriteOrthophotos();
  EXPECT_FALSE(Contains(Html(), "The mosaic was made")) << "nothing is said of what does not tell";
  WriteMap(folder_ / "ortho/4711 a.ortho.tif", GDT_Byte, {{"ORIENT_MADE_FROM", "now"}});
  const auto write = [&](const std::string& made_from) {
    WriteMap(folder_ / "ortho/mosaic.tif", GDT_Byte, {{"ORIENT_MADE_FROM", made_from}});
  };
  write("now: 4711 a\nany: 4712");
  EXPECT_FALSE(Contains(Html(), "The mosaic was made"));
  write("before: 4711 a");
  const std::string html = Html();
  EXPECT_EQ(Malformed(html), "");
  EXPECT_TRUE(Contains(html, "The mosaic was made from orthophotos other than the present"));
  EXPECT_TRUE(Contains(html, "of 4711 a (1 in all)"));
  EXPECT_TRUE(Contains(html, "The mosaic was made without the orthophotos of 4712"));
  const auto mosaic = ReportJsonOf(folder_.Path())["orthophotos"]["mosaic"];
  EXPECT_EQ(mosaic["of_other_orthophotos"], nlohmann::json({"4711 a"}));
  EXPECT_EQ(mosaic["lacks"], nlohmann::json({"4712"}));
}

TEST_F(OrthoSection, DamagedOrthophotoIsNamedAndTheOthersAreShown) {
  WriteOrthophotos();
  WriteFileAtomically(folder_ / "ortho/4713.ortho.tif", "no picture");
  const std::string html = Html();
  EXPECT_EQ(Malformed(html), "");
  EXPECT_TRUE(Contains(html, "2 orthophotos"));
  EXPECT_TRUE(Contains(html, "4713.ortho.tif"));
}

TEST_F(OrthoSection, HowTheyWereMadeIsSaid) {
  WriteOrthophotos();
  WriteRunRecord(folder_ / "ortho", "ortho",
                 {"orient 1", "orient ortho --gsd-m 0.25", "2026-01-01T00:00:00Z", 1, {}});
  EXPECT_TRUE(Contains(Html(), "orient ortho --gsd-m 0.25"));
}

TEST_F(OrthoSection, OrthophotosOfOtherPosesAreNamedOneByOne) {
  const auto other_poses = [&] { return ReadBlockRecord(folder_.Path()).ortho->of_other_poses; };
  const OrientationTable table = ReadOrientationTable(folder_ / "orientation.csv");
  const OrientationRow& row = table.rows.at(0);
  const auto& at_m = row.pose.position_m;
  const auto write = [&](const std::string& photo, double off_m) {
    std::string pose = fmt::format("{:.4f} {:.4f} {:.4f}", at_m.x() + off_m, at_m.y(), at_m.z());
    for (const double angle : row.pose.opk_rad) pose += fmt::format(" {:.9f}", DegFromRad(angle));
    WriteMap(folder_ / ("ortho/" + photo + ".ortho.tif"), GDT_Byte, {{"ORIENT_POSE", pose}});
  };
  WriteOrthophotos();
  EXPECT_TRUE(other_poses().empty()) << "nothing is said of those that do not tell";
  write(row.photo, 0);
  EXPECT_TRUE(other_poses().empty());
  write("gone", 0);
  EXPECT_TRUE(other_poses().empty());
  EXPECT_EQ(ReadBlockRecord(folder_.Path()).ortho->without_pose, std::vector<std::string>{"gone"});
  EXPECT_TRUE(Contains(Html(), "have no pose in"));
  write(row.photo, 0.01);
  EXPECT_EQ(other_poses(), std::vector<std::string>{row.photo});
  EXPECT_TRUE(Contains(Html(), "were made with poses other than"));
}

}  // namespace
}  // namespace orient
