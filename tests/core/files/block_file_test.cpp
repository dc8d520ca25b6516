#include "core/files/block_file.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "core/base/atomic_write.h"
#include "core/base/error.h"
#include "core/geometry/rotation.h"
#include "tests/support/expect_error.h"
#include "tests/support/shared_data.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

const std::string kBlock = R"(crs = "EPSG:32635"
dem = "dem.tif"
patchdb = "patches.gpkg"
camera = "camera.toml"
photos = ["scans/*.tif"]
approximations = "approx.csv"
)";

class BlockFileTest : public testing::Test {
 protected:
  BlockFileTest() {
    fs::create_directory(folder_ / "scans");
    for (const std::string name : {"dem.tif", "patches.gpkg", "camera.toml", "approx.csv",
                                   "scans/b.tif", "scans/a.tif", "scans/note.txt"})
      WriteFileAtomically(folder_ / name, "");
  }

  BlockFile ReadText(const std::string& text) const {
    WriteFileAtomically(folder_ / "block.toml", text);
    return ReadBlockFile(folder_ / "block.toml");
  }

  void ExpectRefused(const std::string& text, std::initializer_list<std::string> parts) const {
    ExpectError<InputError>([&] { ReadText(text); }, parts);
  }

  const TemporaryFolder folder_;
};

std::string Replaced(std::string text, const std::string& from, const std::string& to) {
  return text.replace(text.find(from), from.size(), to);
}

TEST_F(BlockFileTest, SubBlocksAreOfHundredsOfPhotosAndHaveNoCameraOfTheirOwn) {
  const auto of = [&](const std::string& keys) { return kBlock + "[block]\n" + keys + "\n"; };
  EXPECT_EQ(ReadText(kBlock).adjustment.sub_block_photos, 10000);
  EXPECT_EQ(ReadText(of("sub_block_photos = 301")).adjustment.sub_block_photos, 301);
  ExpectRefused(of("sub_block_photos = 299"), {"sub_block_photos", "at least 300"});
  const std::string text = of("self_calibration = \"camera\"\nsub_block_photos = 300");
  EXPECT_TRUE(ReadText(text).adjustment.self_calibration);
  for (int i = 0; i < 299; ++i)
    WriteFileAtomically(folder_ / "scans/more" + std::to_string(i) + ".tif", "");
  ExpectRefused(text, {"self_calibration", "301 photos", "sub_block_photos = 300"});
}

TEST_F(BlockFileTest, ControlImagesTakeTheDatabasesPlace) {
  for (const char* file : {"base_1.tif", "base_2.tif", "old.csv"})
    WriteFileAtomically(folder_ / file, "");
  const std::string without = Replaced(kBlock, "patchdb = \"patches.gpkg\"\n", "");
  const BlockFile block =
      ReadText(without + "control = { orthophotos = [\"base_*.tif\"], date = \"1999\" }\n");
  ASSERT_TRUE(block.control);
  EXPECT_EQ(block.control->orthophotos.size(), 2u);
  EXPECT_EQ(block.control->date, "1999");
  EXPECT_EQ(block.patchdb, folder_ / "out/control.gpkg");
  EXPECT_FALSE(block.ByMeasurementsAlone());
  const BlockFile old = ReadText(without +
                                 "[control]\nphotos = [\"base_1.tif\"]\ncamera = "
                                 "\"wild_rc8\"\norientation = \"old.csv\"\n");
  EXPECT_EQ(old.control->photos.size(), 1u);
  EXPECT_EQ(old.control->camera, "wild_rc8");
}

TEST_F(BlockFileTest, ControlImagesThatDoNotGoTogetherAreRefused) {
  const std::string without = Replaced(kBlock, "patchdb = \"patches.gpkg\"\n", "");
  WriteFileAtomically(folder_ / "base.tif", "");
  ExpectRefused(kBlock + "control = { orthophotos = [\"base.tif\"] }\n",
                {"patchdb", "leave one of them out"});
  ExpectRefused(without + "[control]\ndate = \"1999\"\n", {"orthophotos", "photos must be given"});
  ExpectRefused(without + "[control]\northophotos = [\"none*.tif\"]\n", {"orthophotos", "none*"});
  ExpectRefused(without + "[control]\nphotos = [\"base.tif\"]\n", {"camera"});
  ExpectRefused(without + "[control]\northophotos = [\"base.tif\"]\ndate = \"May\"\n", {"date"});
  ExpectRefused(without + "[control]\northophotos = [\"base.tif\"]\nchip_px = 60\n",
                {"chip_px", "odd"});
  ExpectRefused(without, {"patchdb"});
}

