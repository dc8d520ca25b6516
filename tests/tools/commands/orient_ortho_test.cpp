// orient ortho as a user runs it, on photos of hills whose grey values say where they come from.
#include <gdal_priv.h>
#include <gtest/gtest.h>

#include <cstdio>
#include <filesystem>

#include "block/inputs/block_camera.h"
#include "core/base/atomic_write.h"
#include "core/base/open_dataset.h"
#include "core/files/orientation_table.h"
#include "core/files/results.h"
#include "core/raster/band_raster.h"
#include "ortho/seamlines.h"
#include "tests/support/hilly_view.h"
#include "tests/support/run_orient.h"
#include "tests/support/shared_data.h"
#include "tools/report/block_record.h"
#include "tools/report/report.h"
#include "tools/report/run_record.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

constexpr int kSide = 100;  // px

class OrientOrtho : public ::testing::Test {
 protected:
  OrientOrtho() {
    CameraFile camera;
    camera.camera.name = "digital";
    camera.camera.kind = CameraKind::kDigital;
    camera.camera.principal_distance_mm = 150;
    camera.camera.frame_mm = {210, 210};
    camera.camera.image_px = Eigen::Vector2i(kSide, kSide);
    WriteCameraFile(Path("camera.toml"), camera);
    block::WriteBlockCamera(folder_.Path(), camera);
    ortho::WriteHills(Path("dem.tif"), crs_);
    fs::create_directory(Path("scans"));
    AddPhoto("west", 4700, Status::kOk);
    AddPhoto("a b 'east'", 5200, Status::kOk);
    AddPhoto("shaky", 5000, Status::kWeak);
    table_.crs = crs_;
    WriteOrientationTable(Path("orientation.csv"), table_);
  }

  void AddPhoto(const std::string& name, double x, Status status) {
    const CameraFile camera = ReadCameraFile(Path("camera.toml"));
    const PhotoView view{
        camera.camera, DigitalPhotoFromPixel(camera.camera), {{x, 3000, 900}, {0.01, -0.02, 0.3}}};
    ortho::WriteScan(
        Path("scans/" + name + ".tif"), view, ortho::Hills(),
        [](double east, double) { return 20 * (east - 3500); }, kSide);
    ExteriorResult result;
    result.photo = name;
    result.status = status;
    result.width = result.height = kSide;
    result.pose = view.pose;
    result.covariance = Matrix6d(1e-6 * Matrix6d::Identity());
    if (status == Status::kWeak)
      result.findings = {{.reason = Reason::kFewPlaces, .at_best = Status::kWeak, .value = 3}};
    WriteExteriorResult(folder_.Path(), result);
    table_.rows.push_back({name, view.pose, std::nullopt});
  }

  std::string Path(const std::string& name) const { return folder_ / name; }

  ProgramRun Run(const std::vector<std::string>& further, const std::string& input = "") const {
    std::vector<std::string> arguments = {"ortho", input.empty() ? folder_.Path() : Path(input),
                                          Path("scans/*.tif"), "--dem", Path("dem.tif")};
    arguments.insert(arguments.end(), further.begin(), further.end());
    return RunOrient(arguments);
  }

  // As another run would: to the east, in all files.
  void MoveWest(double by_m = 5) const {
    ExteriorResult moved = ReadExteriorResult(ExteriorResultPath(folder_.Path(), "west"));
    moved.pose->position_m.x() += by_m;
    WriteExteriorResult(folder_.Path(), moved);
    OrientationTable table = table_;
    for (OrientationRow& row : table.rows)
      if (row.photo == "west") row.pose = *moved.pose;
    WriteOrientationTable(Path("orientation.csv"), table);
  }

  // The photo "west" as if developed flatter and darker.
  void DarkenWest() const {
    const CameraFile camera = ReadCameraFile(Path("camera.toml"));
    const PhotoView view{camera.camera,
                         DigitalPhotoFromPixel(camera.camera),
                         {{4700, 3000, 900}, {0.01, -0.02, 0.3}}};
    ortho::WriteScan(
        Path("scans/west.tif"), view, ortho::Hills(),
        [](double east, double) { return 14 * (east - 3500) - 2000; }, kSide);
  }

