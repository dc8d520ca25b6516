// orient convert: exports that their programs read as Orient meant, and those that they do not.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <functional>
#include <set>
#include <sstream>

#include "core/base/atomic_write.h"
#include "core/base/error.h"
#include "core/exchange/asp_pinhole.h"
#include "core/files/camera_file.h"
#include "core/files/orientation_table.h"
#include "core/files/results.h"
#include "core/terrain/earth_effects.h"
#include "tests/support/example_adjustment.h"
#include "tests/support/expect_error.h"
#include "tests/support/run_orient.h"
#include "tests/support/shared_data.h"
#include "tests/tools/convert/two_photos.h"
#include "tools/convert/check_exports.h"
#include "tools/convert/export_record.h"
#include "tools/convert/ground_frame.h"
#include "tools/convert/write_exports.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

// Two photos of a digital camera, as `orient exterior` leaves them, and a command that converts.
class ConvertedBlock : public testing::Test {
 protected:
  ConvertedBlock() {
    WriteCameraFile(folder_ / "camera.toml", {LargeFrameCamera(), {}, {}, std::nullopt, {}});
    OrientationTable table;
    table.crs = Crs::Parse("EPSG:32635", "test");
    for (const ExchangePhoto& photo : TwoPhotos().block.photos)
      table.rows.push_back({PhotoName(photo.image), PoseOf(photo), std::nullopt});
    WriteOrientationTable(folder_ / "orientation.csv", table);
  }

  ProgramRun Convert(const std::string& input, const std::vector<std::string>& more) const {
    std::vector<std::string> words = {
        "convert", folder_ / input, "--camera",   folder_ / "camera.toml",
        "--out",   folder_ / "out", "--overwrite"};
    words.insert(words.end(), more.begin(), more.end());
    return RunOrient(words);
  }

  void ExpectRefused(const std::string& input, const std::vector<std::string>& more, int exit_code,
                     const std::vector<std::string>& parts) const {
    const ProgramRun run = Convert(input, more);
    EXPECT_EQ(run.exit_code, exit_code) << run.out << run.err;
    for (const std::string& part : parts)
      EXPECT_NE(run.err.find(part), std::string::npos) << part << " in " << run.err;
  }

  const TemporaryFolder folder_;
};

TEST(Convert, EveryFormatProjectsByItsProgramsFormulas) {
  const TemporaryFolder folder;
  for (const WrittenExport& written :
       WriteExports(TwoPhotos(), {AllFormats(), folder.Path(), 0, {}})) {
    const ExportCheck check = CheckExport(written.directory, std::nullopt, "");
    EXPECT_TRUE(check.ok) << Verdict(check);
    EXPECT_EQ(check.points, 18u) << Verdict(check);
    const bool other_system =
        written.format == ExchangeFormat::kAsp || written.format == ExchangeFormat::kOpensfm;
    // The OPK CSV has 0.1 mm and 1e-9 degrees; PAT-B's columns end.
    EXPECT_LT(check.declared.largest_px, other_system ? 0.5 : 1e-2) << Verdict(check);
    EXPECT_EQ(written.largest_px > 0, other_system);
  }
}

// Every format's way there and back.
TEST(Convert, NamesMayHoldBlanksUmlautsAndQuotes) {
  const TemporaryFolder folder;
  ConvertSource source = TwoPhotos();
  source.block.photos[0].image = "Flug 3,  Bild \"Süd\".tif";
  source.block.photos[1].image = "#1 d'Évian & 50%.tif";
  WriteCameraFile(folder / "camera.toml", {source.cameras[0], {}, {}, std::nullopt, {}});
  for (const WrittenExport& written : WriteExports(source, {AllFormats(), folder.Path(), 0, {}})) {
    EXPECT_TRUE(CheckExport(written.directory, std::nullopt, "").ok) << written.directory;
    ConvertSourceOptions back;
    back.input = written.directory;
    back.camera = folder / "camera.toml";
    const ConvertSource read = ReadForeign(written.format, back);
    std::set<std::string> names;
    for (const ExchangePhoto& photo : read.block.photos) names.insert(PhotoName(photo.image + "."));
    for (const ExchangePhoto& photo : source.block.photos)
      EXPECT_TRUE(names.contains(photo.image) || names.contains(PhotoName(photo.image)))
          << photo.image << " in " << written.directory;
  }
}

