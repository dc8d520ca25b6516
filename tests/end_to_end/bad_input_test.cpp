// Bad input gets one clear line that names file, value and remedy, and its exit code; in a run of
// several photos the others go on.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <stdexcept>

#include "core/base/atomic_write.h"
#include "core/files/orientation_table.h"
#include "core/files/results.h"
#include "core/terrain/earth_effects.h"
#include "patchdb/store/patch_database.h"
#include "patchdb/store/schema.h"
#include "tests/end_to_end/spoilt_block.h"
#include "tests/support/older_patchdb.h"
#include "tests/support/ordinary_user.h"
#include "tests/support/run_orient.h"
#include "tests/support/shared_data.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

// What concerns one photo.

TEST_F(BadPhoto, TextNamedAsAScanFailsAlone) {
  Write("scans/new_1_2.tif", "this is no image\n");
  ExpectOnlyTheSecondFails(Block(), {Path("scans/new_1_2.tif"), "not an image", "convert it"});
}

TEST_F(BadPhoto, TruncatedScanFailsAlone) {
  fs::resize_file(Path("scans/new_1_2.tif"), 20000);
  ExpectOnlyTheSecondFails(Block(), {Path("scans/new_1_2.tif"), "truncated", "copy or scan it"});
}

TEST_F(BadPhoto, EmptyScanFailsAlone) {
  Write("scans/new_1_2.tif", "");
  ExpectOnlyTheSecondFails(Block(), {Path("scans/new_1_2.tif"), "not an image"});
}

TEST_F(BadPhoto, DigitalPhotoOfAnotherSizeFailsAlone) {
  fs::copy(Path("old/photos/old_1_1.tif"), Path("scans/new_1_2.tif"),
           fs::copy_options::overwrite_existing);
  ExpectOnlyTheSecondFails(
      Block(), {Path("scans/new_1_2.tif"), "the camera file says 890 x 667", "give the camera"});
}

TEST_F(BadPhoto, PhotoWithoutApproximationFailsAlone) {
  Edit("approx.csv", "\nnew_1_2,", "\nanother,");
  ExpectOnlyTheSecondFails(Both(), {Path("approx.csv"), "no row 'new_1_2'", "add one"});
}

TEST_F(BadPhoto, ScanThatIsNotThereFailsAloneAndTheRestIsExported) {
  fs::remove(Path("scans/new_1_2.tif"));
  Edit("block.toml", "\"scans/*.tif\"", "\"scans/new_1_1.tif\", \"scans/new_1_2.tif\"");
  Edit("block.toml", "[output]\n", "[output]\nformats = [\"patb\", \"colmap\"]\n");
  Write("block.toml", "earth = \"curved\"\n" + ReadFile(Path("block.toml")));
  ExpectOnlyTheSecondFails(Block(), {Path("scans/new_1_2.tif"), "does not exist", "check"});
  EXPECT_TRUE(fs::exists(Path("out/exports/patb/export.json")));
  EXPECT_TRUE(fs::exists(Path("out/exports/colmap/images.txt")));
  // Poses, camera and exports belong together: curvature is in the lens of both files.
  const Camera block = ReadCameraFile(Path("out/block_camera.toml")).camera;
  const Camera exported = ReadCameraFile(Path("out/exports/colmap/camera.toml")).camera;
  EXPECT_LT(block.earth_k1, 0);
  EXPECT_EQ(exported.earth_k1, block.earth_k1);
  ASSERT_TRUE(std::holds_alternative<BrownDistortion>(block.lens));
  EXPECT_NE(std::get<BrownDistortion>(block.lens).k[0], 0);
  EXPECT_EQ(std::get<BrownDistortion>(exported.lens).k[0],
            std::get<BrownDistortion>(block.lens).k[0]);
  fs::copy(Path("out/block_camera.toml"), Path("own.toml"));
  Edit("block.toml", "camera.toml", "own.toml");
  const ProgramRun again = Block({"--overwrite"});
  EXPECT_EQ(again.exit_code, 1);
  EXPECT_NE(again.err.find("curvature and refraction are in its lens already"), std::string::npos)
      << again.err;
}

