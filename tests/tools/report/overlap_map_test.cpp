#include "tools/report/overlap_map.h"

#include <gtest/gtest.h>

namespace orient {
namespace {

class Overlap : public ::testing::Test {
 protected:
  // A footprint of 100 m x 100 m, closed, from `west` on.
  void Add(double west, Status status = Status::kOk) {
    PhotoRecord photo;
    photo.name = std::to_string(block_.photos.size());
    photo.exterior.emplace();
    for (const auto& [x, y] : {std::pair{0, 0}, std::pair{100, 0}, std::pair{100, 100},
                               std::pair{0, 100}, std::pair{0, 0}})
      photo.exterior->footprint_m.emplace_back(west + x, 5e6 + y, 10);
    block_.photos.push_back(photo);
    verdict_.photos.emplace_back().status = status;
  }

  std::string Text() const { return OverlapMap(block_, verdict_).Text(); }
  bool Says(const std::string& part) const { return Text().find(part) != std::string::npos; }

  BlockRecord block_;
  BlockVerdict verdict_;
};

TEST_F(Overlap, CountsThePhotosThatShowAPlace) {
  Add(0);
  Add(50);
  EXPECT_TRUE(Says("1 photo: 67 %") && Says("2 photos: 33 %")) << Text();
  EXPECT_TRUE(Says("viewBox=\"0 0 600 400\"") && Says("cells of 1.0 m")) << Text();
  EXPECT_TRUE(Says("class=\"seen-2\" d=\"M200 0h200v4h-200z")) << "the middle third";
}

TEST_F(Overlap, OfManyPhotosIsSixOrMore) {
  for (int i = 0; i < 9; ++i) Add(0);
  EXPECT_TRUE(Says("6 or more photos: 100 %")) << Text();
}

TEST_F(Overlap, CountsNoFailedPhotoAndNeedsTwo) {
  Add(0);
  Add(50, Status::kFailed);
  EXPECT_EQ(Text(), "");
  Add(0, Status::kWeak);
  EXPECT_TRUE(Says("2 photos: 100 %")) << Text();
  block_.photos[1].exterior.reset();
  block_.photos[2].exterior->footprint_m.clear();
  EXPECT_EQ(Text(), "");
}

}  // namespace
}  // namespace orient
