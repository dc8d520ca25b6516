// Blocks that are not whole: what is wrong is named, the rest is done.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <sstream>

#include "core/files/adjustment_result.h"
#include "tests/end_to_end/spoilt_block.h"
#include "tests/support/run_orient.h"
#include "tools/simulate/geotiff.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

using ChangedBlock = BadPhoto;

TEST_F(ChangedBlock, APhotoThatLeavesTheBlockIsSetAsideAndMayComeBack) {
  ASSERT_EQ(Block().exit_code, 0);
  const std::string all = ReadFile(Path("block.toml"));
  const std::string result = ReadFile(Path("out/new_1_2.exterior.json"));
  Edit("block.toml", "scans/*.tif", "scans/new_1_1.tif");
  const ProgramRun without = Block({"--resume"});
  EXPECT_EQ(without.exit_code, 3) << without.out << without.err;  // the table still has it
  EXPECT_NE(without.out.find("(new_1_2) were moved to " + Path("out/not_in_block")),
            std::string::npos)
      << without.out;
  EXPECT_EQ(ReadFile(Path("out/not_in_block/new_1_2.exterior.json")), result);
  EXPECT_FALSE(fs::exists(Path("out/new_1_2.exterior.json")));
  EXPECT_EQ(ReadOrientationTable(Path("out/orientation.csv")).rows.size(), 1u);
  const std::string report = ReadFile(Path("out/report.html"));
  EXPECT_NE(report.find("new_1_1"), std::string::npos);
  EXPECT_EQ(report.find("id=\"new_1_2\""), std::string::npos);
  EXPECT_EQ(report.find("new_1_2.patches.png"), std::string::npos);
  Write("block.toml", all);
  const ProgramRun again = Block({"--resume"});
  EXPECT_EQ(again.exit_code, 0) << again.out << again.err;
  EXPECT_EQ(ReadFile(Path("out/new_1_2.exterior.json")), result);
}

TEST_F(ChangedBlock, ThePlanNamesExportsAndOrthophotos) {
  Edit("block.toml", "[output]", "[ortho]\n[output]\nformats = [\"patb\", \"colmap\"]");
  const ProgramRun plan = Block({"--plan"});
  EXPECT_EQ(plan.exit_code, 0) << plan.err;
  for (const std::string file : {"exports/patb", "exports/colmap"})
    EXPECT_NE(plan.out.find("do    write     " + Path("out/" + file) + "\n"), std::string::npos)
        << plan.out;
  EXPECT_NE(plan.out.find("do    ortho     " + Path("out/ortho") + "\n"), std::string::npos)
      << plan.out;
}

TEST_F(ChangedBlock, ThePlanOfAFinishedBlockIsRefusedAsItsRunIs) {
  ASSERT_EQ(Block().exit_code, 0);
  const ProgramRun run = Block(), plan = Block({"--plan"});
  EXPECT_EQ(plan.exit_code, 1) << plan.out;
  EXPECT_EQ(plan.out, "");
  EXPECT_NE(plan.err.find("exists already"), std::string::npos) << plan.err;
  EXPECT_EQ(plan.err, run.err);
  EXPECT_EQ(Block({"--plan", "--resume"}).exit_code, 0);
}

TEST_F(ChangedBlock, RowsForPhotosThatAreNotThereAreNamed) {
  OrientationTable table = ReadOrientationTable(Path("approx.csv"));
  for (const char* name : {"ghost", "phantom"}) {
    table.rows.push_back(table.rows[0]);
    table.rows.back().photo = name;
  }
  WriteOrientationTable(Path("approx.csv"), table);
  const ProgramRun run = Block();
  EXPECT_EQ(run.exit_code, 3) << run.out << run.err;
  EXPECT_NE(run.out.find(Path("approx.csv") +
                         " lists 2 photos that are not in the block: ghost, phantom"),
            std::string::npos)
      << run.out;
}

TEST_F(ChangedBlock, WhatIsDoneAgainIsNamedWithTheReason) {
  ASSERT_EQ(Block().exit_code, 0);
  EXPECT_EQ(Block({"--resume"}).out.find("oriented again"), std::string::npos);
  OrientationTable table = ReadOrientationTable(Path("approx.csv"));
  table.rows[1].pose.position_m.x() += 1;
  WriteOrientationTable(Path("approx.csv"), table);
  const std::string said = Block({"--resume"}).out;
  EXPECT_NE(said.find("oriented again, as their inputs changed (approximation): " +
                      table.rows[1].photo + "\n"),
            std::string::npos)
      << said;
}