// In two folders.
ConvertSource TwoOfOneName() {
  ConvertSource source = TwoPhotos();
  source.block.photos[0].image = "north/1.tif";
  source.block.photos[1].image = "south/1.tif";
  return source;
}

TEST(Convert, OneFormatThatFailsDoesNotTakeTheOthersAlong) {
  const TemporaryFolder folder;
  const ConvertSource source = TwoOfOneName();
  ExpectError<InputError>(
      [&] {
        WriteExports(source, {{ExchangeFormat::kPatb, ExchangeFormat::kColmap, ExchangeFormat::kAsp,
                               ExchangeFormat::kMicmac},
                              folder.Path(),
                              0,
                              {}});
      },
      {"patb: ", "asp: ", "written: colmap"});
  EXPECT_TRUE(CheckExport(folder / "colmap", std::nullopt, "").ok);
}

TEST(Convert, ImagesOfTwoFoldersDoNotBecomeOneFile) {
  const TemporaryFolder folder;
  const ConvertSource source = TwoOfOneName();
  ExpectError<InputError>(
      [&] {
        WriteExports(source, {{ExchangeFormat::kAsp}, folder.Path(), 0, std::nullopt});
      },
      {"north/1.tif", "south/1.tif", "asp"});
}

// What UTM does to a large frame from 3500 m: the scale is held by the pose, what remains is the
// curvature's bending, dz = d^2 / 2R: at 2 km from nadir 0.31 m, seen under 30 degrees.
TEST(Convert, GeocentricSystemLeavesTheCurvature) {
  const TemporaryFolder folder;
  const auto written =
      WriteExports(TwoPhotos(), {{ExchangeFormat::kAsp}, folder.Path(), 0, {}}).front();
  EXPECT_GT(written.largest_px, 0.05);
  EXPECT_LT(written.largest_px, 1);
  // On the central meridian true distances are 1 / 0.9996 of the map's: seen from the same height
  // they would look larger, so the camera stands 0.0004 of the flying height above its transformed
  // centre.
  const ConvertSource source = TwoPhotos();
  const GroundFrame frame = GroundFrame::Geocentric(*source.crs, 0);
  const Eigen::Vector3d transformed = *frame.FileFromBlock(source.block.photos[0].centre);
  const Eigen::Vector3d c = ReadAsp(written.directory).front().c;
  EXPECT_NEAR((c - transformed).dot(transformed.normalized()), 0.0004 * 3523.9, 0.1);
  EXPECT_LT((c - transformed).norm(), 1.6);
}

// The same flight with the earth's effects in the block's lens: in curved coordinates only what
// refraction does may stay there, and on the way back curvature comes in again.
TEST(Convert, CurvatureIsInTheLensOrInTheGroundAndNotInBoth) {
  const TemporaryFolder folder;
  ConvertSource source = TwoPhotos();
  source.cameras[0] = WithEarthEffects(source.cameras[0], EarthMode::kCurved, 3827.4, 300);
  source.block.cameras[0] = ExchangeCameraOf(source.cameras[0]).camera;
  const double curvature = CurvatureOf(source.cameras[0], 300);
  EXPECT_LT(curvature, source.cameras[0].earth_k1);
  ConvertSource twice = source;
  twice.cameras[0].earth_k1 = 0;  // nobody knows of it
  EXPECT_GT(WriteExports(twice, {{ExchangeFormat::kAsp}, folder / "twice", 0, {}})[0].largest_px,
            0.4);
  for (const auto& written : WriteExports(source, {AllFormats(), folder.Path(), 0, {}})) {
    SCOPED_TRACE(Name(written.format));
    const bool curved =
        written.format == ExchangeFormat::kAsp || written.format == ExchangeFormat::kOpensfm;
    EXPECT_LT(written.largest_px, 0.15);
    const std::string camera = (fs::path(written.directory) / "camera.toml").string();
    EXPECT_NEAR(ReadCameraFile(camera).camera.earth_k1,
                source.cameras[0].earth_k1 - (curved ? curvature : 0), 1e-15);
    const bool no_camera =
        written.format == ExchangeFormat::kOri || written.format == ExchangeFormat::kPatb ||
        written.format == ExchangeFormat::kBingo || written.format == ExchangeFormat::kAsp;
    for (const std::string& given : {camera, std::string()}) {
      if (given.empty() && (no_camera || written.format == ExchangeFormat::kOpk)) continue;
      ConvertSourceOptions options;
      options.input = written.directory;
      options.camera = given;
      const ConvertSource back = ReadForeign(written.format, options);
      const auto of_flight = [](const Camera& of) {
        return of.earth_k1 * of.principal_distance_mm * of.principal_distance_mm;
      };
      EXPECT_NEAR(of_flight(back.cameras[0]), of_flight(source.cameras[0]), 1e-9);
      for (const VerificationRow& row : ReadVerification(VerificationPath(written.directory))) {
        const std::size_t photo = row.image.starts_with("4711") ? 0 : 1;
        const auto pixel = PixelFromGround(back.block, photo, row.block_m);
        ASSERT_TRUE(pixel);
        EXPECT_LT((*pixel - row.pixel).norm(), 5e-3);
      }
    }
  }
}

