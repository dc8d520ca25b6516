#include "exterior/search/keypoint_search.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

#include "tests/support/textured_photo.h"

namespace orient::exterior {
namespace {

// A photo of which neither kappa nor, to a tenth of the flying height, the position is known.
class KeypointSearched : public testing::Test {
 protected:
  KeypointSearched() {
    photo_.prior.pose = PhotoOfHills().View().pose;
    photo_.prior.pose.position_m += Eigen::Vector3d(70, -50, 40);
    photo_.prior.pose.opk_rad = {0, 0, -1};
    Vector6d sigma;
    sigma << 80, 80, 60, 0.1, 0.1, std::numbers::pi;
    photo_.prior.covariance = sigma.cwiseAbs2().asDiagonal();
  }
  WholePhotoSearch Search(const PhotoImage& image) const {
    const PhotoTask task{photo_, image, patches_, options_};
    return SearchByKeypoints(task, MedianGroundHeight(patches_), KeypointTrials(task));
  }
  void ExpectFound(const WholePhotoSearch& search) const {
    EXPECT_TRUE(search.searched);
    ASSERT_TRUE(search.track);
    EXPECT_LT(search.track->log10_false_alarms, options_.max_log10_false_alarms);
    EXPECT_LT(PhotoOfHills().WorstError(search.track->pose, patches_), 6);
  }

  PhotoToOrient photo_ = PhotoOfHills().ToOrient();
  OrientPhotoOptions options_;
  std::vector<patchdb::Patch> patches_ = PhotoOfHills().Patches(PhotoOfHills().Ground(), 5, 110);
};

TEST_F(KeypointSearched, APhotoIsFoundAtAnyKappaAndAPoorPosition) {
  for (const double kappa : {0.0, 1.5, 3.0, -2.0}) {
    photo_.prior.pose.opk_rad.z() = kappa;
    ExpectFound(Search(PhotoOfHills().File()));
  }
}

TEST_F(KeypointSearched, APhotoIsFoundWhereItsStatedAccuracyFailed) {
  photo_.prior.covariance *= 1e-4;
  options_.prior_failed = true;
  ExpectFound(Search(PhotoOfHills().File()));
}

// Scanned through its back: columns count from the other side.
TEST_F(KeypointSearched, AMirroredScanIsFoundByMirroredChips) {
  const int side = PhotoOfHills().File().Width();
  const Eigen::Vector2d half = Eigen::Vector2d::Constant(side / 2.0);
  const ImageWindow upright = PhotoOfHills().File().Around(half, half, 1);
  std::vector<unsigned char> grey;
  for (int row = 0; row < side; ++row)
    for (int col = side; col-- > 0;)
      grey.push_back(static_cast<unsigned char>(upright.image.At(col, row)));
  const TemporaryFolder folder;
  const std::string path = folder / "mirrored.png";
  WritePng(path, side, side, 1, grey);
  const Raster raster = Raster::Open(path);
  Affine2d& photo_from_pixel = photo_.positions.front().photo_from_pixel;
  photo_from_pixel.t += side * photo_from_pixel.A.col(0);
  photo_from_pixel.A.col(0) *= -1;
  ExpectFound(Search(PhotoImage(raster, false)));
}

TEST_F(KeypointSearched, OfTwoFilmPositionsTheTrueOneIsFound) {
  FilmPosition wrong = photo_.positions.front();
  wrong.photo_from_pixel.A *= -1;  // by half a turn, which kappa makes good
  wrong.photo_from_pixel.t *= -1;
  wrong.photo_from_pixel.A.col(1) *= -1;  // and mirrored, which nothing does
  wrong.photo_from_pixel.t.y() *= -1;
  photo_.positions.insert(photo_.positions.begin(), wrong);
  const WholePhotoSearch search = Search(PhotoOfHills().File());
  ExpectFound(search);
  EXPECT_EQ(search.track->position.photo_from_pixel.A, photo_.positions[1].photo_from_pixel.A);
}

TEST_F(KeypointSearched, PatchesOfAnotherPlaceDoNotConvince) {
  patches_ = PhotoOfHills().Patches(Texture(6, 6), 5, 110);
  const WholePhotoSearch search = Search(PhotoOfHills().File());
  EXPECT_TRUE(search.searched);
  if (search.track) {
    EXPECT_GT(search.track->log10_false_alarms, options_.max_log10_false_alarms);
  }
}

TEST_F(KeypointSearched, ChipsTooSmallForKeypointsAreNotSearchedFor) {
  for (patchdb::Patch& patch : patches_) {
    patch.chip.values.resize(21 * 21);
    patch.chip.width = patch.chip.height = 21;
  }
  const WholePhotoSearch search = Search(PhotoOfHills().File());
  EXPECT_FALSE(search.searched);
  EXPECT_FALSE(search.track);
}

}  // namespace
}  // namespace orient::exterior