TEST_F(BlockFileTest, OrthophotosAreMadeWhereTheyAreAskedFor) {
  EXPECT_FALSE(ReadText(kBlock).ortho);
  const BlockFile block = ReadText(kBlock + "[ortho]\n");
  ASSERT_TRUE(block.ortho);
  EXPECT_TRUE(block.ortho->mosaic);
  EXPECT_FALSE(block.ortho->gsd_m);
  const BlockFile more =
      ReadText(kBlock + "[ortho]\ngsd_m = 0.25\ndem_sigma_m = 2.0\nmosaic = false\nweak = true\n");
  EXPECT_EQ(more.ortho->gsd_m, 0.25);
  EXPECT_EQ(more.ortho->dem_sigma_m, 2);
  const BlockFile even = ReadText(kBlock + "[ortho]\nleast_difference = true\nbalance = true\n");
  EXPECT_TRUE(even.ortho->least_difference && even.ortho->balance);
  ExpectRefused(kBlock + "[ortho]\nmosaic = false\nbalance = true\n",
                {"balance", "mosaic = false"});
  EXPECT_FALSE(more.ortho->mosaic);
  EXPECT_TRUE(more.ortho->weak);
  ExpectRefused(kBlock + "[ortho]\ngsd_m = 0\n", {"gsd_m"});
  ExpectRefused(kBlock + "[ortho]\ngsd = 1\n", {"gsd", "did you mean gsd_m"});
}

TEST_F(BlockFileTest, TheCrsMayBeAFileThatHoldsIt) {
  WriteFileAtomically(folder_ / "block.prj", "EPSG:25832\n");
  EXPECT_EQ(ReadText(Replaced(kBlock, "EPSG:32635", "block.prj")).crs.Epsg(), 25832);
}

TEST_F(BlockFileTest, PathsAreRelativeToTheBlockFile) {
  const BlockFile block = ReadText(kBlock);
  EXPECT_EQ(block.crs.Epsg(), 32635);
  EXPECT_EQ(block.dem, folder_ / "dem.tif");
  EXPECT_EQ(block.patchdb, folder_ / "patches.gpkg");
  EXPECT_EQ(block.camera, folder_ / "camera.toml");
  EXPECT_EQ(block.approximations, folder_ / "approx.csv");
  EXPECT_EQ(block.photos,
            (std::vector<std::string>{folder_ / "scans/a.tif", folder_ / "scans/b.tif"}));
  EXPECT_EQ(block.output_directory, folder_ / "out");
}

TEST_F(BlockFileTest, WhatNobodyStatesIsEmpty) {
  const BlockFile block = ReadText(kBlock);
  EXPECT_FALSE(block.position_sigma_m || block.attitude_sigma_rad);
  EXPECT_FALSE(block.pixel_size_um || block.polarity || block.orientation);
}

TEST_F(BlockFileTest, WhatIsGivenHolds) {
  const BlockFile block = ReadText(kBlock +
                                   "[approximate_accuracy]\nposition_m = 150\nattitude_deg = 2.0\n"
                                   "[scan]\npixel_size_um = 25.0\npolarity = \"negative\"\n"
                                   "orientation = \"m90\"\n[output]\ndirectory = \"results\"\n");
  EXPECT_EQ(block.position_sigma_m, 150);
  EXPECT_DOUBLE_EQ(block.attitude_sigma_rad.value(), RadFromDeg(2));
  EXPECT_EQ(block.pixel_size_um, 25.0);
  EXPECT_EQ(block.polarity, Polarity::kNegative);
  EXPECT_EQ(block.orientation, ScanOrientation::kM90);
  EXPECT_EQ(block.output_directory, folder_ / "results");
  const BlockFile exporting = ReadText(kBlock + "[output]\nformats = [\"patb\", \"colmap\"]\n");
  EXPECT_EQ(exporting.output_directory, folder_ / "out");
  EXPECT_EQ(exporting.formats, (std::vector<std::string>{"patb", "colmap"}));
}

TEST_F(BlockFileTest, AutoIsTheSameAsAbsent) {
  const BlockFile block =
      ReadText(kBlock + "[scan]\npolarity = \"auto\"\norientation = \"auto\"\n");
  EXPECT_FALSE(block.polarity || block.orientation);
}

TEST_F(BlockFileTest, WrongKeysAndValuesAreNamed) {
  ExpectRefused(Replaced(kBlock, "patchdb", "patch_db"), {"line 3: patch_db", "patchdb?"});
  ExpectRefused(kBlock + "[scan]\npolarity = \"dark\"\n", {"line 8: scan.polarity", "dark"});
  ExpectRefused(kBlock + "[scan]\norientation = \"r45\"\n", {"scan.orientation", "r45", "m270"});
  ExpectRefused(kBlock + "[scan]\npixel_size_um = 0.025\n", {"pixel_size_um", "micrometres"});
  ExpectRefused(kBlock + "[approximate_accuracy]\nposition_m = 0\n", {"position_m", "between"});
  ExpectRefused(kBlock + "[approximate_accuracy]\nattitude_deg = 1e9\n", {"attitude_deg", "1e+09"});
  ExpectRefused(Replaced(kBlock, "camera = \"camera.toml\"\n", ""), {"lacks the key camera"});
}