// GNSS locates the photos, and its heights above the ellipsoid are no matter: the shift holds them.
TEST_F(ChangedBlock, GnssLocatesPhotosAndIsObserved) {
  OrientationTable truth = ReadOrientationTable(Path("truth/orientation.csv"));
  std::string table = "filename,x,y,z\n";
  for (const OrientationRow& row : truth.rows) {
    const Eigen::Vector3d& place = row.pose.position_m;
    table += fmt::format("{},{:.3f},{:.3f},{:.3f}\n", row.photo, place.x() + 0.4, place.y() - 0.3,
                         place.z() + 20);
  }
  Write("gnss.csv", table);
  Edit("block.toml", "approximations = \"approx.csv\"\n", "");
  Write("block.toml",
        ReadFile(Path("block.toml")) + "\n[gnss]\npositions = \"gnss.csv\"\nsigma_m = 0.1\n");
  const ProgramRun run = Block();
  EXPECT_EQ(run.exit_code, 0) << run.out << run.err;
  const AdjustmentResult adjusted = ReadAdjustmentResult(AdjustmentResultPath(Path("out")));
  ASSERT_EQ(adjusted.gnss.size(), 2u);
  for (const PoseObservationResult& position : adjusted.gnss) {
    EXPECT_EQ(position.state, "used");
    EXPECT_LT(position.residual_m.value().norm(), 0.3);
  }
  ASSERT_EQ(adjusted.gnss_strips.size(), 1u);
  const Eigen::Vector3d off = *adjusted.gnss_strips[0].shift_m - Eigen::Vector3d(0.4, -0.3, 20);
  for (int i = 0; i < 3; ++i)
    EXPECT_LT(std::abs(off[i]), 4 * (*adjusted.gnss_strips[0].shift_sigma_m)[i]) << i;
  EXPECT_TRUE(adjusted.approximations.empty());
  EXPECT_NE(ReadFile(Path("out/report.html")).find("<h3>GNSS</h3>"), std::string::npos);
}

TEST_F(ChangedBlock, HeldOutPatchesCheckItAndItsPosesAreSaidToErrTogether) {
  const std::string usual = ReadFile(Path("block.toml"));
  Write("block.toml", usual + "\n[block]\ncheck_share = 0.3\npose_covariance = true\n");
  const ProgramRun run = Block();
  ASSERT_EQ(run.exit_code, 0) << run.out << run.err;
  EXPECT_NE(run.out.find("patches or points held out, RMS "), std::string::npos) << run.out;
  const AdjustmentResult adjusted = ReadAdjustmentResult(AdjustmentResultPath(Path("out")));
  EXPECT_GT(adjusted.checks.size(), 10u);
  EXPECT_LT(adjusted.CheckRmsPx().value(), 0.5);
  std::istringstream table(ReadFile(Path("out/pose_covariance.csv")));
  std::string line;
  std::getline(table, line);
  EXPECT_EQ(line.rfind("filename,element,new_1_1.x,new_1_1.y,", 0), 0u) << line;
  for (const char* photo : {"new_1_1", "new_1_2"}) {
    const ExteriorResult result = ReadExteriorResult(ExteriorResultPath(Path("out"), photo));
    for (Eigen::Index i = 0; i < 6; ++i) {
      ASSERT_TRUE(std::getline(table, line));
      std::vector<std::string> cells;
      std::istringstream row(line);
      for (std::string cell; std::getline(row, cell, ',');) cells.push_back(cell);
      ASSERT_EQ(cells.size(), 14u) << line;
      EXPECT_EQ(cells[0], photo);
      const Eigen::Index own = 2 + i + (photo == std::string("new_1_2") ? 6 : 0);
      const double variance = (*result.covariance)(i, i);
      EXPECT_NEAR(std::stod(cells[static_cast<std::size_t>(own)]), variance, 1e-6 * variance);
    }
  }
  Write("block.toml", usual);
  ASSERT_EQ(Block({"--resume"}).exit_code, 0);
  EXPECT_FALSE(fs::exists(Path("out/pose_covariance.csv")));
}

TEST_F(BadInput, ApproximationsOfNoStatedAccuracyCannotBeObserved) {
  Edit("block.toml", "position_m = 3\nattitude_deg = 0.5\n", "observe = true\n");
  ExpectRefused(Block(), 2, {"observe", "[approximate_accuracy]", "is not stated"});
}

TEST_F(BadInput, WithoutAnythingThatLocatesAPhotoThereIsNothingToDo) {
  Edit("block.toml", "approximations = \"approx.csv\"\n", "");
  ExpectRefused(Block(), 2, {"EXIF", "give a table of approximations"});
  Write("block.toml", ReadFile(Path("block.toml")) + "[[strips]]\nphotos = [\"new_*\"]\n");
  ExpectRefused(Block(), 2,
                {"strip 1", "new_1_1, new_1_2", "located", "give the position of one photo"});
}

