// Photos of which nothing or something wrong is known, found by keypoints that they share with
// photos that are oriented.
#include <gtest/gtest.h>

#include <filesystem>

#include "core/files/orientation_table.h"
#include "core/geometry/rotation.h"
#include "tests/end_to_end/simulated_block.h"
#include "tests/support/run_orient.h"
#include "tests/support/shared_data.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

SimulationOptions SixDigitalPhotos() {
  SimulationOptions options;
  options.camera = CameraPreset::kDigital;
  options.photos = 6;
  options.strips = 1;
  options.gsd_m = 0.75;
  options.pixel_size_um = 60;
  options.objects = false;
  options.position_error_m = 3;
  options.attitude_error_deg = 0.5;
  return options;
}

// One photo loses its row, another one is said to be three flying heights away.
void SpoilTable(const std::string& block, const std::string& unknown, const std::string& wrong) {
  OrientationTable table = ReadOrientationTable(block + "/approx.csv");
  std::erase_if(table.rows, [&](const OrientationRow& row) { return row.photo == unknown; });
  for (OrientationRow& row : table.rows) {
    if (row.photo != wrong) continue;
    row.pose.position_m.y() += 3 * row.pose.position_m.z();
    row.pose.opk_rad.z() = NormalizeAngle(row.pose.opk_rad.z() + RadFromDeg(137));
  }
  WriteOrientationTable(block + "/approx.csv", table);
}

TEST(SlowKeypointBlock, FindsPhotosWithoutApproximationAndNoneOfAnotherPlace) {
  const TemporaryFolder folder;
  const std::string block = folder / "block";
  Simulate(SixDigitalPhotos(), block);
  HarvestOldPhotos(block, block + "/patches.gpkg", 150);
  SpoilTable(block, "new_1_3", "new_1_5");
  SimulationOptions elsewhere = SixDigitalPhotos();
  elsewhere.photos = 2;
  elsewhere.seed = 77;
  Simulate(elsewhere, folder / "elsewhere");
  fs::copy_file(folder / "elsewhere/scans/new_1_2.tif", block + "/scans/new_1_9.tif");
  const ProgramRun run = RunOrient({"block", block + "/block.toml", "--no-feedback"});
  std::printf("%s%s", run.out.c_str(), run.err.c_str());
  EXPECT_EQ(run.exit_code, 3);
  const OrientationTable truth = ReadOrientationTable(block + "/truth/orientation.csv");
  const auto result = [&](const std::string& photo) {
    return ReadExteriorResult(ExteriorResultPath(block + "/out", photo));
  };
  for (const char* photo : {"new_1_3", "new_1_5"}) {
    const ExteriorResult found = result(photo);
    ASSERT_TRUE(found.pose) << photo << testing::PrintToString(Sentences(found.findings));
    const Vector6d off = PoseDifference(*found.pose, truth.Find(photo)->pose);
    EXPECT_LT(off.head<3>().norm(), 1.5) << photo;
    EXPECT_LT(off.dot(found.covariance->ldlt().solve(off)), 27.9) << photo;
    EXPECT_NE(JoinedSentences(found.findings).find("keypoints"), std::string::npos)
        << JoinedSentences(found.findings);
  }
  // Nobody said where the one lies; the other one is not where it is said to be.
  EXPECT_EQ(result("new_1_3").status, Status::kOk);
  EXPECT_EQ(result("new_1_5").status, Status::kWeak);
  EXPECT_EQ(result("new_1_9").status, Status::kFailed);
  EXPECT_FALSE(result("new_1_9").pose);
  EXPECT_EQ(run.out.find("could not be tried"), std::string::npos);
}

}  // namespace
}  // namespace orient
