#include "block/inputs/block_camera.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "core/base/error.h"
#include "core/geometry/lens.h"
#include "tests/support/example_camera.h"
#include "tests/support/expect_error.h"
#include "tests/support/shared_data.h"

namespace orient::block {
namespace {
namespace fs = std::filesystem;

TEST(BlockCamera, IsRefusedByWhateverNameWhereCurvatureMayBeAddedAgain) {
  const TemporaryFolder folder;
  CameraFile curved = ExampleCamera();
  curved.camera = WithEarth(curved.camera, 1e-7);
  WriteBlockCamera(folder.Path(), curved);
  fs::copy(BlockCameraPath(folder.Path()), folder / "camera.toml");
  for (const std::string& path : {BlockCameraPath(folder.Path()), folder / "camera.toml"}) {
    ExpectError<UsageError>([&] { RefuseBlockCamera(path, EarthMode::kAuto); },
                            {path, "in its lens already", "--earth flat"});
    EXPECT_NO_THROW(RefuseBlockCamera(path, EarthMode::kFlat));
  }
  WriteCameraFile(folder / "own.toml", ExampleCamera());
  EXPECT_NO_THROW(RefuseBlockCamera(folder / "own.toml", EarthMode::kAuto));
}

TEST(BlockCamera, IsTheOneThatItsTablesPosesNeed) {
  const TemporaryFolder folder;
  const std::string table = folder / "orientation.csv";
  WriteCameraFile(folder / "own.toml", ExampleCamera());
  EXPECT_NO_THROW(RequireCameraOfPoses(folder / "own.toml", table)) << "nothing says another";
  WriteBlockCamera(folder.Path(), ExampleCamera());
  EXPECT_NO_THROW(RequireCameraOfPoses(folder / "own.toml", table)) << "the same";
  CameraFile calibrated = ExampleCamera();
  calibrated.camera.principal_distance_mm = 100.2;
  WriteBlockCamera(folder.Path(), calibrated);
  ExpectError<UsageError>([&] { RequireCameraOfPoses(folder / "own.toml", table); },
                          {table, BlockCameraPath(folder.Path()), "--earth flat"});
  EXPECT_NO_THROW(RequireCameraOfPoses(BlockCameraPath(folder.Path()), table));
}

}  // namespace
}  // namespace orient::block
