// Input that reads well and is wrong: a photo ends in a clear state and says what may be wrong, and
// is never `ok` with another pose.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/base/atomic_write.h"
#include "core/files/orientation_table.h"
#include "core/raster/raster.h"
#include "core/terrain/ground_surface.h"
#include "patchdb/store/patch_database.h"
#include "tests/end_to_end/simulated_block.h"
#include "tests/support/run_orient.h"
#include "tests/support/shared_data.h"
#include "tools/simulate/geotiff.h"

namespace orient {
namespace {

// One block for all cases: every case has its own copies of what is wrong in it.
class WrongInput : public testing::Test {
 protected:
  WrongInput() {
    SimulationOptions options;
    options.camera = CameraPreset::kDigital;
    options.photos = 1;
    options.gsd_m = 0.75;
    options.pixel_size_um = 60;  // 890 x 667 px
    options.objects = false;
    options.position_error_m = 3;
    options.attitude_error_deg = 0.5;
    Simulate(options, block_);
    HarvestOldPhotos(block_, block_ + "/patches.gpkg", 150);
    Restore();
  }

  void Restore() {
    photo_ = block_ + "/scans/new_1_1.tif";
    camera_ = block_ + "/camera.toml";
    approximations_ = block_ + "/approx.csv";
    dem_ = block_ + "/dem.tif";
    patches_ = block_ + "/patches.gpkg";
  }

  ExteriorResult Orient(const std::vector<std::string>& more = {}) {
    std::vector<std::string> command = {"exterior",
                                        photo_,
                                        "--camera",
                                        camera_,
                                        "--approximations",
                                        approximations_,
                                        "--dem",
                                        dem_,
                                        "--patchdb",
                                        patches_,
                                        "--out",
                                        folder_ / "out",
                                        "--overwrite",
                                        "--no-feedback",
                                        "--position-sigma-m",
                                        "3",
                                        "--attitude-sigma-deg",
                                        "0.5"};
    command.insert(command.end(), more.begin(), more.end());
    const ProgramRun run = RunOrient(command);
    EXPECT_NE(run.exit_code, 2) << run.err;
    ExteriorResult result = ReadExteriorResult(ExteriorResultPath(folder_ / "out", "new_1_1"));
    Restore();
    return result;
  }

  void MakeDistanceLonger(double factor) {
    CameraFile camera = ReadCameraFile(camera_);
    camera.camera.principal_distance_mm *= factor;
    camera_ = folder_ / "camera.toml";
    WriteCameraFile(camera_, camera);
  }

  static void ExpectSaid(const ExteriorResult& result, const std::string& words) {
    std::string said;
    for (const std::string& message : Sentences(result.findings)) said += message + "\n";
    EXPECT_NE(said.find(words), std::string::npos) << said << "lacks: " << words;
  }

  // A grey picture in the photo's place, of its size and name.
  void TakePhoto(double (*grey)(double col, double row)) {
    const Raster real = Raster::Open(photo_);
    std::vector<std::uint16_t> values;
    for (int row = 0; row < real.Height(); ++row)
      for (int col = 0; col < real.Width(); ++col)
        values.push_back(static_cast<std::uint16_t>(std::lround(grey(col, row))));
    photo_ = folder_ / "new_1_1.tif";
    simulation::WriteGreyTiff(photo_, real.Width(), real.Height(), values, 8, std::nullopt,
                              std::nullopt);
  }

  // The heights changed by a function of easting.
  void ChangeHeights(float (*change)(float height, double share)) {
    const Crs crs = Crs::Parse("EPSG:32635", "test");
    const GroundSurface surface = GroundSurface::FromFile(dem_, crs);
    const Bounds extent = surface.Extent();
    const double cell = surface.CellSize();
    const int width = static_cast<int>((extent.max_x - extent.min_x) / cell);
    const int height = static_cast<int>((extent.max_y - extent.min_y) / cell);
    std::vector<float> heights;
    for (int row = 0; row < height; ++row)
      for (int col = 0; col < width; ++col) {
        const auto at =
            surface.HeightAt(extent.min_x + (col + 0.5) * cell, extent.max_y - (row + 0.5) * cell);
        heights.push_back(
            change(static_cast<float>(at.value_or(std::nan(""))), (col + 0.5) / width));
      }
    dem_ = folder_ / "dem.tif";
    simulation::WriteFloatTiff(dem_, width, height, heights,
                               {extent.min_x, extent.max_y, cell, crs});
  }

