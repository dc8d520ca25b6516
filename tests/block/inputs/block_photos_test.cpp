#include "block/inputs/block_photos.h"

#include <gtest/gtest.h>

#include "core/base/atomic_write.h"
#include "core/base/error.h"
#include "core/files/orientation_table.h"
#include "tests/support/shared_data.h"
#include "tools/simulate/geotiff.h"

namespace orient::block {
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

TEST(DigestOfPhoto, ChangesWithItsResultAndWhatThatWasMadeFrom) {
  const TemporaryFolder folder;
  ExteriorResult result;
  result.photo = "a";
  const auto digest = [&] {
    WriteExteriorResult(folder.Path(), result);
    const CameraFile camera;
    return DigestOfPhoto(
        ReadBlockPhoto(folder / "a.tif", ExteriorResultPath(folder.Path(), "a"), camera, {}, ""));
  };
  const std::string before = digest();
  EXPECT_EQ(digest(), before);
  result.made_from = {{"approximation", "one"}};
  const std::string one = digest();
  EXPECT_NE(one, before);
  result.made_from = {{"approximation", "two"}};
  EXPECT_NE(digest(), one);
  WriteFileAtomically(folder / "a.tif", "another scan");
  EXPECT_NE(digest(), one);
}

}  // namespace
}  // namespace orient::block