  // Which photo each place of a grid over both belongs to.
  std::vector<int> LabelsOf(const std::string& seamlines) const {
    WriteFileAtomically(Path("read.gpkg"), seamlines);
    const auto grid = ortho::MapGrid::Around({4000, 2300, 5900, 3700}, 10);
    return ortho::Seamlines::FromFile(Path("read.gpkg"), crs_)
        .PhotoAt(grid, {0, 0, grid.width, grid.height});
  }

  bool Exists(const std::string& name) const { return fs::exists(Path(name)); }

  TemporaryFolder folder_;
  Crs crs_ = Crs::Parse("EPSG:32635", "test");
  OrientationTable table_;
};

TEST_F(OrientOrtho, MakesOrthophotosOfWhatIsOkAndNamesTheRest) {
  const ProgramRun run = Run({"--mosaic"});
  EXPECT_EQ(run.exit_code, 3) << run.err;
  EXPECT_NE(run.out.find("left out  shaky: is weak (--weak"), std::string::npos) << run.out;
  EXPECT_TRUE(Exists("ortho/west.ortho.tif"));
  EXPECT_TRUE(Exists("ortho/a b 'east'.ortho.tif"));
  EXPECT_FALSE(Exists("ortho/shaky.ortho.tif"));
  const auto seamlines = ortho::Seamlines::FromFile(Path("ortho/seamlines.gpkg"), crs_);
  EXPECT_EQ(seamlines.Photos(), (std::vector<std::string>{"a b 'east'", "west"}));
  const BandRaster mosaic = BandRaster::Open(Path("ortho/mosaic.tif"));
  EXPECT_GT(mosaic.Width(), BandRaster::Open(Path("ortho/west.ortho.tif")).Width());
  EXPECT_EQ(mosaic.Metadata("TIFFTAG_SOFTWARE"), "orient " + ProgramVersion());
  EXPECT_EQ(mosaic.Metadata("ORIENT_PHOTOS"), "a b 'east', west");
  EXPECT_EQ(mosaic.Metadata("ORIENT_DEM"), "dem.tif");
  EXPECT_GT(std::stod(mosaic.Metadata("ORIENT_CE90_WORST_M")), 0);
  const RunRecord made = ReadRunRecords(Path("ortho")).at("ortho");
  EXPECT_EQ(made.program, "orient " + ProgramVersion());
  ASSERT_EQ(made.inputs.size(), 2U);
  EXPECT_EQ(made.inputs[0].path, Path("orientation.csv"));
  EXPECT_EQ(made.inputs[1].path, Path("dem.tif"));
  const GDALDatasetUniquePtr lines = OpenVectorDataset(Path("ortho/seamlines.gpkg"));
  ASSERT_TRUE(lines);
  EXPECT_EQ(lines->GetMetadataItem("orient_ortho"), ProgramAndInputs(made));
  EXPECT_STREQ(lines->GetMetadataItem("orient_seamlines"), "nearest nadir");
  EXPECT_FALSE(Exists("report.html")) << "there was none";
}

TEST_F(OrientOrtho, APhotoWhoseFilesStateDifferentPosesIsLeftOut) {
  MoveWest();
  WriteOrientationTable(Path("orientation.csv"), table_);  // as before
  const ProgramRun run = Run({"--gsd-m", "10"});
  EXPECT_EQ(run.exit_code, 3) << run.err;
  EXPECT_NE(run.out.find("west: orientation.csv and west.exterior.json state different poses"),
            std::string::npos)
      << run.out;
  EXPECT_FALSE(fs::exists(Path("ortho/west.ortho.tif")));
}

TEST_F(OrientOrtho, NeitherItsDemNorAFileOfOthersIsReplaced) {
  const std::string out = Path("out"), others = out + "/west.ortho.tif";
  fs::create_directory(out);
  fs::copy(Path("dem.tif"), others);
  const std::string before = ReadFile(others);
  const std::vector<std::string> words = {
      "ortho", folder_.Path(), Path("scans/west.tif"), "--out", out, "--gsd-m", "10", "--dem"};
  const auto refused = [&](const std::string& dem, const std::string& option,
                           const std::string& why) {
    std::vector<std::string> arguments = words;
    arguments.insert(arguments.end(), {dem, option});
    const ProgramRun run = RunOrient(arguments);
    EXPECT_EQ(run.exit_code, 1) << run.out;
    EXPECT_NE(run.err.find(why), std::string::npos) << run.err;
    EXPECT_EQ(ReadFile(others), before);
  };
  refused(others, "--resume", "is an input");
  refused(others, "--overwrite", "is an input");
  refused(Path("dem.tif"), "--resume", "was not made by orient ortho");
}

