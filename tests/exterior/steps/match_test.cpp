#include "exterior/steps/match.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <random>

#include "core/raster/raster.h"
#include "tests/support/shared_data.h"

namespace orient::exterior {
namespace {

constexpr int kWidth = 240, kHeight = 180;
constexpr int kSide = 21;
constexpr double kTolerancePx = 0.02;

// A scan of random grey values, and a patch cut out of it.
class Match : public testing::Test {
 protected:
  Match() {
    std::mt19937 random(TestSeed());
    std::vector<unsigned char> grey(kWidth * kHeight);
    for (unsigned char& value : grey) value = static_cast<unsigned char>(random() % 256);
    WritePng(path_, kWidth, kHeight, 1, grey);
    raster_.emplace(Raster::Open(path_));
    photo_.emplace(*raster_, false);
  }
  ~Match() override { std::filesystem::remove(path_); }

  // Drawn from its true place, predicted at another.
  AlignedPatch PatchAt(const Eigen::Vector2d& true_px, const Eigen::Vector2d& predicted_px) const {
    AlignedPatch patch;
    patch.image = photo_->Around(true_px, Eigen::Vector2d::Constant(kSide / 2.0), 1).image;
    patch.predicted_px = predicted_px;
    return patch;
  }

  const std::string path_ =
      testing::TempDir() + "/orient_match_" + std::to_string(TestSeed()) + ".png";
  std::optional<Raster> raster_;
  std::optional<PhotoImage> photo_;
};

TEST_F(Match, FindsThePatchWhereverThePredictionIs) {
  const Eigen::Vector2d truth(60.5, 130.5);
  const auto candidates =
      FindCandidates(PatchAt(truth, {75.5, 120.5}), *photo_, {20, 20}, CandidateOptions{});
  ASSERT_FALSE(candidates.empty());
  EXPECT_LT((candidates[0].pixel - truth).norm(), kTolerancePx);
}

// Nothing but the photo can be searched: neither memory nor the odds of chance may grow beyond it.
TEST_F(Match, AnAbsurdUncertaintySearchesThePhotoOnce) {
  const Eigen::Vector2d truth(60.5, 130.5), predicted(200.5, 20.5);
  for (const double radius : {1e4, 1e9, 1e300}) {
    const Eigen::Vector2d reach = Eigen::Vector2d::Constant(radius);
    EXPECT_EQ(AreaToSearch(predicted, reach, *photo_).Size(), Eigen::Vector2d(kWidth, kHeight));
    const auto candidates = FindCandidates(PatchAt(truth, predicted), *photo_, reach, {});
    ASSERT_FALSE(candidates.empty());
    EXPECT_LT((candidates[0].pixel - truth).norm(), kTolerancePx);
  }
}

TEST_F(Match, ASearchAreaEndsAtThePhotosBorder) {
  const SearchArea area = AreaToSearch({230, 90}, {30, 40}, *photo_);
  EXPECT_EQ(area.first, Eigen::Vector2d(200, 50));
  EXPECT_EQ(area.last, Eigen::Vector2d(kWidth, 130));
}

TEST_F(Match, APatchOnTheBorderIsFoundThere) {
  const Eigen::Vector2d truth(kWidth - 10.5, 90.5);
  const auto match = PreciseSearch(PatchAt(truth, {225.5, 84.5}), *photo_, {12, 12}).ByGrey({});
  ASSERT_TRUE(match.found) << JoinedSentences(match.why_not);
  EXPECT_LT((match.pixel - truth).norm(), kTolerancePx);
}

// Grey values cannot: their correlation is -1 at the right place.
// A step from dark to bright, and little else.
TEST(MatchOfAnEdge, IsWhereItIsPredictedAlongIt) {
  const std::string path =
      testing::TempDir() + "/orient_edge_" + std::to_string(TestSeed()) + ".png";
  std::mt19937 random(TestSeed());
  std::vector<unsigned char> grey(kWidth * kHeight);
  for (int row = 0; row < kHeight; ++row)
    for (int col = 0; col < kWidth; ++col)
      grey[static_cast<std::size_t>(row * kWidth + col)] = static_cast<unsigned char>(
          120 + 80 * std::tanh((col - 100.3) / 1.5) + static_cast<double>(random() % 3));
  WritePng(path, kWidth, kHeight, 1, grey);
  const Raster raster = Raster::Open(path);
  const PhotoImage photo(raster, false);
  AlignedPatch patch;
  patch.image = photo.Around({100.5, 60.5}, Eigen::Vector2d::Constant(kSide / 2.0), 1).image;
  patch.predicted_px = {101.5, 90.5};
  const PreciseSearch search(patch, photo, {3, 3});
  EXPECT_FALSE(search.ByGrey({.min_score_gap = 0}).found);
  const PreciseMatch match = search.ByGrey({.min_score_gap = 0, .edges = true});
  std::filesystem::remove(path);
  ASSERT_TRUE(match.found);
  EXPECT_NEAR(match.pixel.x(), 100.5, 0.1);
  EXPECT_NEAR(match.pixel.y(), 90.5, 0.1);
  EXPECT_LT(std::sqrt(match.covariance_px2(0, 0)), 0.2);
  EXPECT_GT(std::sqrt(match.covariance_px2(1, 1)), 40);
}

TEST_F(Match, AnInvertedPatchIsFoundByItsGradients) {
  const Eigen::Vector2d truth(60.5, 130.5);
  AlignedPatch patch = PatchAt(truth, {64.5, 127.5});
  for (float& value : patch.image.values) value = 255 - value;
  const PreciseSearch search(patch, *photo_, {10, 10});
  EXPECT_FALSE(search.ByGrey({}).found);
  const PreciseMatch match = search.ByGradients();
  ASSERT_TRUE(match.found) << JoinedSentences(match.why_not);
  EXPECT_EQ(match.cue, MatchCue::kGradients);
  EXPECT_LT((match.pixel - truth).norm(), 0.1);
}

}  // namespace
}  // namespace orient::exterior