// A camera of a block holds them, `flat` adds none, and however often a run resumes that is so.
TEST_F(BadPhoto, OverACurvedEarthIsSeenThroughOneLensHoweverOftenARunResumes) {
  CameraFile file = ReadCameraFile(Path("camera.toml"));
  file.camera = WithEarthEffects(file.camera, EarthMode::kCurved, 2500, 200);
  ASSERT_LT(file.camera.earth_k1, 0);
  WriteCameraFile(Path("camera.toml"), file);
  const std::string scan = Path("scans/new_1_1.tif");
  std::string result;
  for (const char* how : {"--overwrite", "--resume", "--resume"}) {
    const ProgramRun run = Exterior({scan, "--earth", "flat", "--no-feedback", how});
    ASSERT_EQ(run.exit_code, 0) << run.out << run.err;
    EXPECT_EQ(ReadExteriorResult(ExteriorResultPath(Path("out"), "new_1_1")).earth_k1, 0);
    const std::string now = ReadFile(ExteriorResultPath(Path("out"), "new_1_1"));
    EXPECT_TRUE(result.empty() || now == result) << how;
    result = now;
    fs::remove(ExteriorResultPath(Path("out"), "new_1_1"));
  }
  fs::remove_all(Path("out"));
  Write("block.toml", "earth = \"flat\"\n" + ReadFile(Path("block.toml")));
  for (const char* how : {"--overwrite", "--resume"}) {
    ASSERT_EQ(Block({how}).exit_code, 0);
    const Camera block = ReadCameraFile(Path("out/block_camera.toml")).camera;
    EXPECT_EQ(block.earth_k1, file.camera.earth_k1);
    EXPECT_EQ(std::get<BrownDistortion>(block.lens).k[0],
              std::get<BrownDistortion>(file.camera.lens).k[0]);
  }
}

TEST_F(BadPhoto, TwoScansOfOneNameFailAlone) {
  fs::create_directory(Path("again"));
  fs::copy(Path("scans/new_1_2.tif"), Path("again/new_1_2.tif"));
  Edit("block.toml", "\"scans/*.tif\"", "\"scans/*.tif\", \"again/*.tif\"");
  ExpectOnlyTheSecondFails(
      Block(), {Path("again/new_1_2.tif"), Path("scans/new_1_2.tif"), "same name", "rename"});
}

TEST_F(BadPhoto, PhotoOffTheDemFailsAlone) {
  OrientationTable table = ReadOrientationTable(Path("approx.csv"));
  table.rows.at(1).pose.position_m.x() += 30000;
  WriteOrientationTable(Path("approx.csv"), table);
  ExpectOnlyTheSecondFails(Both(), {Path("dem.tif"), "does not cover", "x 54", "give a DEM"});
  // In a block its neighbour finds it, and it is not ok.
  const ProgramRun run = Block({"--overwrite"});
  EXPECT_EQ(run.exit_code, 0) << run.out << run.err;
  const ExteriorResult found = ReadExteriorResult(ExteriorResultPath(Path("out"), "new_1_2"));
  EXPECT_EQ(found.status, Status::kWeak);
  ASSERT_TRUE(found.pose);
  const OrientationTable truth = ReadOrientationTable(Path("truth/orientation.csv"));
  EXPECT_LT((found.pose->position_m - truth.Find("new_1_2")->pose.position_m).norm(), 2);
}

TEST_F(BadInput, PhotoBelowTheGroundFails) {
  OrientationTable table = ReadOrientationTable(Path("approx.csv"));
  for (OrientationRow& row : table.rows) row.pose.position_m.z() = -1000;
  WriteOrientationTable(Path("approx.csv"), table);
  const ProgramRun run = Exterior({Path("scans/new_1_1.tif")});
  EXPECT_EQ(run.exit_code, 3) << run.err;
  EXPECT_NE(run.out.find("below the ground: z -1000"), std::string::npos) << run.out;
}

