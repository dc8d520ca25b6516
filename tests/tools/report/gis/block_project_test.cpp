#include "tools/report/gis/block_project.h"

#include <cpl_vsi.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "core/base/atomic_write.h"
#include "core/base/error.h"
#include "tests/support/shared_data.h"
#include "tests/tools/report/example_block.h"
#include "tools/report/gis/block_geopackage.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

std::string ProjectIn(const std::string& qgz) {
  VSILFILE* file = VSIFOpenL(("/vsizip/{" + qgz + "}/block.qgs").c_str(), "rb");
  if (file == nullptr) return "";
  std::string text(1 << 20, '\0');
  text.resize(VSIFReadL(text.data(), 1, text.size(), file));
  VSIFCloseL(file);
  return text;
}

std::size_t Count(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (auto at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

std::string BlockIn(const TemporaryFolder& folder) {
  WriteBlockGeopackage(folder.Path(), Crs::Parse("EPSG:32635", "test"),
                       {ExampleExterior("4711", Status::kOk)});
  return folder.Path();
}

TEST(BlockProject, NamesTheLayersOfTheGeopackageRelatively) {
  const TemporaryFolder folder;
  const std::string path = WriteBlockProject(BlockIn(folder));
  const std::string text = ProjectIn(path);
  for (const std::string layer : {"photos", "residuals", "patches", "footprints"})
    EXPECT_EQ(Count(text, "<datasource>./block.gpkg|layername=" + layer + "</datasource>"), 1u);
  EXPECT_EQ(Count(text, "<maplayer "), 4u);
  EXPECT_EQ(Count(text, "<renderer-v2"), 4u) << "each as its style draws it";
  EXPECT_EQ(Count(text, "<labeling"), 1u);
  EXPECT_EQ(text.find(folder.Path()), std::string::npos) << "the folder may be moved";
}

TEST(BlockProject, ShowsTheMosaicOrElseTheOrthophotos) {
  const TemporaryFolder folder;
  const std::string block = BlockIn(folder);
  fs::create_directory(fs::path(block) / "ortho");
  for (const std::string file : {"b & c.ortho.tif", "4711.ortho.tif"})
    std::ofstream(fs::path(block) / "ortho" / file) << "an image";
  const std::string alone = ProjectIn(WriteBlockProject(block));
  EXPECT_EQ(Count(alone, "<maplayer type=\"raster\""), 2u);
  EXPECT_EQ(Count(alone, "./ortho/b &amp; c.ortho.tif</datasource>"), 1u);
  EXPECT_EQ(Count(alone, "providerKey=\"gdal\" checked=\"Qt::Checked\""), 2u);
  std::ofstream(fs::path(block) / "ortho/mosaic.tif") << "an image";
  const std::string with_mosaic = ProjectIn(WriteBlockProject(block));
  EXPECT_EQ(Count(with_mosaic, "providerKey=\"gdal\" checked=\"Qt::Checked\""), 1u);
  EXPECT_EQ(Count(with_mosaic, "<maplayer type=\"raster\""), 3u);
}

TEST(BlockProject, OneThatAUserHasSavedStays) {
  const TemporaryFolder folder;
  const std::string path = WriteBlockProject(BlockIn(folder));
  EXPECT_EQ(WriteBlockProject(folder.Path()), path) << "its own is made anew";
  const std::string saved = folder / "saved.zip";
  VSILFILE* file = VSIFOpenL(("/vsizip/" + saved + "/block.qgs").c_str(), "wb");
  ASSERT_NE(file, nullptr);
  const std::string text = "<qgis saveDateTime=\"2026-11-25T12:00:00\" version=\"3.22\"/>";
  VSIFWriteL(text.data(), 1, text.size(), file);
  VSIFCloseL(file);
  fs::rename(saved, path);
  const std::string before = ReadFile(path);
  EXPECT_EQ(WriteBlockProject(folder.Path()), "");
  EXPECT_EQ(ReadFile(path), before);
}

TEST(BlockProject, IsNotWrittenWithoutAGeopackage) {
  const TemporaryFolder folder;
  EXPECT_EQ(WriteBlockProject(folder.Path()), "");
  EXPECT_TRUE(fs::is_empty(folder.Path()));
}

TEST(BlockProject, ADamagedGeopackageIsNamed) {
  const TemporaryFolder folder;
  std::ofstream(fs::path(folder.Path()) / "block.gpkg") << "no GeoPackage";
  EXPECT_THROW(WriteBlockProject(folder.Path()), InputError);
  EXPECT_FALSE(fs::exists(fs::path(folder.Path()) / "block.qgz"));
}

}  // namespace
}  // namespace orient