  // Every patch shows what another one showed: as if the whole scene had changed.
  void ChangeScene() {
    const patchdb::PatchDatabase known =
        patchdb::PatchDatabase::Open(patches_, patchdb::PatchDatabase::Mode::kRead);
    std::vector<patchdb::Patch> patches = known.ListPatches(0, std::numeric_limits<int>::max());
    std::vector<Image> chips;
    for (const patchdb::Patch& patch : patches) chips.push_back(patch.chip);
    for (std::size_t i = 0; i < patches.size(); ++i) {
      patches[i].id = patches[i].source_id = 0;
      patches[i].chip = chips[(i + chips.size() / 2) % chips.size()];
    }
    patchdb::PatchSource source;
    source.name = "another scene";
    source.gsd_m = patches.front().gsd_m;
    patches_ = folder_ / "changed.gpkg";
    patchdb::PatchDatabase::Create(patches_, known.GroundCrs()).AddSource(source, patches);
  }

  TemporaryFolder folder_;
  std::string block_ = folder_ / "block";
  std::string photo_, camera_, approximations_, dem_, patches_;
};

using SlowWrongInput = WrongInput;

TEST_F(SlowWrongInput, EndsInAClearStateAndSaysWhatMayBeWrong) {
  EXPECT_EQ(Orient().status, Status::kOk);  // nothing is wrong yet

  TakePhoto([](double col, double row) {
    return 200 + 20 * std::sin(col / 37) * std::cos(row / 51 + col / 90);
  });
  const ExteriorResult clouds = Orient();
  EXPECT_EQ(clouds.status, Status::kFailed);
  EXPECT_FALSE(clouds.pose);
  ExpectSaid(clouds, "the search of the whole photo");

  ChangeScene();
  const ExteriorResult changed = Orient();
  EXPECT_EQ(changed.status, Status::kFailed);
  ExpectSaid(changed, "the scene has changed");

  ChangeHeights([](float height, double) { return height + 50; });
  const ExteriorResult raised = Orient();
  EXPECT_EQ(raised.status, Status::kWeak);
  ExpectSaid(raised, "the DEM lies 50 m above the matched patches");

  ChangeHeights([](float height, double share) { return share > 0.5 ? std::nanf("") : height; });
  ExpectSaid(Orient(), "the DEM has no height under");

  OrientationTable table = ReadOrientationTable(approximations_);
  for (OrientationRow& row : table.rows) row.pose.position_m.x() += 400;
  approximations_ = folder_ / "approx.csv";
  WriteOrientationTable(approximations_, table);
  const ExteriorResult elsewhere = Orient();
  EXPECT_NE(elsewhere.status, Status::kOk);
  ExpectSaid(elsewhere, "sigma from its approximation");

  MakeDistanceLonger(1.25);
  const ExteriorResult of_another_camera = Orient();
  EXPECT_NE(of_another_camera.status, Status::kOk);
  ExpectSaid(of_another_camera, "sigma from its approximation");
}

// Where the camera is trusted, its error goes into the flying height, and no sigma holds it.
TEST_F(WrongInput, APrincipalDistanceThatIsDoubtedDoesNotMakeThePoseWrong) {
  const Pose truth = ReadOrientationTable(block_ + "/truth/orientation.csv").rows.front().pose;
  const double true_mm = ReadCameraFile(camera_).camera.principal_distance_mm;
  MakeDistanceLonger(1.005);
  const std::string longer = camera_;
  const ExteriorResult trusted = Orient();
  ASSERT_TRUE(trusted.pose);
  EXPECT_GT(std::abs(trusted.pose->position_m.z() - truth.position_m.z()),
            4 * std::sqrt((*trusted.covariance)(2, 2)));
  camera_ = longer;
  const ExteriorResult result =
      Orient({"--principal-distance-sigma-mm", std::to_string(0.005 * true_mm)});
  ASSERT_TRUE(result.pose && result.principal_distance);
  EXPECT_LT(std::abs(result.principal_distance->value_mm - true_mm),
            3 * result.principal_distance->sigma_mm);
  const Vector6d off = PoseDifference(*result.pose, truth);
  const Vector6d sigma = result.covariance->diagonal().cwiseSqrt();
  for (int i = 0; i < 6; ++i) EXPECT_LT(std::abs(off[i]), 3.5 * sigma[i]) << i;
  ExpectSaid(result, "the pose was computed with a principal distance of");
}

}  // namespace
}  // namespace orient