TEST_F(BadPhoto, PhotoMuchTooHighFailsAlone) {
  OrientationTable table = ReadOrientationTable(Path("approx.csv"));
  for (OrientationRow& row : table.rows)
    if (row.photo == "new_1_2") row.pose.position_m.z() = 1e9;
  WriteOrientationTable(Path("approx.csv"), table);
  ExpectOnlyTheSecondFails(Both(), {"its height is wrong"});
}

TEST_F(BadInput, PhotoOverNoPatchFails) {
  const ProgramRun run = Block();
  EXPECT_EQ(run.exit_code, 3) << run.err;
  const ExteriorResult result = ReadExteriorResult(ExteriorResultPath(Path("out"), "new_1_1"));
  EXPECT_EQ(result.status, Status::kFailed);
  ASSERT_EQ(result.findings.size(), 1u);
  EXPECT_NE(Sentence(result.findings.at(0)).find(Path("patches.gpkg")), std::string::npos);
  EXPECT_NE(Sentence(result.findings.at(0)).find("harvest"), std::string::npos);
  EXPECT_TRUE(fs::exists(Path("out/report.html")));
}

// What concerns all photos: exit code 2, nothing is written.

TEST_F(BadInput, MissingScanIsNamed) {
  ExpectRefused(Exterior({Path("scans/new_9_9.tif")}), 2,
                {"no photo matches", Path("scans/new_9_9.tif"), "check"});
}

TEST_F(BadInput, GlobThatMatchesNothingIsNamed) {
  Edit("block.toml", "scans/*.tif", "skans/*.tif");
  ExpectRefused(Block(), 2, {Path("block.toml"), "line", "skans/*.tif", "check"});
}

TEST_F(BadInput, AnExportFormatThatIsNoneIsRefusedBeforeTheWork) {
  Edit("block.toml", "[output]\n", "[output]\nformats = [\"patb\", \"pat-m\"]\n");
  ExpectRefused(Block(), 2, {Path("block.toml"), "pat-m", "colmap"});
  EXPECT_FALSE(fs::exists(Path("out")));
}

TEST_F(BadInput, WrongKeyInTheCameraFileIsNamedWithItsLine) {
  Edit("camera.toml", "principal_distance_mm", "pricipal_distance_mm");
  ExpectRefused(
      Block(), 2,
      {Path("camera.toml"), "line", "pricipal_distance_mm", "did you mean principal_distance_mm?"});
}

TEST_F(BadInput, BrokenLineInTheOrientationTableIsNamed) {
  const std::string text = ReadFile(Path("approx.csv"));
  const std::size_t last = text.rfind(',');
  Write("approx.csv", text.substr(0, last) + ",north\n");
  ExpectRefused(Block(), 2, {Path("approx.csv"), "line 3", "kappa", "\"north\"", "number"});
}

TEST_F(BadInput, TableOfOtherPhotosIsNamed) {
  Edit("approx.csv", "\nnew_1_1,", "\nanother,");
  Edit("approx.csv", "\nnew_1_2,", "\nyet_another,");
  ExpectRefused(Block(), 2, {Path("approx.csv"), "none of the given photos", "filename"});
}

TEST_F(BadInput, DemOfAnotherPlaceIsNamed) {
  OrientationTable table = ReadOrientationTable(Path("approx.csv"));
  for (OrientationRow& row : table.rows) row.pose.position_m.x() += 30000;
  WriteOrientationTable(Path("approx.csv"), table);
  ExpectRefused(Block(), 2, {Path("dem.tif"), "covers x 51", "give a DEM"});
}

