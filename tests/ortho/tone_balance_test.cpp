#include "ortho/tone_balance.h"

#include <gtest/gtest.h>

#include <random>

namespace orient::ortho {
namespace {

constexpr int kSide = 60;  // cells

// A photo of `side` x `side` cells from column `west` on of a ground whose grey value is `ground`.
template <typename Ground>
PhotoCells Photo(int west, const Ground& ground, const Tone& shown, int bands = 1) {
  PhotoCells photo;
  photo.grid.west = west;
  photo.grid.width = photo.grid.height = kSide;
  Image image(kSide, kSide);
  for (int row = 0; row < kSide; ++row)
    for (int col = 0; col < kSide; ++col)
      image.At(col, row) =
          static_cast<float>((ground(west + col, row) - shown.offset) / shown.gain);
  photo.bands.assign(static_cast<std::size_t>(bands), image);
  return photo;
}

double Hilly(int col, int row) { return 120 + 40 * std::sin(0.2 * col) * std::cos(0.15 * row); }

double Value(const PhotoCells& photo, const std::vector<Tone>& tones, int col, int row) {
  return tones[0].gain * static_cast<double>(photo.bands[0].At(col, row)) + tones[0].offset;
}

TEST(BalancedTones, GiveTheSameGroundTheSameGreyValue) {
  const std::vector<PhotoCells> photos = {Photo(0, Hilly, {1, 0}), Photo(30, Hilly, {1.3, -20}),
                                          Photo(60, Hilly, {0.8, 15})};
  const BalancedTones balanced = BalanceTones(photos);
  EXPECT_GT(balanced.before, 8);
  EXPECT_LT(balanced.after, 0.5);
  for (int col = 30; col < kSide; ++col) {
    EXPECT_NEAR(Value(photos[0], balanced.tones[0], col, 20),
                Value(photos[1], balanced.tones[1], col - 30, 20), 2);
    EXPECT_NEAR(Value(photos[1], balanced.tones[1], col, 20),
                Value(photos[2], balanced.tones[2], col - 30, 20), 2);
  }
}

TEST(BalancedTones, KeepTheBrightnessAndTheContrastOfTheWhole) {
  const std::vector<PhotoCells> photos = {Photo(0, Hilly, {1, 0}), Photo(30, Hilly, {1.3, -20})};
  const BalancedTones balanced = BalanceTones(photos);
  EXPECT_NEAR(balanced.tones[0][0].gain + balanced.tones[1][0].gain, 2, 1e-9);
  double change = 0;
  for (int row = 0; row < kSide; ++row)
    for (int col = 0; col < 30; ++col)
      for (const auto& [i, at] : {std::pair{0, col + 30}, std::pair{1, col}}) {
        const auto photo = static_cast<std::size_t>(i);
        change += Value(photos[photo], balanced.tones[photo], at, row) -
                  static_cast<double>(photos[photo].bands[0].At(at, row));
      }
  EXPECT_NEAR(change / (2 * kSide * 30), 0, 3);
}

TEST(BalancedTones, AreNotMovedByAQuarterThatHasChanged) {
  const auto changed = [](int col, int row) { return row < 15 ? 250.0 : Hilly(col, row); };
  const std::vector<PhotoCells> photos = {Photo(0, Hilly, {1, 0}), Photo(30, changed, {1.2, -10})};
  const BalancedTones balanced = BalanceTones(photos);
  for (int col = 30; col < kSide; ++col)
    EXPECT_NEAR(Value(photos[0], balanced.tones[0], col, 40),
                Value(photos[1], balanced.tones[1], col - 30, 40), 4);
}

TEST(BalancedTones, OfAFlatOverlapAreOffsetsAndNoWildGain) {
  const auto flat = [](int, int) { return 100.0; };
  const std::vector<PhotoCells> photos = {Photo(0, flat, {1, 0}), Photo(30, flat, {1, -40})};
  const BalancedTones balanced = BalanceTones(photos);
  for (const std::vector<Tone>& tones : balanced.tones) {
    EXPECT_GT(tones[0].gain, 0.5);
    EXPECT_LT(tones[0].gain, 2);
  }
  EXPECT_LT(balanced.after, 2);
}

TEST(BalancedTones, OfPhotosWithoutOverlapOrTextureAreTheirOwn) {
  for (const int west : {1000, 30}) {
    const auto black = [](int, int) { return 0.0; };
    const BalancedTones balanced =
        BalanceTones({Photo(0, black, {1, 0}), Photo(west, black, {1, 0})});
    EXPECT_EQ(balanced.tones[1][0].gain, 1);
    EXPECT_EQ(balanced.tones[1][0].offset, 0);
    EXPECT_EQ(balanced.before, 0);
  }
  EXPECT_TRUE(BalanceTones({}).tones.empty());
}

TEST(BalancedTones, AreThoseOfEachBand) {
  std::vector<PhotoCells> photos = {Photo(0, Hilly, {1, 0}, 2), Photo(30, Hilly, {1, 0}, 2)};
  photos[1].bands[1] = Photo(30, Hilly, {1.25, 0}).bands[0];
  const BalancedTones balanced = BalanceTones(photos);
  EXPECT_NEAR(balanced.tones[1][0].gain, 1, 1e-3);
  EXPECT_NEAR(balanced.tones[1][1].gain / balanced.tones[0][1].gain, 1.25, 0.03);
}

}  // namespace
}  // namespace orient::ortho