TEST_F(OrientOrtho, AMosaicOfOthersIsNotReplaced) {
  fs::create_directory(Path("ortho"));
  fs::copy(Path("dem.tif"), Path("ortho/mosaic.tif"));
  const ProgramRun run = Run({"--mosaic", "--gsd-m", "10", "--resume"});
  EXPECT_EQ(run.exit_code, 1) << run.out;
  EXPECT_NE(run.err.find("mosaic.tif was not made by orient ortho"), std::string::npos) << run.err;
  EXPECT_EQ(ReadFile(Path("ortho/mosaic.tif")), ReadFile(Path("dem.tif")));
  WriteFileAtomically(Path("ortho/mosaic.tif"), "no raster at all");
  EXPECT_EQ(Run({"--mosaic", "--gsd-m", "10", "--resume"}).exit_code, 1);
  EXPECT_EQ(ReadFile(Path("ortho/mosaic.tif")), "no raster at all");
}

TEST_F(OrientOrtho, PosesOfARunThatHasNotEndedAreSaidToBe) {
  EXPECT_EQ(Run({"--plan"}).out.find("has not ended"), std::string::npos);
  fs::create_directory(Path("stages"));
  WriteFileAtomically(Path("stages/unfinished"), "");
  const ProgramRun run = Run({"--plan"});
  EXPECT_EQ(run.exit_code, 3) << run.err;  // one photo is weak
  EXPECT_NE(run.out.find("the last run into " + folder_.Path() + " has not ended"),
            std::string::npos)
      << run.out;
}

TEST_F(OrientOrtho, AReportThatIsThereShowsThem) {
  WriteReport(folder_.Path());
  Run({"--gsd-m", "10"});
  EXPECT_NE(ReadFile(Path("report.html")).find("2 orthophotos of 10 m a pixel over dem.tif"),
            std::string::npos);
}

TEST_F(OrientOrtho, ARunOnAPartOfThePhotosMakesTheOthersNoneOfTheNewPoses) {
  const auto other_poses = [&] { return ReadBlockRecord(folder_.Path()).ortho->of_other_poses; };
  Run({"--gsd-m", "10"});
  EXPECT_TRUE(other_poses().empty());
  for (OrientationRow& row : table_.rows) {
    ExteriorResult moved = ReadExteriorResult(ExteriorResultPath(folder_.Path(), row.photo));
    row.pose.position_m.x() += 5;
    moved.pose = row.pose;
    WriteExteriorResult(folder_.Path(), moved);
  }
  WriteOrientationTable(Path("orientation.csv"), table_);
  EXPECT_EQ(other_poses(), (std::vector<std::string>{"a b 'east'", "west"}));
  RunOrient({"ortho", folder_.Path(), Path("scans/west.tif"), "--dem", Path("dem.tif"), "--gsd-m",
             "10", "--resume"});
  EXPECT_EQ(other_poses(), std::vector<std::string>{"a b 'east'"});
}

TEST_F(OrientOrtho, AMosaicOfOtherOrthophotosIsNamedByTheRunAndByTheReport) {
  const auto changes = [&] { return ReadBlockRecord(folder_.Path()).ortho->mosaic->changes; };
  Run({"--mosaic", "--gsd-m", "10"});
  EXPECT_FALSE(changes().Any());
  EXPECT_EQ(Run({"--gsd-m", "10", "--resume"}).out.find("note"), std::string::npos);
  MoveWest();
  const ProgramRun run = Run({"--gsd-m", "10", "--resume"});
  EXPECT_NE(run.out.find("mosaic.tif was made from other orthophotos of west; --mosaic makes it"),
            std::string::npos)
      << run.out;
  EXPECT_EQ(changes().others, std::vector<std::string>{"west"});
  EXPECT_NE(Run({"--gsd-m", "10", "--resume"}).out.find("other orthophotos of west"),
            std::string::npos)
      << "nor is it made anew where all orthophotos are kept";
  const ProgramRun more = Run({"--gsd-m", "10", "--resume", "--weak"});
  EXPECT_NE(more.out.find("of west, and was made without those of shaky;"), std::string::npos)
      << more.out;
  EXPECT_EQ(changes().lacking, std::vector<std::string>{"shaky"});
  const ProgramRun anew = Run({"--gsd-m", "10", "--resume", "--weak", "--mosaic"});
  EXPECT_EQ(anew.out.find("other orthophotos"), std::string::npos) << anew.out;
  EXPECT_FALSE(changes().Any());
}