TEST_F(BlockFileTest, GnssMayDriftAlongStripsOnly) {
  WriteFileAtomically(folder_ / "gnss.csv", "");
  const std::string gnss = kBlock + "[gnss]\npositions = \"gnss.csv\"\n";
  EXPECT_TRUE(ReadText(kBlock).gnss.positions.empty());
  EXPECT_EQ(ReadText(gnss).gnss.positions, folder_ / "gnss.csv");
  EXPECT_EQ(ReadText(gnss).gnss.model, GnssModel::kShift);
  EXPECT_EQ(ReadText(gnss + "sigma_m = 0.2\n").gnss.sigma_m, 0.2);
  ExpectRefused(gnss + "sigma_m = 1e300\n", {"gnss.sigma_m", "1e+300"});
  EXPECT_EQ(ReadText(gnss + "model = \"plain\"\n").gnss.model, GnssModel::kPlain);
  const std::string drifting = gnss + "model = \"shift_and_drift\"\n";
  ExpectRefused(drifting, {"gnss.model", "[[strips]]"});
  EXPECT_EQ(ReadText(drifting + "[[strips]]\nphotos = [\"*\"]\n").gnss.model,
            GnssModel::kShiftAndDrift);
  ExpectRefused(gnss + "model = \"bent\"\n", {"gnss.model", "bent", "shift_and_drift"});
  ExpectRefused(gnss + "sigma_m = 0\n", {"gnss.sigma_m"});
  ExpectRefused(kBlock + "[gnss]\nsigma_m = 1\n", {"positions"});
}

TEST_F(BlockFileTest, AnEmptyOutputFolderIsRefused) {
  ExpectRefused(kBlock + "[output]\ndirectory = \"\"\n", {"output.directory", "is empty"});
}

TEST_F(BlockFileTest, ACameraThatIsNoFileIsANameOfTheLibrary) {
  EXPECT_EQ(ReadText(Replaced(kBlock, "camera.toml", "wild_rc10")).camera, "wild_rc10");
  ExpectRefused(Replaced(kBlock, "camera.toml", "other.toml"), {"camera", "other.toml"});
  ExpectRefused(Replaced(kBlock, "camera.toml", "cameras/wild_rc10"), {"camera", "wild_rc10"});
}

TEST_F(BlockFileTest, FilesThatDoNotExistAreNamedWithTheirKey) {
  ExpectRefused(Replaced(kBlock, "dem.tif", "hills.tif"), {"line 2: dem", "hills.tif"});
  ExpectRefused(Replaced(kBlock, "approx.csv", "no.csv"), {"approximations", "no.csv"});
  EXPECT_EQ(ReadText(Replaced(kBlock, "dem.tif", "/vsicurl/https://x/dem.tif")).dem,
            "/vsicurl/https://x/dem.tif");
}

TEST_F(BlockFileTest, ACrsThatIsNotProjectedOrUnknownIsRefusedNamingTheFile) {
  ExpectRefused(Replaced(kBlock, "EPSG:32635", "EPSG:4326"), {folder_ / "block.toml"});
  ExpectRefused(Replaced(kBlock, "EPSG:32635", "EPSG:nonsense"), {folder_ / "block.toml"});
}

TEST_F(BlockFileTest, APatternWithoutAMatchIsNamed) {
  ExpectRefused(Replaced(kBlock, "*.tif", "*.jpg"), {"photos", "scans/*.jpg"});
  ExpectRefused(Replaced(kBlock, "[\"scans/*.tif\"]", "[]"), {"photos"});
}

TEST_F(BlockFileTest, TwoPhotosWithOneNameAreNeitherOfThemUsed) {
  WriteFileAtomically(folder_ / "scans/a.jpg", "");
  const BlockFile block = ReadText(Replaced(kBlock, "*.tif", "?.*"));
  EXPECT_EQ(block.photos, std::vector<std::string>{folder_ / "scans/b.tif"});
  ASSERT_EQ(block.unusable.size(), 1u);
  EXPECT_EQ(block.unusable[0].name, "a");
  EXPECT_NE(block.unusable[0].reason.find("scans/a.jpg"), std::string::npos);
  ExpectRefused(Replaced(kBlock, "*.tif", "a.*"), {"scans/a.jpg", "scans/a.tif"});
  ExpectError<InputError>([&] { ExpandPhotos({"scans/a.*"}, folder_.Path()); },
                          {"scans/a.jpg", "scans/a.tif", "\"a\""});
}

