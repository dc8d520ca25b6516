#include "tools/block/block_photos.h"

#include <gtest/gtest.h>

#include "core/error.h"
#include "core/files/atomic_write.h"
#include "core/files/orientation_table.h"
#include "tests/support/shared_data.h"
#include "tools/block/stage_folder.h"
#include "tools/simulate/geotiff.h"

namespace orient {
namespace {

BlockPhotoFile PhotoAt(const std::string& path) {
  BlockPhotoFile photo;
  photo.name = PhotoName(path);
  photo.path = path;
  photo.exterior.pose = Pose{};
  photo.exterior.covariance = Matrix6d::Identity();
  return photo;
}

TEST(OpenPhotos, ADamagedNeighbourIsLeftOutADamagedOwnerIsNot) {
  const TemporaryFolder folder;
  for (const char* name : {"a.tif", "c.tif"})
    simulation::WriteGreyTiff(folder / name, 64, 64, std::vector<std::uint16_t>(64 * 64, 7), 8, {},
                              {});
  WriteFileAtomically(folder / "b.tif", "no picture at all");
  const std::vector<BlockPhotoFile> photos = {PhotoAt(folder / "a.tif"), PhotoAt(folder / "b.tif"),
                                              PhotoAt(folder / "c.tif")};
  const OpenPhotos open(photos, {0, 1, 2}, 2, Camera{});
  ASSERT_EQ(open.Photos().size(), 2u);
  EXPECT_EQ(open.Photos()[open.Owner()].name, "c");
  EXPECT_THROW(OpenPhotos(photos, {0, 1, 2}, 1, Camera{}), InputError);
}

TEST(ReadBlockPhoto, KnowsWhatItsResultWasMadeFrom) {
  const TemporaryFolder folder;
  const StageFolder stage(folder / "", ".exterior.json");
  ExteriorResult failed;
  failed.photo = "a";
  WriteExteriorResult(folder / "", failed);
  const CameraFile camera;
  const auto made_from = [&] {
    return ReadBlockPhoto(folder / "a.tif", stage.ResultPath("a"), camera, {}, "").made_from;
  };
  EXPECT_EQ(made_from(), "");
  stage.Note("a", "one");
  const std::string one = made_from();
  stage.Note("a", "two");
  EXPECT_NE(made_from(), one);
}

}  // namespace
}  // namespace orient