TEST_F(BadInput, GeographicCrsIsRefused) {
  Edit("block.toml", "EPSG:32635", "EPSG:4326");
  ExpectRefused(Block(), 2, {Path("block.toml"), "EPSG:4326", "degrees", "EPSG:32635"});
  ExpectRefused(RunOrient({"patchdb", "create", Path("new.gpkg"), "--crs", "EPSG:4326"}), 2,
                {"--crs", "EPSG:4326", "degrees", "EPSG:32635"});
  EXPECT_FALSE(fs::exists(Path("new.gpkg")));
}

TEST_F(BadInput, CrsInFeetIsRefused) {
  Edit("block.toml", "EPSG:32635", "EPSG:2264");
  ExpectRefused(Block(), 2, {Path("block.toml"), "EPSG:2264", "foot", "metres"});
}

TEST_F(BadInput, GeographicOrientationTableIsRefused) {
  Write("approx.prj", "EPSG:4326\n");
  ExpectRefused(Block(), 2, {Path("approx.prj"), "EPSG:4326", "degrees"});
}

TEST_F(BadInput, PatchesInAnotherCrsAreRefused) {
  Edit("block.toml", "EPSG:32635", "EPSG:32634");
  ExpectRefused(Block(), 2, {Path("patches.gpkg"), "zone 35N", "zone 34N", "use a patch database"});
}

TEST_F(BadInput, MissingPatchDatabaseIsNamed) {
  fs::remove(Path("patches.gpkg"));
  ExpectRefused(Block(), 2, {Path("block.toml"), Path("patches.gpkg"), "does not exist"});
  ExpectRefused(Exterior({Path("scans/new_1_1.tif")}), 2,
                {Path("patches.gpkg"), "does not exist", "orient patchdb create"});
}

TEST_F(BadInput, FileThatIsNoPatchDatabaseIsNamed) {
  Write("patches.gpkg", ReadFile(Path("truth.json")));
  ExpectRefused(Block(), 2,
                {Path("patches.gpkg"), "is not a patch database", "orient patchdb create"});
}

TEST_F(BadInput, OutputFolderThatCannotBeMadeIsNamed) {
  Edit("block.toml", "directory = \"out\"", "directory = \"camera.toml/out\"");
  ExpectRefused(Block(), 2, {"cannot create the folder", Path("camera.toml/out")});
}

TEST_F(BadInput, ReadOnlyOutputFolderIsNamed) {
  fs::create_directory(Path("out"));
  const OrdinaryUser user(Path(".."));
  fs::permissions(Path("out"), fs::perms::owner_read | fs::perms::owner_exec);
  ExpectRefused(Block(), 2, {Path("out")});
  fs::permissions(Path("out"), fs::perms::owner_all);
}

TEST_F(BadInput, PatchDatabaseOfAnOlderProgramIsBroughtUpToDateWhereTheRunTellsIt) {
  const std::string words =
      "upgraded from schema version 3 to " + std::to_string(patchdb::CurrentSchemaVersion());
  const std::string patches = Path("patches.gpkg"), scan = Path("scans/new_1_1.tif");
  MakeVersion3(patches);
  for (const ProgramRun& run : {Block(), Exterior({scan, "--overwrite"})}) {
    EXPECT_EQ(run.exit_code, 3) << run.err;  // no patches
    EXPECT_EQ(run.out.find(words), std::string::npos) << run.out;
  }
  EXPECT_NE(RunOrient({"patchdb", "info", patches}).out.find("version 3"), std::string::npos);
  EXPECT_NE(Exterior({scan, "--overwrite", "--learn"}).out.find(words), std::string::npos);
  MakeVersion3(patches);
  const ProgramRun block = RunOrient({"block", Path("block.toml"), "--overwrite", "--learn"});
  EXPECT_NE(block.out.find(words), std::string::npos) << block.out << block.err;
}