// Digital photos in a row, each 890 x 667 px.
class SlowBadBlock : public testing::Test {
 protected:
  void Make(int photos, int strips) {
    SimulationOptions options;
    options.camera = CameraPreset::kDigital;
    options.photos = photos;
    options.strips = strips;
    options.gsd_m = 0.75;
    options.pixel_size_um = 60;
    options.objects = false;
    options.position_error_m = 3;
    options.attitude_error_deg = 0.5;
    Simulate(options, block_);
    HarvestOldPhotos(block_, Path("patches.gpkg"), 150);
  }
  std::string Path(const std::string& name) const { return block_ + "/" + name; }
  ProgramRun Block() const { return RunOrient({"block", Path("block.toml"), "--no-feedback"}); }
  ExteriorResult Result(const std::string& photo) const {
    return ReadExteriorResult(ExteriorResultPath(Path("out"), photo));
  }
  // Takes all patches east of the middle between two photos out of use.
  void RetireEastOf(const std::string& photo, const std::string& next) const {
    const OrientationTable truth = ReadOrientationTable(Path("truth/orientation.csv"));
    const double x =
        (truth.Find(photo)->pose.position_m.x() + truth.Find(next)->pose.position_m.x()) / 2;
    const ProgramRun run = RunOrient({"patchdb", "retire", Path("patches.gpkg"), "--apply", "--box",
                                      std::to_string(x), "0", "1000000", "10000000"});
    ASSERT_EQ(run.exit_code, 0) << run.err;
  }

  const TemporaryFolder folder_;
  const std::string block_ = folder_ / "block";
};

TEST_F(SlowBadBlock, OfTwoPartsTheOneWithoutControlFailsAndIsNamed) {
  Make(6, 1);
  for (const char* photo : {"new_1_3", "new_1_4"})
    fs::remove(Path("scans/" + std::string(photo) + ".tif"));
  const ProgramRun whole = Block();
  EXPECT_EQ(whole.exit_code, 3) << whole.out << whole.err;  // two scans are missing
  EXPECT_NE(whole.out.find("Photos new_1_1 and new_1_2 are not connected to the rest of the block"),
            std::string::npos)
      << whole.out;
  RetireEastOf("new_1_3", "new_1_4");
  fs::remove_all(Path("out"));
  const ProgramRun run = Block();
  std::printf("%s", run.out.c_str());
  EXPECT_EQ(run.exit_code, 3) << run.out << run.err;
  for (const char* photo : {"new_1_1", "new_1_2"})
    EXPECT_EQ(Result(photo).status, Status::kOk) << photo;
  const ExteriorResult last = Result("new_1_6");
  EXPECT_EQ(last.status, Status::kFailed);
  EXPECT_FALSE(last.pose);
  ASSERT_FALSE(last.findings.empty());
  EXPECT_NE(run.out.find(Sentence(last.findings.at(0))), std::string::npos) << run.out;
}

// Clouds, water: photos of one grey value.
TEST_F(SlowBadBlock, AStripWithoutAnyPatchOrTieFailsAndTheOthersAreDone) {
  Make(6, 2);
  for (const char* photo : {"new_2_1", "new_2_2", "new_2_3"}) {
    const std::string path = Path("scans/" + std::string(photo) + ".tif");
    simulation::WriteGreyTiff(path, 890, 667, std::vector<std::uint16_t>(890 * 667, 128), 8,
                              std::nullopt, std::nullopt);
  }
  const ProgramRun run = Block();
  std::printf("%s", run.out.c_str());
  EXPECT_EQ(run.exit_code, 3) << run.out << run.err;
  for (const char* photo : {"new_1_1", "new_1_2", "new_1_3"})
    EXPECT_EQ(Result(photo).status, Status::kOk) << photo;
  for (const char* photo : {"new_2_1", "new_2_2", "new_2_3"}) {
    const ExteriorResult failed = Result(photo);
    EXPECT_EQ(failed.status, Status::kFailed) << photo;
    ASSERT_FALSE(failed.findings.empty());
    EXPECT_NE(run.out.find(Sentence(failed.findings.at(0))), std::string::npos) << run.out;
  }
  EXPECT_EQ(ReadOrientationTable(Path("out/orientation.csv")).rows.size(), 3u);
}

TEST_F(SlowBadBlock, ADamagedFilmScanIsNamedAndTheOthersAreDone) {
  SimulationOptions options;
  options.photos = 3;
  options.gsd_m = 0.75;
  options.pixel_size_um = 75;
  options.objects = false;
  options.position_error_m = 3;
  options.attitude_error_deg = 0.5;
  Simulate(options, block_);
  HarvestOldPhotos(block_, Path("patches.gpkg"), 150);
  const std::string path = Path("scans/new_1_2.tif");
  fs::resize_file(path, fs::file_size(path) / 2);
  const ProgramRun run = Block();
  std::printf("%s", run.out.c_str());
  EXPECT_EQ(run.exit_code, 3) << run.out << run.err;
  EXPECT_EQ(Result("new_1_1").status, Status::kOk);
  EXPECT_EQ(Result("new_1_3").status, Status::kOk);
  const ExteriorResult damaged = Result("new_1_2");
  EXPECT_EQ(damaged.status, Status::kFailed);
  ASSERT_FALSE(damaged.findings.empty());
  EXPECT_NE(Sentence(damaged.findings.at(0)).find("new_1_2"), std::string::npos)
      << Sentence(damaged.findings.at(0));
}

}  // namespace
}  // namespace orient