TEST_F(BlockFileTest, APhotoThatIsNotThereIsPutDownAndTheOthersGoOn) {
  const BlockFile block =
      ReadText(Replaced(kBlock, "\"scans/*.tif\"", "\"scans/a.tif\", \"scans/z.tif\""));
  EXPECT_EQ(block.photos, std::vector<std::string>{folder_ / "scans/a.tif"});
  ASSERT_EQ(block.unusable.size(), 1u);
  EXPECT_EQ(block.unusable[0].name, "z");
  ExpectRefused(Replaced(kBlock, "*.tif", "z.tif"), {"scans/z.tif", "does not exist"});
}

TEST_F(BlockFileTest, AMissingPhotoOfAnExistingOnesNameSpoilsTheNameOnce) {
  const BlockFile block = ReadText(
      Replaced(kBlock, "\"scans/*.tif\"", "\"scans/*.tif\", \"lost/b.tif\", \"z.tif\", \"z.tif\""));
  EXPECT_EQ(block.photos, std::vector<std::string>{folder_ / "scans/a.tif"});
  ASSERT_EQ(block.unusable.size(), 2u);
  EXPECT_EQ(block.unusable[0].name, "b");
  EXPECT_NE(block.unusable[0].reason.find("lost/b.tif"), std::string::npos);
  EXPECT_EQ(block.unusable[1].name, "z");
}

TEST_F(BlockFileTest, ExpandedPhotosAreSortedWithoutDuplicates) {
  EXPECT_EQ(ExpandPhotos({"scans/b.tif", "scans/*.tif"}, folder_.Path()),
            (std::vector<std::string>{folder_ / "scans/a.tif", folder_ / "scans/b.tif"}));
  EXPECT_EQ(ExpandPhotos({folder_ / "scans/?.tif"}, "").size(), 2u);
  EXPECT_EQ(ExpandPhotos({"/vsis3/bucket/a.tif"}, folder_.Path()),
            std::vector<std::string>{"/vsis3/bucket/a.tif"});
}

TEST_F(BlockFileTest, ALinkToItselfIsAPhotoAmongTheOthers) {
  std::filesystem::create_symlink("loop.tif", folder_ / "scans/loop.tif");
  EXPECT_EQ(ExpandPhotos({"scans/*.tif"}, folder_.Path()).size(), 3u);
}

TEST_F(BlockFileTest, AFileMayListThePhotos) {
  WriteFileAtomically(folder_ / "list.txt", "# of 1961\r\nscans/b.tif\r\n\nscans/a.* \n");
  EXPECT_EQ(ExpandPhotos({"@list.txt"}, folder_.Path()),
            (std::vector<std::string>{folder_ / "scans/a.tif", folder_ / "scans/b.tif"}));
  ExpectError<InputError>([&] { ExpandPhotos({"@none.txt"}, folder_.Path()); }, {"none.txt"});
  WriteFileAtomically(folder_ / "scans/@odd.tif", "");
  EXPECT_EQ(ExpandPhotos({"@odd.tif"}, folder_ / "scans"),
            std::vector<std::string>{folder_ / "scans/@odd.tif"});
}

TEST_F(BlockFileTest, ListsOfPhotosInABlockFileAreRelativeToIt) {
  const std::string listed = Replaced(kBlock, "scans/*.tif", "@lists/film 3.txt");
  fs::create_directory(folder_ / "lists");
  WriteFileAtomically(folder_ / "lists/film 3.txt", "scans/b.tif\n# later\nscans/lost.tif\n");
  const BlockFile block = ReadText(listed);
  EXPECT_EQ(block.photos, std::vector<std::string>{folder_ / "scans/b.tif"});
  ASSERT_EQ(block.unusable.size(), 1u) << "as where the block file names it";
  EXPECT_EQ(block.unusable[0].name, "lost");
  WriteFileAtomically(folder_ / "lists/film 3.txt", "# none yet\n");
  ExpectRefused(listed, {"photos", "the list is empty"});
  fs::remove(folder_ / "lists/film 3.txt");
  ExpectRefused(listed, {"photos", "lists/film 3.txt"});
}

TEST_F(BlockFileTest, AFolderIsNoPhoto) {
  ExpectError<InputError>([&] { ExpandPhotos({"scans"}, folder_.Path()); }, {"scans", "folder"});
}

TEST_F(BlockFileTest, NamesWithPatternCharactersAreTakenAsTheyAre) {
  fs::create_directory(folder_ / "old [1961]");
  WriteFileAtomically(folder_ / "old [1961]/a[1].tif", "");
  EXPECT_EQ(ExpandPhotos({"a[1].tif"}, folder_ / "old [1961]").size(), 1u);
  EXPECT_EQ(ExpandPhotos({"*.tif"}, folder_ / "old [1961]").size(), 1u);
}

}  // namespace
}  // namespace orient