TEST_F(BadInput, PatchDatabaseThatMayNotLearnIsNamed) {
  const OrdinaryUser user(Path(".."));
  fs::permissions(Path("patches.gpkg"), fs::perms::owner_read);
  ExpectRefused(Exterior({Path("scans/new_1_1.tif"), "--learn"}), 2,
                {Path("patches.gpkg"), "cannot be written", "leave out --learn"});
  EXPECT_EQ(Exterior({Path("scans/new_1_1.tif")}).exit_code, 3);
}

TEST_F(BadPhoto, TeachesThePatchDatabaseOnlyWhereAskedTo) {
  const std::string scan = Path("scans/new_1_1.tif"), patches = Path("patches.gpkg");
  const std::string before = ReadFile(patches);
  ASSERT_EQ(Exterior({scan}).exit_code, 0);
  const std::string result = ReadFile(Path("out/new_1_1.exterior.json"));
  EXPECT_EQ(ReadFile(patches), before);
  ASSERT_EQ(Exterior({scan, "--overwrite", "--learn"}).exit_code, 0);
  EXPECT_EQ(ReadFile(Path("out/new_1_1.exterior.json")), result);
  const patchdb::PatchDatabase taught =
      patchdb::PatchDatabase::Open(patches, patchdb::PatchDatabase::Mode::kRead);
  EXPECT_GT(taught.Info().attempts, 0);
  EXPECT_EQ(Exterior({scan, "--overwrite", "--learn", "--no-feedback"}).exit_code, 1);
}

// The command line: exit code 1.

TEST_F(BadInput, ExistingResultsAreNotReplacedUnasked) {
  fs::create_directory(Path("out"));
  Write("out/new_1_2.exterior.json", "precious");
  ExpectRefused(Block(), 1,
                {Path("out/new_1_2.exterior.json"), "exists already", "--overwrite", "--resume"});
  EXPECT_EQ(ReadFile(Path("out/new_1_2.exterior.json")), "precious");
}

TEST_F(BadInput, DamagedResultIsMadeAgainOnResume) {
  fs::create_directory(Path("out"));
  for (const char* damaged : {"{\"photo\": ", "{\"made_from\": \"0123456789abcdef\"}"}) {
    Write("out/new_1_2.exterior.json", damaged);
    EXPECT_EQ(Exterior({Path("scans/new_1_2.tif"), "--resume", "--plan"}).out,
              "do    exterior  new_1_2\n");
    EXPECT_EQ(Exterior({Path("scans/new_1_2.tif"), "--resume"}).exit_code, 3);  // no patches
    EXPECT_FALSE(ReadExteriorResult(ExteriorResultPath(Path("out"), "new_1_2")).made_from.empty());
  }
}

TEST_F(BadPhoto, OfAnotherApproximationIsDoneAgainOnResume) {
  const std::string one = Path("scans/new_1_1.tif"), two = Path("scans/new_1_2.tif");
  ASSERT_EQ(Exterior({one, two}).exit_code, 0);
  const auto written = [&](const char* photo) {
    return fs::last_write_time(ExteriorResultPath(Path("out"), photo));
  };
  const auto first = written("new_1_1"), second = written("new_1_2");
  OrientationTable table = ReadOrientationTable(Path("approx.csv"));
  for (OrientationRow& row : table.rows)
    if (row.photo == "new_1_2") row.pose.position_m.x() += 1;
  WriteOrientationTable(Path("approx.csv"), table);
  EXPECT_EQ(Exterior({one, two, "--resume", "--plan"}).out,
            "keep  exterior  new_1_1\ndo    exterior  new_1_2\n");
  EXPECT_EQ(written("new_1_2"), second);
  ASSERT_EQ(Exterior({one, two, "--resume"}).exit_code, 0);
  EXPECT_EQ(written("new_1_1"), first);
  EXPECT_GT(written("new_1_2"), second);
}