// A camera that is not the export's own may hold curvature already, or what nobody knows.
TEST(Convert, CurvatureOfAGivenCameraIsComparedWithTheExports) {
  const TemporaryFolder folder;
  ConvertSource source = TwoPhotos();
  source.cameras[0] = WithEarthEffects(source.cameras[0], EarthMode::kCurved, 3827.4, 300);
  source.block.cameras[0] = ExchangeCameraOf(source.cameras[0]).camera;
  const auto written = WriteExports(source, {{ExchangeFormat::kAsp}, folder.Path(), 0, {}}).front();
  CameraFile file = ReadCameraFile((fs::path(written.directory) / "camera.toml").string());
  ConvertSourceOptions options;
  options.input = written.directory;
  options.camera = folder / "other.toml";
  file.camera = source.cameras[0];
  WriteCameraFile(options.camera, file);
  const ConvertSource back = ReadForeign(ExchangeFormat::kAsp, options);
  EXPECT_EQ(back.cameras[0].earth_k1, source.cameras[0].earth_k1);
  for (const VerificationRow& row : ReadVerification(VerificationPath(written.directory))) {
    const std::size_t photo = row.image.starts_with("4711") ? 0 : 1;
    EXPECT_LT((*PixelFromGround(back.block, photo, row.block_m) - row.pixel).norm(), 5e-3);
  }
  const double earth = source.cameras[0].earth_k1;
  const auto refuse = [&](ExchangeFormat format, double added) {
    file.camera = WithEarth(source.cameras[0], added);
    WriteCameraFile(options.camera, file);
    try {
      ReadForeign(format, options);
      ADD_FAILURE() << Name(format) << " with " << file.camera.earth_k1;
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find("earth_k1"), std::string::npos) << error.what();
    }
  };
  refuse(ExchangeFormat::kAsp, earth);  // in it twice
  const auto projected =
      WriteExports(source, {{ExchangeFormat::kBingo}, folder.Path(), 0, {}}).front();
  options.input = projected.directory;
  refuse(ExchangeFormat::kBingo, -earth);                    // and not at all
  file.camera = WithEarth(source.cameras[0], 0.01 * earth);  // of another calibration
  WriteCameraFile(options.camera, file);
  EXPECT_NO_THROW(ReadForeign(ExchangeFormat::kBingo, options));
}

