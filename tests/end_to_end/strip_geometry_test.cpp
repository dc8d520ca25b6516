// Blocks of which nothing is known but the order of strips and photos, and where one photo was.
#include <gtest/gtest.h>

#include "core/base/atomic_write.h"
#include "core/files/orientation_table.h"
#include "tests/end_to_end/simulated_block.h"
#include "tests/support/run_orient.h"
#include "tests/support/shared_data.h"

namespace orient {
namespace {

// The table with one row left, that of `photo`, as `name`.csv.
void LocateOnly(const std::string& block, const std::string& photo) {
  OrientationTable table = ReadOrientationTable(block + "/approx.csv");
  std::erase_if(table.rows, [&](const OrientationRow& row) { return row.photo != photo; });
  ASSERT_EQ(table.rows.size(), 1u);
  WriteOrientationTable(block + "/approx.csv", table);
}

// In the simulator's blocks strips lie north of one another and photos are numbered to the east,
// whichever way they were flown.
void AddStrips(const std::string& block, int strips) {
  std::string text = ReadFile(block + "/block.toml") + "\n[flight]\nnext_strip = \"north\"\n";
  for (int strip = 1; strip <= strips; ++strip)
    text += "[[strips]]\nphotos = [\"new_" + std::to_string(strip) +
            "_*\"]\nreversed = " + (strip % 2 == 0 ? "true\n" : "false\n");
  WriteFileAtomically(block + "/block.toml", text);
}

void ExpectAllOriented(const std::string& block, double most_m) {
  const OrientationTable truth = ReadOrientationTable(block + "/truth/orientation.csv");
  for (const OrientationRow& photo : truth.rows) {
    const ExteriorResult result =
        ReadExteriorResult(ExteriorResultPath(block + "/out", photo.photo));
    EXPECT_EQ(result.status, Status::kOk)
        << photo.photo << testing::PrintToString(Sentences(result.findings));
    ASSERT_TRUE(result.pose) << photo.photo;
    EXPECT_LT((result.pose->position_m - photo.pose.position_m).norm(), most_m) << photo.photo;
  }
}

TEST(SlowStripGeometry, OneLocatedPhotoLocatesTwoStripsOfDigitalPhotos) {
  const TemporaryFolder folder;
  const std::string block = folder / "block";
  SimulationOptions options;
  options.camera = CameraPreset::kDigital;
  options.photos = 8;
  options.strips = 2;
  options.gsd_m = 0.75;
  options.pixel_size_um = 60;
  options.objects = false;
  options.position_error_m = 3;
  options.attitude_error_deg = 0.5;
  Simulate(options, block);
  HarvestOldPhotos(block, block + "/patches.gpkg", 150);
  LocateOnly(block, "new_1_2");
  AddStrips(block, 2);
  const ProgramRun run = RunOrient({"block", block + "/block.toml", "--no-feedback"});
  std::printf("%s", run.out.c_str());
  EXPECT_EQ(run.exit_code, 0) << run.out << run.err;
  ExpectAllOriented(block, 2);
  // Nothing is left to do, and what was done is known although it depends on one another.
  const ProgramRun plan =
      RunOrient({"block", block + "/block.toml", "--no-feedback", "--plan", "--resume"});
  EXPECT_EQ(plan.out.find("do    exterior"), std::string::npos) << plan.out;
}

TEST(SlowStripGeometry, OneLocatedPhotoLocatesThreeStripsOfFilm) {
  const TemporaryFolder folder;
  const std::string block = folder / "block";
  SimulationOptions options;
  options.photos = 15;
  options.strips = 3;
  options.seed = 3;
  options.gsd_m = 0.5;
  options.pixel_size_um = 50;
  options.position_error_m = 5;
  options.attitude_error_deg = 0.5;
  Simulate(options, block);
  HarvestOldPhotos(block, block + "/patches.gpkg");
  LocateOnly(block, "new_2_3");
  AddStrips(block, 3);
  const ProgramRun run = RunOrient({"block", block + "/block.toml", "--no-feedback"});
  std::printf("%s", run.out.c_str());
  EXPECT_EQ(run.exit_code, 0) << run.out << run.err;
  ExpectAllOriented(block, 2);
}

}  // namespace
}  // namespace orient