TEST_F(BadInput, ResultsOfAnotherCameraOrEarthAreNotKeptOnResume) {
  const std::string scan = Path("scans/new_1_1.tif");
  EXPECT_EQ(Exterior({scan}).exit_code, 3);  // no patches
  EXPECT_EQ(Exterior({scan, "--resume"}).exit_code, 3);
  ExpectRefused(Exterior({scan, "--resume", "--earth", "curved"}), 2,
                {Path("out"), "options", "earth auto", "earth curved", "--overwrite"});
  Edit("camera.toml", "principal_distance_mm = ", "principal_distance_mm = 1");
  ExpectRefused(Exterior({scan, "--resume"}), 2, {Path("out"), "other inputs (camera file"});
  // Nor by a run of other photos into the same folder: one camera file there is true of all.
  ExpectRefused(Exterior({Path("scans/new_1_2.tif"), "--resume"}), 2,
                {"other inputs (camera file"});
}

// More photos would be seen over another earth: that of the first run stays.
TEST_F(BadInput, AResumedRunKeepsTheEarthOfTheFirst) {
  ASSERT_EQ(Exterior({Path("scans/new_1_1.tif"), "--earth", "curved"}).exit_code, 3);
  const std::string path = ExteriorResultPath(Path("out"), "new_1_1");
  ExteriorResult first = ReadExteriorResult(path);
  ASSERT_LT(first.earth_k1.value(), 0);
  first.earth_k1 = 2 * *first.earth_k1;
  WriteExteriorResult(Path("out"), first);
  ASSERT_EQ(Exterior({Path("scans/new_1_2.tif"), "--earth", "curved", "--resume"}).exit_code, 3);
  EXPECT_EQ(ReadExteriorResult(ExteriorResultPath(Path("out"), "new_1_2")).earth_k1,
            first.earth_k1);
}

TEST_F(BadInput, FilmCameraWithoutInteriorIsRefused) {
  SimulationOptions film;
  film.photos = 1;
  film.pixel_size_um = 200;
  film.gsd_m = 2;
  film.objects = false;
  Simulate(film, folder_ / "film");
  fs::copy(folder_ / "film/camera.toml", Path("camera.toml"), fs::copy_options::overwrite_existing);
  ExpectRefused(Exterior({Path("scans/new_1_1.tif")}), 1,
                {Path("camera.toml"), "film camera", "orient interior", "--interior"});
}

TEST_F(BadInput, WrongOptionsAreUsageErrors) {
  const std::vector<std::vector<std::string>> wrong = {{"--jobs", "-1"},
                                                       {"--jobs", "many"},
                                                       {"--frobnicate"},
                                                       {"--position-sigma-m", "-3"},
                                                       {"--attitude-sigma-deg", "400"}};
  for (const std::vector<std::string>& options : wrong) {
    std::vector<std::string> arguments = options;
    arguments.push_back(Path("scans/new_1_1.tif"));
    const ProgramRun run = Exterior(arguments);
    EXPECT_EQ(run.exit_code, 1) << run.err;
    EXPECT_NE(run.err.find(options[0].substr(2)), std::string::npos) << run.err;
    EXPECT_FALSE(fs::exists(Path("out")));
  }
  EXPECT_EQ(RunOrient({"blokc"}).exit_code, 1);
  EXPECT_EQ(RunOrient({}).exit_code, 1);
}

// A definition longer than a file's name may be is no file.
TEST_F(BadInput, CrsMayBeGivenAsWkt) {
  const std::string wkt = ReadFile(Path("approx.prj"));
  ASSERT_GT(wkt.size(), 300u);
  const ProgramRun run = RunOrient({"patchdb", "create", Path("new.gpkg"), "--crs", wkt});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  ExpectRefused(RunOrient({"patchdb", "create", Path("other.gpkg"), "--crs",
                           "PROJCS[" + std::string(5000, 'x')}),
                2, {"--crs", "not understood", "EPSG:32635"});
}

}  // namespace
}  // namespace orient