// Poses come back through every format: what is written from Orient's results and read again shows
// the ground at the same pixels.
TEST(Convert, ThereAndBack) {
  const TemporaryFolder folder;
  const ConvertSource source = TwoPhotos();
  for (const auto& written : WriteExports(source, {AllFormats(), folder.Path(), 0, {}})) {
    ConvertSourceOptions options;
    options.input = written.directory;
    options.camera = (fs::path(written.directory) / "camera.toml").string();
    const ConvertSource back = ReadForeign(written.format, options);
    ASSERT_EQ(back.block.photos.size(), 2u) << Name(written.format);
    const bool other_system = written.largest_px > 0;
    for (const VerificationRow& row :
         ReadVerification((fs::path(written.directory) / "verification.csv").string())) {
      const std::size_t photo = row.image.starts_with("4711") ? 0 : 1;
      const auto pixel = PixelFromGround(back.block, photo, row.block_m);
      ASSERT_TRUE(pixel) << Name(written.format);
      // There and back through a geocentric pose: the same fit twice.
      EXPECT_LT((*pixel - row.pixel).norm(), other_system ? 0.5 : 5e-3) << Name(written.format);
    }
  }
}

// A block's folder: patches are control, ties come from block.json with what the adjustment used.
TEST_F(ConvertedBlock, OfEstimatedPrincipalDistancesIsRefused) {
  ExteriorResult result;
  result.photo = "4711";
  result.status = Status::kOk;
  result.pose = PoseOf(TwoPhotos().block.photos.front());
  result.covariance = Matrix6d::Identity();
  result.principal_distance = EstimatedPrincipalDistance{101, 0.1, 100.5, 1};
  WriteExteriorResult(folder_.Path(), result);
  ExpectRefused(
      "orientation.csv", {"--to", "colmap"}, 2,
      {"4711.exterior.json", "was estimated with its pose", "--principal-distance-sigma-mm"});
}

