#include "block/pictures/contact_sheet.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "core/raster/raster.h"
#include "tests/support/shared_data.h"

namespace orient::block {
namespace {
namespace fs = std::filesystem;

InteriorResult Photo(const std::string& name, size_t marks) {
  InteriorResult result;
  result.photo = name;
  result.status = Status::kOk;
  result.sigma0_um = 5;
  for (size_t i = 0; i < marks; ++i) {
    result.marks.push_back({});
    result.marks.back().state = i == 1 ? MarkState::kMissing : MarkState::kUsed;
  }
  return result;
}

// A picture of marks whose tiles are evenly grey, brighter from mark to mark.
void WriteMarks(const std::string& path, int marks) {
  constexpr int kSide = 60, kStep = kSide + 4;
  const int width = marks * kStep - 4;
  std::vector<unsigned char> rgb;
  for (int row = 0; row < kSide; ++row)
    for (int col = 0; col < width; ++col)
      rgb.insert(rgb.end(), 3, static_cast<unsigned char>(60 + 20 * (col / kStep)));
  WritePng(path, width, kSide, 3, rgb);
}

TEST(ContactSheet, HundredsOfPhotosGoToPagesThatCanBeLookedAt) {
  TemporaryFolder folder;
  std::vector<InteriorResult> results;
  for (int i = 0; i < 250; ++i) results.push_back(Photo("photo_" + std::to_string(i), 8));
  const std::vector<std::string> pages = WriteContactSheet(folder.Path(), results);
  EXPECT_GT(pages.size(), 1U);
  EXPECT_EQ(pages.front(), folder / "contact_sheet.png");
  for (const std::string& page : pages) {
    const Raster sheet = Raster::Open(page);
    EXPECT_LE(sheet.Width(), 3800) << page;
    EXPECT_LE(sheet.Height(), 3800) << page;
  }
  results.resize(3);
  WriteContactSheet(folder.Path(), results);
  EXPECT_FALSE(fs::exists(pages.back())) << "pages of the earlier run are gone";
}

TEST(ContactSheet, ARowShowsTheMarksOfItsPhoto) {
  TemporaryFolder folder;
  WriteMarks(folder / "a.marks.png", 4);
  WriteContactSheet(folder.Path(), {Photo("a", 4)});
  const Image sheet = Raster::Open(folder / "contact_sheet.png").ReadGrey().image;
  for (int i = 0; i < 4; ++i) {
    // 96 px a tile behind 200 px for the name; a quarter into the tile no cross is drawn.
    const float grey = sheet.At(8 + 200 + 96 * i + 20, 8 + 20);
    EXPECT_NEAR(grey, 60 + 20 * i, 1.0) << i;
  }
}

TEST(ContactSheet, ADamagedOrAbsentPictureOfMarksLeavesItsRowGrey) {
  TemporaryFolder folder;
  EXPECT_EQ(WriteContactSheet(folder.Path(), {Photo("absent", 4), Photo("none", 0)}).size(), 1U);
  const Image sheet = Raster::Open(folder / "contact_sheet.png").ReadGrey().image;
  EXPECT_NEAR(sheet.At(8 + 200 + 48, 8 + 30), 205, 1);
}

TEST(ContactSheet, ACameraWithAHundredMarksHasSmallTiles) {
  TemporaryFolder folder;
  WriteContactSheet(folder.Path(), {Photo("reseau", 121)});
  EXPECT_LE(Raster::Open(folder / "contact_sheet.png").Width(), 3800);
}

}  // namespace
}  // namespace orient::block