TEST_F(OrientOrtho, AMosaicThatDoesNotSayWhatItWasMadeFromIsNamedWhereOrthophotosAreMade) {
  Run({"--mosaic", "--gsd-m", "10"});
  {
    const CPLErrorHandlerPusher quiet(CPLQuietErrorHandler);  // of what it costs a COG
    const GDALDatasetUniquePtr mosaic(
        GDALDataset::Open(Path("ortho/mosaic.tif").c_str(), GDAL_OF_RASTER | GDAL_OF_UPDATE));
    mosaic->SetMetadataItem("ORIENT_MADE_FROM", nullptr);
  }
  EXPECT_EQ(Run({"--gsd-m", "10", "--resume"}).out.find("mosaic.tif"), std::string::npos);
  EXPECT_NE(Run({"--gsd-m", "10", "--overwrite"}).out.find("does not say what it was made from"),
            std::string::npos);
}

TEST_F(OrientOrtho, APhotoOverTheEndOfTheDemIsNamedWithWhatItsOrthophotoShows) {
  EXPECT_EQ(Run({"--gsd-m", "10"}).out.find("ends or has no heights"), std::string::npos);
  constexpr int kColumns = 120, kRows = 300;  // as far as x = 4700, below the western photo
  const auto hills = ortho::Hills();
  std::vector<float> heights;
  for (int row = 0; row < kRows; ++row)
    for (int col = 0; col < kColumns; ++col)
      heights.push_back(
          static_cast<float>(hills.HeightAt(3505 + 10 * col, 4495 - 10 * row).value()));
  simulation::WriteFloatTiff(Path("half.tif"), kColumns, kRows, heights, {3500, 4500, 10, crs_});
  WriteReport(folder_.Path());
  const ProgramRun run = RunOrient({"ortho", folder_.Path(), Path("scans/west.tif"), "--dem",
                                    Path("half.tif"), "--gsd-m", "10", "--overwrite"});
  const std::size_t at = run.out.find("half.tif ends or has no heights under part of the frame");
  ASSERT_NE(at, std::string::npos) << run.out << run.err;
  EXPECT_NE(run.out.find("of 1 photo, whose orthophoto shows only the rest: west (", at),
            std::string::npos)
      << run.out;
  const double share = std::stod(
      BandRaster::Open(Path("ortho/west.ortho.tif")).Metadata("ORIENT_FRAME_WITH_HEIGHTS"));
  EXPECT_NEAR(share, 0.5, 0.05);
  EXPECT_NE(ReadFile(Path("report.html")).find("orthophotos end, too: those of west ("),
            std::string::npos);
}

TEST_F(OrientOrtho, APhotoBesideTheDemFailsAlone) {
  MoveWest(50000);
  const ProgramRun plan = Run({"--plan"});
  EXPECT_NE(plan.out.find("cannot    west: "), std::string::npos) << plan.out << plan.err;
  const ProgramRun run = Run({});
  EXPECT_EQ(run.exit_code, 3) << run.err;
  EXPECT_NE(run.out.find("failed    west: "), std::string::npos) << run.out;
  EXPECT_TRUE(Exists("ortho/a b 'east'.ortho.tif"));
}

TEST_F(OrientOrtho, WhatIsNoPixelSizeIsCalledSo) {
  for (const char* text : {"-1", "0", "nan", "inf", "wide"}) {
    const ProgramRun run = Run({"--gsd-m", text});
    EXPECT_EQ(run.exit_code, 1) << text;
    EXPECT_NE(run.err.find(std::string("--gsd-m: ") + text +
                           " is not a pixel size; give a positive number of metres"),
              std::string::npos)
        << run.err;
  }
}