TEST(Convert, TiesOfTheAdjustmentAreExported) {
  const TemporaryFolder folder;
  WriteCameraFile(folder / "camera.toml", {LargeFrameCamera(), {}, {}, std::nullopt, {}});
  OrientationTable table;
  table.crs = Crs::Parse("EPSG:32635", "test");
  for (const ExchangePhoto& photo : TwoPhotos().block.photos) {
    ExteriorResult result;
    result.photo = PhotoName(photo.image);
    result.status = Status::kOk;
    result.pose = PoseOf(photo);
    result.covariance = Matrix6d::Identity();
    for (const std::int64_t id : {1200, -3}) {
      PatchResult patch;
      patch.id = id;
      patch.state = PatchState::kMatched;
      patch.pixel = Eigen::Vector2d(7000, 4500);
      patch.ground_m = Eigen::Vector3d(500100, 5000300, 310);
      result.patches.push_back(patch);
    }
    WriteExteriorResult(folder.Path(), result);
    table.rows.push_back({result.photo, *result.pose, std::nullopt});
  }
  WriteOrientationTable(folder / "orientation.csv", table);
  WriteAdjustmentResult(folder.Path(), ExampleAdjustment());
  ConvertSourceOptions options;
  options.input = folder.Path();
  options.camera = folder / "camera.toml";
  const auto points = ReadOrientResults(options).block.points;
  ASSERT_EQ(points.size(), 2u) << "not what a neighbour lent, nor what one photo is left of";
  EXPECT_EQ(points[0].name, "1200");
  EXPECT_TRUE(points[0].control);
  EXPECT_EQ(points[1].name, "10001");
  EXPECT_FALSE(points[1].control);
  EXPECT_EQ(points[1].observations.size(), 2u);
  const ProgramRun run = RunOrient({"convert", folder.Path(), "--camera", folder / "camera.toml",
                                    "--to", "patb,bingo,micmac,metashape,colmap,opensfm", "--out",
                                    folder / "out", "--ground-height-m", "300"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(run.out.find("1 control points, 1 tie points"), std::string::npos) << run.out;
  for (const char* file :
       {"patb/patb.im", "bingo/image.dat", "metashape/markers.xml", "opensfm/tracks.csv"})
    EXPECT_NE(ReadFile(folder / (std::string("out/") + file)).find("10001"), std::string::npos)
        << file;
  EXPECT_TRUE(fs::exists(folder / "out/micmac/Homol/Pastis4711.tif/4712.tif.txt"));
  EXPECT_EQ(RunOrient({"convert", folder / "out", "--check"}).exit_code, 0);
  EXPECT_EQ(RunOrient({"convert", folder / "out", "--check", "--to", "patb", "--out", folder / "b"})
                .exit_code,
            1);
}

TEST(RemoveExportsOf, LeavesWhatOthersPutThere) {
  const TemporaryFolder folder;
  ExportOptions options;
  options.formats = {ExchangeFormat::kMicmac, ExchangeFormat::kPatb};
  options.out = folder / "exports";
  for (int time = 0; time < 2; ++time) WriteExports(TwoPhotos(), options);
  const std::string work = folder / "exports/micmac/Malt/dsm.tif";
  fs::create_directories(fs::path(work).parent_path());
  WriteFileAtomically(work, "hours of work");
  RemoveExportsOf(folder.Path());
  EXPECT_TRUE(fs::exists(work));
  EXPECT_FALSE(fs::exists(folder / "exports/micmac/export.json"));
  EXPECT_FALSE(fs::exists(folder / "exports/micmac/Homol"));
  EXPECT_FALSE(fs::exists(folder / "exports/patb"));
}

TEST_F(ConvertedBlock, OfAnotherCrsThanItsPrjSaysIsRefused) {
  ExpectRefused("orientation.csv", {"--to", "colmap", "--crs", "EPSG:32636"}, 2,
                {"UTM zone 35N", "UTM zone 36N", "leave it out"});
  EXPECT_EQ(Convert("orientation.csv", {"--to", "colmap", "--crs", "EPSG:32635"}).exit_code, 0);
}

TEST_F(ConvertedBlock, WithResultsOfAnotherRunIsRefused) {
  const OrientationTable table = ReadOrientationTable(folder_ / "orientation.csv");
  ExteriorResult result;
  result.photo = table.rows[0].photo;
  result.status = Status::kOk;
  result.pose = table.rows[0].pose;
  WriteExteriorResult(folder_.Path(), result);
  EXPECT_EQ(Convert("", {"--to", "colmap"}).exit_code, 0);
  result.pose->position_m.x() += 0.01;
  WriteExteriorResult(folder_.Path(), result);
  ExpectRefused("", {"--to", "colmap"}, 2, {"state different poses of " + result.photo});
}

TEST_F(ConvertedBlock, IsNotWrittenOverItself) {
  EXPECT_EQ(Convert("", {"--to", "colmap"}).exit_code, 0);
  const std::string images = ReadFile(folder_ / "out/colmap/images.txt");
  ExpectRefused("out/colmap", {"--from", "colmap", "--to", "colmap"}, 1, {"is an input"});
  EXPECT_EQ(ReadFile(folder_ / "out/colmap/images.txt"), images);
}

TEST_F(ConvertedBlock, OfAnUnfinishedRunIsSaidToBe) {
  EXPECT_EQ(Convert("", {"--to", "colmap"}).out.find("has not ended"), std::string::npos);
  fs::create_directory(folder_ / "stages");
  WriteFileAtomically(folder_ / "stages/unfinished", "");
  for (const char* input : {"", "orientation.csv"}) {
    const ProgramRun run = Convert(input, {"--to", "colmap"});
    EXPECT_EQ(run.exit_code, 0) << run.err;
    EXPECT_NE(run.out.find("note: the last run into " + folder_.Path()), std::string::npos)
        << run.out;
  }
}

TEST_F(ConvertedBlock, NeedsPlausibleOptions) {
  for (const std::vector<std::string>& wrong :
       {std::vector<std::string>{"--origin", "nan", "0", "0"},
        {"--geoid-m", "1e9"},
        {"--ground-height-m", "nan"}}) {
    std::vector<std::string> words = {"--to", "colmap"};
    words.insert(words.end(), wrong.begin(), wrong.end());
    ExpectRefused("orientation.csv", words, 1, {wrong.front()});
  }
}

TEST_F(ConvertedBlock, ReadsNoPositionThatIsNotFinite) {
  ASSERT_EQ(Convert("orientation.csv", {"--to", "metashape"}).exit_code, 0);
  const std::string path = folder_ / "out/metashape/cameras.xml";
  std::string text = ReadFile(path);
  const std::size_t scale = text.find('>', text.find("<scale")) + 1;
  text.replace(scale, text.find('<', scale) - scale, "1e308");
  WriteFileAtomically(path, text);
  ExpectRefused("out/metashape", {"--from", "metashape", "--to", "opk"}, 2, {"4711", "finite"});
}

TEST_F(ConvertedBlock, ReadsNoDamagedOriLine) {
  ASSERT_EQ(Convert("orientation.csv", {"--to", "ori"}).exit_code, 0);
  const std::string path = folder_ / "out/ori/orientation.ori";
  const std::string whole = ReadFile(path);
  const std::size_t dot = whole.rfind('.');  // of the last photo's kappa
  WriteFileAtomically(path, whole.substr(0, dot) + "," + whole.substr(dot + 1));
  ExpectRefused("out/ori", {"--from", "ori", "--to", "opk"}, 2, {"orientation.ori", "8 words"});
  const std::size_t last_line = whole.rfind('\n', whole.size() - 2) + 1;
  WriteFileAtomically(path, whole + whole.substr(last_line));
  ExpectRefused("out/ori", {"--from", "ori", "--to", "opk"}, 2, {"4712", "twice"});
  WriteFileAtomically(path, whole.substr(0, last_line));
  const ProgramRun cut = Convert("out/ori", {"--from", "ori", "--to", "opk"});
  EXPECT_EQ(cut.exit_code, 0) << cut.err;
  EXPECT_NE(cut.out.find("4712 for one: was it truncated?"), std::string::npos) << cut.out;
}

TEST_F(ConvertedBlock, IsWrittenAndChecked) {
  const ProgramRun written =
      RunOrient({"convert", folder_ / "orientation.csv", "--camera", folder_ / "camera.toml",
                 "--to", "colmap,micmac", "--out", folder_ / "out"});
  EXPECT_EQ(written.exit_code, 0) << written.err;
  EXPECT_TRUE(fs::exists(folder_ / "out/micmac/Ori-Orient/Orientation-4711.tif.xml"));
  const std::string run = ReadFile(folder_ / "out/run.json");
  for (const char* what : {"\"convert\"", "orient 0.", "orientation.csv", "camera.toml"})
    EXPECT_NE(run.find(what), std::string::npos) << what << "\n" << run;
  const ProgramRun checked = RunOrient({"convert", folder_ / "out", "--check"});
  EXPECT_EQ(checked.exit_code, 0) << checked.out << checked.err;
  // What a block's run calls for its [output] formats.
  const ExportsOfFolder exports =
      WriteExportsOf(folder_.Path(), folder_ / "camera.toml", {"metashape", "patb"});
  EXPECT_EQ(exports.written.size(), 2u);
  ASSERT_EQ(exports.findings.size(), 1u);
  EXPECT_EQ(exports.findings[0].reason, Reason::kExportNote);
  EXPECT_TRUE(exports.findings[0].where.starts_with("patb: image coordinates are free"));
  EXPECT_TRUE(fs::exists(folder_ / "exports/patb/patb.ori"));
  EXPECT_THROW(WriteExportsOf(folder_.Path(), folder_ / "camera.toml", {"bundler"}), UsageError);
  const ProgramRun again =
      RunOrient({"convert", folder_ / "orientation.csv", "--camera", folder_ / "camera.toml",
                 "--to", "colmap", "--out", folder_ / "out"});
  EXPECT_EQ(again.exit_code, 1) << "results would be overwritten";
  const ProgramRun on =
      RunOrient({"convert", folder_ / "out/colmap", "--from", "colmap", "--to", "metashape,asp",
                 "--out", folder_ / "on", "--ground-height-m", "300"});
  EXPECT_EQ(on.exit_code, 0) << on.err;
  const ProgramRun lost =
      RunOrient({"convert", folder_ / "orientation.csv", "--camera", folder_ / "camera.toml",
                 "--to", "asp", "--out", folder_ / "x"});
  EXPECT_EQ(lost.exit_code, 2);
  EXPECT_NE(lost.err.find("--ground-height-m"), std::string::npos) << lost.err;
  const ProgramRun nothing =
      RunOrient({"convert", folder_ / "on/asp", "--check", "--from", "bingo"});
  EXPECT_EQ(nothing.exit_code, 2);
  EXPECT_NE(nothing.err.find("itera.dat"), std::string::npos) << nothing.err;
}

}  // namespace
}  // namespace orient
