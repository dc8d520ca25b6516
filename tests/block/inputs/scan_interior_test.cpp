#include "block/inputs/scan_interior.h"

#include <gtest/gtest.h>

#include <vector>

#include "block/inputs/digest.h"
#include "core/files/results.h"
#include "core/raster/raster.h"
#include "tests/support/shared_data.h"

namespace orient::block {
namespace {

constexpr int kSide = 40;

void WriteScan(const std::string& path, unsigned char grey) {
  WritePng(path, kSide, kSide, 1, std::vector<unsigned char>(kSide * kSide, grey));
}

// A film photo whose interior orientation says of which scan it was made.
TEST(FilmGeometry, IsNotOfAnotherScanOfTheSameSize) {
  const TemporaryFolder folder;
  CameraFile camera;
  camera.camera.kind = CameraKind::kFilm;
  camera.camera.frame_mm = {60, 60};
  WriteScan(folder / "p.png", 100);
  InteriorResult interior;
  interior.photo = "p";
  interior.status = Status::kOk;
  interior.width = interior.height = kSide;
  interior.orientation = ScanOrientation::kR0;
  interior.possible_orientations = {ScanOrientation::kR0};
  interior.photo_from_pixel = Affine2d{};
  interior.made_from = {{"scan", DigestOfFile(folder / "p.png")}};
  WriteInteriorResult(folder.Path(), interior);
  const std::string path = InteriorResultPath(folder.Path(), "p");
  const auto said = [&] {
    return JoinedSentences(FilmGeometry(camera, {}, Raster::Open(folder / "p.png"), path).findings);
  };
  EXPECT_EQ(said(), "");
  WriteScan(folder / "p.png", 101);
  const std::string failure = said();
  EXPECT_NE(failure.find("other content"), std::string::npos) << failure;
  EXPECT_NE(failure.find("run 'orient interior' again"), std::string::npos) << failure;
}

}  // namespace
}  // namespace orient::block