TEST_F(OrientOrtho, WeakPhotosAreTakenWhenAsked) {
  EXPECT_EQ(Run({"--weak", "--gsd-m", "10"}).exit_code, 0);
  EXPECT_TRUE(Exists("ortho/shaky.ortho.tif"));
  EXPECT_EQ(BandRaster::Open(Path("ortho/shaky.ortho.tif")).Metadata("ORIENT_GSD_M"), "10");
}

TEST_F(OrientOrtho, ResumeKeepsWhatWasMadeFromTheSame) {
  Run({"--gsd-m", "10"});
  EXPECT_EQ(Run({"--gsd-m", "10"}).exit_code, 1) << "what is there is not overwritten";
  fs::remove(Path("ortho/west.ortho.tif"));
  const std::string east = ReadFile(Path("ortho/a b 'east'.ortho.tif"));
  const ProgramRun plan = Run({"--gsd-m", "10", "--resume", "--plan"});
  EXPECT_NE(plan.out.find("do    ortho     " + Path("ortho/west.ortho.tif")), std::string::npos);
  EXPECT_NE(plan.out.find("keep  ortho     "), std::string::npos) << plan.out;
  EXPECT_FALSE(Exists("ortho/west.ortho.tif"));
  const ProgramRun again = Run({"--gsd-m", "10", "--resume"});
  EXPECT_TRUE(Exists("ortho/west.ortho.tif"));
  EXPECT_NE(again.out.find("'east'.ortho.tif: 1"), std::string::npos) << again.out;
  EXPECT_NE(again.out.find("kept"), std::string::npos) << again.out;
  EXPECT_EQ(ReadFile(Path("ortho/a b 'east'.ortho.tif")), east);
  EXPECT_EQ(Run({"--gsd-m", "12", "--resume"}).out.find("kept"), std::string::npos);
  ExteriorResult moved = ReadExteriorResult(ExteriorResultPath(folder_.Path(), "west"));
  moved.pose->position_m.x() += 5;
  WriteExteriorResult(folder_.Path(), moved);
  const ProgramRun after = Run({"--gsd-m", "12", "--resume"});
  EXPECT_EQ(after.out.find("kept"), after.out.rfind("kept")) << "one of the two: " << after.out;
}

// As a full disk or a lost connection leaves it where nobody notices.
TEST_F(OrientOrtho, ResumeMakesAgainWhatWasCutOff) {
  Run({"--gsd-m", "10"});
  const std::string west = Path("ortho/west.ortho.tif");
  ASSERT_TRUE(BandRaster::Open(west).IsWhole());
  fs::resize_file(west, fs::file_size(west) - 1000);
  EXPECT_FALSE(BandRaster::Open(west).IsWhole());
  const ProgramRun again = Run({"--gsd-m", "10", "--resume"});
  EXPECT_TRUE(BandRaster::Open(west).IsWhole()) << again.out;
  EXPECT_NE(again.out.find("kept"), std::string::npos) << "the other one";
}

TEST_F(OrientOrtho, SeamlinesAreReadBack) {
  Run({"--mosaic", "--gsd-m", "5"});
  const std::string nearest = ReadFile(Path("ortho/mosaic.tif"));
  ortho::Seamlines::ByNearestNadir(
      {{"west",
        {4700, 3000},
        {{3500, 1500}, {6500, 1500}, {6500, 4500}, {3500, 4500}, {3500, 1500}}}})
      .Write(Path("edited.gpkg"), crs_);
  const ProgramRun run = Run({"--seams", Path("edited.gpkg"), "--gsd-m", "5", "--resume"});
  EXPECT_EQ(run.exit_code, 3) << run.err;
  EXPECT_NE(ReadFile(Path("ortho/mosaic.tif")), nearest);
}

