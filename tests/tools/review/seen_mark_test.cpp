#include "tools/review/seen_mark.h"

#include <gtest/gtest.h>

#include "tests/support/film_frame.h"
#include "tests/support/shared_data.h"

namespace orient {
namespace {

using Eigen::Vector2d;

class SeenMark : public testing::Test {
 protected:
  void SetUp() override {
    FilmFrameSpec spec;
    spec.camera = camera_;
    frame_ = RenderFilmFrame(spec);
    WriteScan(folder_ / "a.png", frame_.scan);
    known_.pixel_size_um = 100;
  }
  std::optional<SeenAtClick> See(const ScanKnowledge& known, const std::string& mark,
                                 const Vector2d& click) const {
    return SeeMark(Raster::Open(folder_ / "a.png"), camera_, known, mark, click);
  }

  TemporaryFolder folder_;
  CameraFile camera_ = RingCamera(30, 70);
  FilmFrame frame_;
  ScanKnowledge known_;
};

TEST_F(SeenMark, IsWhereTheDrawingFitsAndNotWhereTheClickWas) {
  for (std::size_t i = 0; i < camera_.fiducials.size(); ++i) {
    const auto seen =
        See(known_, camera_.fiducials[i].id, frame_.mark_pixels[i] + Vector2d(3.2, -2.4));
    ASSERT_TRUE(seen);
    EXPECT_LT((seen->pixel - frame_.mark_pixels[i]).norm(), 0.2);
    EXPECT_GT(seen->correlation, 0.9);
  }
}

TEST_F(SeenMark, WhereThereIsNoneItsDrawingFitsBadly) {
  const auto seen = See(known_, "1", frame_.mark_pixels[0] + Vector2d(40, 40));
  ASSERT_TRUE(seen);
  EXPECT_LT(seen->correlation, 0.5);
}

TEST_F(SeenMark, NothingIsSaidOfUnknownMarksAndSizes) {
  EXPECT_FALSE(See(known_, "nine", frame_.mark_pixels[0]));
  EXPECT_FALSE(See({}, "1", frame_.mark_pixels[0])) << "no resolution tag either";
}

TEST_F(SeenMark, IsSeenInTheNegativeUnlessItIsSaidToBePositive) {
  for (float& value : frame_.scan.values) value = 255 - value;
  WriteScan(folder_ / "a.png", frame_.scan);
  EXPECT_GT(See(known_, "1", frame_.mark_pixels[0])->correlation, 0.9);
  known_.polarity = Polarity::kPositive;
  EXPECT_LT(See(known_, "1", frame_.mark_pixels[0])->correlation, 0.5);
}

TEST_F(SeenMark, BesideTheScanThereIsNothingToCompare) {
  const auto seen = See(known_, "1", {0, 0});
  EXPECT_TRUE(!seen || seen->correlation >= -1);
}

}  // namespace
}  // namespace orient
