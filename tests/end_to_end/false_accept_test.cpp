// Patches that do not show the photo's place: nothing may be called oriented by them.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <functional>
#include <limits>
#include <numbers>
#include <random>

#include "core/files/orientation_table.h"
#include "patchdb/store/patch_database.h"
#include "tests/end_to_end/simulated_block.h"
#include "tests/support/ngi.h"
#include "tests/support/run_orient.h"
#include "tests/support/shared_data.h"

namespace orient {
namespace {

constexpr double kShift_m = 500;  // about 86 px

using Shift = std::function<Eigen::Vector2d()>;

// The patches of one database in a new one, each moved.
void StoreShifted(const std::string& from, const std::string& to, const Shift& shift) {
  const patchdb::PatchDatabase known =
      patchdb::PatchDatabase::Open(from, patchdb::PatchDatabase::Mode::kRead);
  std::vector<patchdb::Patch> patches = known.ListPatches(0, std::numeric_limits<int>::max());
  ASSERT_GT(patches.size(), 100u);
  for (patchdb::Patch& patch : patches) {
    patch.id = patch.source_id = 0;
    patch.ground_m.head<2>() += shift();
  }
  patchdb::PatchSource source;
  source.name = "another place";
  source.gsd_m = patches.front().gsd_m;
  patchdb::PatchDatabase::Create(to, known.GroundCrs()).AddSource(source, patches);
}

// 500 m each, every patch in a direction of its own.
Shift EachElsewhere(unsigned seed) {
  return [random = std::mt19937(seed)]() mutable -> Eigen::Vector2d {
    const double angle = 2 * std::numbers::pi * static_cast<double>(random()) / 4294967296.0;
    return kShift_m * Eigen::Vector2d(std::cos(angle), std::sin(angle));
  };
}

// Photos 0251 and 0253 of strip 06 and patches of the orthophotos of strip 05.
class OtherPlace {
 public:
  explicit OtherPlace(const std::string& data) : ngi_(data) {
    Run({"patchdb", "create", folder_ / "true.gpkg", "--crs", ngi_.CrsFile()});
    Run({"patchdb", "harvest-ortho", folder_ / "true.gpkg", "--dem", ngi_.folder + "/dem.tif",
         "--ortho", ngi_.Orthophoto("0182"), ngi_.Orthophoto("0184")});
  }

  // Orients both photos by shifted patches.
  ProgramRun Orient(const Shift& shift, double position_sigma_m, double attitude_sigma_deg,
                    double error_m, double error_deg, unsigned signs = 0x5a3c96e1) {
    const std::string database = folder_ / ("shifted_" + std::to_string(++databases_) + ".gpkg");
    StoreShifted(folder_ / "true.gpkg", database, shift);
    ngi_.WriteApproximations(folder_ / "approx.csv", error_m, error_deg, signs);
    return RunOrient({"exterior", ngi_.Photo("0251"), ngi_.Photo("0253"), "--camera",
                      ngi_.folder + "/camera.toml", "--approximations", folder_ / "approx.csv",
                      "--dem", ngi_.folder + "/dem.tif", "--patchdb", database, "--out",
                      folder_ / "out", "--overwrite", "--no-feedback", "--position-sigma-m",
                      std::to_string(position_sigma_m), "--attitude-sigma-deg",
                      std::to_string(attitude_sigma_deg)});
  }

  ExteriorResult Result(const std::string& number) const {
    return ReadExteriorResult(ExteriorResultPath(folder_ / "out", PhotoName(ngi_.Photo(number))));
  }

  void ExpectNothingFound(unsigned seed) {
    const ProgramRun run = Orient(EachElsewhere(seed), 150, 2, 150, 2, seed * 2654435761u);
    EXPECT_EQ(run.exit_code, 3) << "seed " << seed << "\n" << run.out << run.err;
    for (const char* number : {"0251", "0253"}) {
      const ExteriorResult result = Result(number);
      EXPECT_EQ(result.status, Status::kFailed) << "seed " << seed << ", photo " << number;
      EXPECT_FALSE(result.pose.has_value());
      ASSERT_FALSE(result.findings.empty());
      std::printf("seed %u, %s: %s\n", seed, number, Sentence(result.findings.at(0)).c_str());
    }
  }

 private:
  static void Run(const std::vector<std::string>& arguments) {
    const ProgramRun run = RunOrient(arguments);
    ASSERT_EQ(run.exit_code, 0) << run.err;
  }

  Ngi ngi_;
  TemporaryFolder folder_;
  int databases_ = 0;
};

TEST(SlowFalseAccept, PatchesShiftedAtRandomOrientNoPhotoWhateverTheSeed) {
  ORIENT_REQUIRE_SHARED_DATA(data, "ngi");
  OtherPlace place(data);
  for (unsigned seed = 1; seed <= 11; ++seed) place.ExpectNothingFound(seed);
}

// All patches agree with one another here, on a pose that is wrong by 500 m: only the stated
// accuracy of the approximation tells.
TEST(FalseAccept, PatchesShiftedTogetherContradictAStatedPosition) {
  ORIENT_REQUIRE_SHARED_DATA(data, "ngi");
  OtherPlace place(data);
  const ProgramRun run = place.Orient([] { return Eigen::Vector2d(300, -400); }, 10, 0.2, 5, 0.1);
  EXPECT_NE(run.exit_code, 2) << run.err;
  for (const char* number : {"0251", "0253"}) {
    const ExteriorResult result = place.Result(number);
    EXPECT_NE(result.status, Status::kOk) << number;
    ASSERT_FALSE(result.findings.empty());
    std::printf("%s: %s: %s\n", number, std::string(Name(result.status)).c_str(),
                Sentence(result.findings.at(0)).c_str());
  }
}

// The same coordinates and heights, but another scene.
TEST(SlowFalseAccept, ASimulatedPhotoFindsNothingInThePatchesOfAnotherPlace) {
  const TemporaryFolder folder;
  SimulationOptions options;
  options.camera = CameraPreset::kDigital;
  options.photos = 1;
  options.gsd_m = 0.75;
  options.pixel_size_um = 60;
  options.seed = 5;
  Simulate(options, folder / "here");
  options.seed = 6;
  Simulate(options, folder / "elsewhere");
  HarvestOldPhotos(folder / "elsewhere", folder / "elsewhere/patches.gpkg");
  const ProgramRun run =
      RunOrient({"exterior", folder / "here/scans/*.tif", "--camera", folder / "here/camera.toml",
                 "--approximations", folder / "here/approx.csv", "--dem", folder / "here/dem.tif",
                 "--patchdb", folder / "elsewhere/patches.gpkg", "--out", folder / "out"});
  EXPECT_EQ(run.exit_code, 3) << run.out << run.err;
  const ExteriorResult result = ReadExteriorResult(ExteriorResultPath(folder / "out", "new_1_1"));
  EXPECT_EQ(result.status, Status::kFailed);
  EXPECT_FALSE(result.pose.has_value());
}

}  // namespace
}  // namespace orient