// Edited where they are; drawn anew only when that is asked for.
TEST_F(OrientOrtho, ResumeKeepsTheSeamlinesThatAreThere) {
  Run({"--mosaic", "--gsd-m", "10"});
  const std::string made = ReadFile(Path("ortho/seamlines.gpkg"));
  ortho::Seamlines::ByNearestNadir(
      {{"west",
        {4700, 3000},
        {{3500, 1500}, {6500, 1500}, {6500, 4500}, {3500, 4500}, {3500, 1500}}}})
      .Write(Path("ortho/seamlines.gpkg"), crs_);
  const std::string edited = ReadFile(Path("ortho/seamlines.gpkg"));
  const ProgramRun run = Run({"--mosaic", "--gsd-m", "10", "--resume"});
  EXPECT_EQ(ReadFile(Path("ortho/seamlines.gpkg")), edited);
  EXPECT_NE(run.out.find("no polygon of a b 'east'"), std::string::npos) << run.out;
  EXPECT_EQ(Run({"--mosaic", "--gsd-m", "10"}).exit_code, 1);
  Run({"--mosaic", "--gsd-m", "10", "--overwrite"});
  EXPECT_EQ(ReadFile(Path("ortho/seamlines.gpkg")), made);
}

// The ground's grey values say where it lies, so the photos agree but for the interpolation; one of
// them gets darker and flatter.
TEST_F(OrientOrtho, BalanceGivesThePhotosOneTone) {
  DarkenWest();
  const ProgramRun run = Run({"--balance", "--gsd-m", "10"});
  EXPECT_EQ(run.exit_code, 3) << run.err;
  EXPECT_NE(run.out.find("overlapping photos differ by "), std::string::npos) << run.out;
  const std::string tones = ReadFile(Path("ortho/mosaic_tones.csv"));
  double of_east = 0, of_west = 0, offset = 0;
  ASSERT_EQ(std::sscanf(tones.c_str(), "photo,band,gain,offset\na b 'east',1,%lf,%lf\nwest,1,%lf,",
                        &of_east, &offset, &of_west),
            3)
      << tones;
  EXPECT_NEAR(of_west / of_east, 20.0 / 14, 0.05);
  const ProgramRun without = Run({"--mosaic", "--gsd-m", "10", "--resume"});
  EXPECT_NE(without.out.find("not without --balance"), std::string::npos) << without.out;
  EXPECT_FALSE(Exists("ortho/mosaic_tones.csv"));
}

// Another gain is no reason for a line to run elsewhere, where the photos get one tone.
TEST_F(OrientOrtho, SeamlinesAreSoughtInTheTonesOfTheMosaic) {
  ASSERT_EQ(Run({"--balance", "--least-difference", "--gsd-m", "10"}).exit_code, 3);
  const std::string balanced = ReadFile(Path("ortho/seamlines.gpkg"));
  DarkenWest();
  ASSERT_EQ(Run({"--balance", "--least-difference", "--gsd-m", "10", "--overwrite"}).exit_code, 3);
  const auto before = LabelsOf(balanced), after = LabelsOf(ReadFile(Path("ortho/seamlines.gpkg")));
  int moved = 0;
  for (std::size_t i = 0; i < before.size(); ++i) moved += before[i] != after[i];
  EXPECT_LT(moved, static_cast<int>(before.size()) / 50);
}

TEST_F(OrientOrtho, SeamlinesOfLeastDifferenceAreSoughtAndCanBeEdited) {
  Run({"--mosaic", "--gsd-m", "10"});
  const std::string nearest = ReadFile(Path("ortho/seamlines.gpkg"));
  const ProgramRun run = Run({"--least-difference", "--gsd-m", "10", "--overwrite"});
  EXPECT_EQ(run.exit_code, 3) << run.err;
  const std::string sought = ReadFile(Path("ortho/seamlines.gpkg"));
  EXPECT_NE(sought, nearest);
  EXPECT_EQ(ortho::Seamlines::FromFile(Path("ortho/seamlines.gpkg"), crs_).Photos().size(), 2U);
  const ProgramRun again = Run({"--least-difference", "--gsd-m", "10", "--resume"});
  EXPECT_NE(again.out.find("polygons, kept"), std::string::npos) << again.out;
  EXPECT_NE(again.out.find("is kept; --overwrite"), std::string::npos) << again.out;
  EXPECT_EQ(ReadFile(Path("ortho/seamlines.gpkg")), sought);
  EXPECT_EQ(Run({"--least-difference", "--seams", Path("ortho/seamlines.gpkg")}).exit_code, 1);
}

TEST_F(OrientOrtho, WhatAScanDeclaresAsNothingIsNothingAndTheMosaicShowsTheNeighbourThere) {
  const auto shown = [&](const std::string& file) {
    const BandRaster raster = BandRaster::Open(Path(file));
    const auto mask = raster.ReadMask({0, 0, raster.Width(), raster.Height()});
    return mask.size() - static_cast<std::size_t>(std::count(mask.begin(), mask.end(), 0));
  };
  Run({"--gsd-m", "10", "--mosaic"});
  const std::size_t whole = shown("ortho/west.ortho.tif"), all = shown("ortho/mosaic.tif");
  {
    constexpr int kHole = 20;
    const GDALDatasetUniquePtr scan(
        GDALDataset::Open(Path("scans/west.tif").c_str(), GDAL_OF_RASTER | GDAL_OF_UPDATE));
    std::vector<std::uint16_t> nothing(kHole * kHole, 0);
    GDALRasterBand* band = scan->GetRasterBand(1);
    ASSERT_EQ(band->RasterIO(GF_Write, 55, 40, kHole, kHole, nothing.data(), kHole, kHole,
                             GDT_UInt16, 0, 0),
              CE_None);
    band->SetNoDataValue(0);
  }
  Run({"--gsd-m", "10", "--mosaic", "--overwrite"});
  EXPECT_LT(shown("ortho/west.ortho.tif"), whole - 350);
  EXPECT_GT(shown("ortho/mosaic.tif"), all - 50);
}

TEST_F(OrientOrtho, SeamlinesThatCannotBeReadCostNoOrthophotos) {
  WriteFileAtomically(Path("seams.gpkg"), "no GeoPackage");
  const ProgramRun run = Run({"--mosaic", "--seams", Path("seams.gpkg")});
  EXPECT_EQ(run.exit_code, 2) << run.out;
  EXPECT_NE(run.err.find("seams.gpkg"), std::string::npos) << run.err;
  EXPECT_FALSE(Exists("ortho"));
}

TEST_F(OrientOrtho, SigmasWithoutCorrelationsGiveNoCe90) {
  for (OrientationRow& row : table_.rows) row.sigma = Vector6d::Constant(0.001);
  WriteOrientationTable(Path("with_sigmas.csv"), table_);
  const ProgramRun run = Run({"--camera", Path("camera.toml"), "--mosaic"}, "with_sigmas.csv");
  EXPECT_EQ(run.out.find("CE90"), std::string::npos) << run.out;
  EXPECT_EQ(BandRaster::Open(Path("ortho/mosaic.tif")).Metadata("ORIENT_CE90_WORST_M"), "");
}

TEST_F(OrientOrtho, ATableOfPosesDoesAsWell) {
  const ProgramRun run = Run({"--gsd-m", "10", "--out", Path("from_table")}, "orientation.csv");
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_TRUE(Exists("from_table/shaky.ortho.tif")) << "a table knows no status";
  EXPECT_EQ(run.out.find("CE90"), std::string::npos) << "nor an accuracy: " << run.out;
}

TEST_F(OrientOrtho, WhatIsMissingIsAskedFor) {
  EXPECT_NE(RunOrient({"ortho", folder_.Path()}).err.find("scans"), std::string::npos);
  EXPECT_NE(RunOrient({"ortho", folder_.Path(), Path("scans/west.tif")}).err.find("--dem"),
            std::string::npos);
  EXPECT_EQ(Run({"--overwrite", "--resume"}).exit_code, 1);
  fs::remove(Path("orientation.prj"));
  EXPECT_NE(Run({}).err.find(".prj"), std::string::npos);
  fs::remove(block::BlockCameraPath(folder_.Path()));
  EXPECT_NE(Run({}).err.find("--camera"), std::string::npos);
}

TEST_F(OrientOrtho, AnotherScanThanTheOrientedOneIsLeftOut) {
  simulation::WriteGreyTiff(Path("scans/west.tif"), 90, 90, std::vector<std::uint16_t>(8100, 9), 16,
                            std::nullopt, std::nullopt);
  const ProgramRun run = Run({"--gsd-m", "10"});
  EXPECT_EQ(run.exit_code, 3);
  EXPECT_NE(run.out.find("left out  west"), std::string::npos) << run.out;
  EXPECT_FALSE(Exists("ortho/west.ortho.tif"));
}

}  // namespace
}  // namespace orient
