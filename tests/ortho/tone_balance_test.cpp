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
  EXPECT_GT(balanced.before.value(), 8);
  EXPECT_LT(balanced.after.value(), 0.5);
  EXPECT_TRUE(balanced.alone.empty() && balanced.bounded.empty());
  for (int col = 30; col < kSide; ++col) {
    EXPECT_NEAR(Value(photos[0], balanced.tones[0], col, 20),
                Value(photos[1], balanced.tones[1], col - 30, 20), 1);
    EXPECT_NEAR(Value(photos[1], balanced.tones[1], col, 20),
                Value(photos[2], balanced.tones[2], col - 30, 20), 1);
  }
}

TEST(BalancedTones, AreTheirOwnWhereOthersWouldBringOverlapsNoCloser) {
  int kept = 0;
  for (unsigned seed = 1; seed <= 10; ++seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> grey(120, 20);
    const auto noise = [&](int, int) { return grey(random); };  // nothing in common
    const BalancedTones balanced =
        BalanceTones({Photo(0, noise, {1, 0}), Photo(30, noise, {1, 0}), Photo(60, noise, {1, 0})});
    EXPECT_LE(*balanced.after, *balanced.before);
    if (!balanced.would_worsen) continue;
    ++kept;
    for (const auto& of_photo : balanced.tones) {
      ASSERT_EQ(of_photo.size(), 1u);
      EXPECT_EQ(of_photo[0].gain, 1);
      EXPECT_EQ(of_photo[0].offset, 0);
    }
  }
  EXPECT_GT(kept, 0);
}

TEST(BalancedTones, KeepTheBrightnessAndTheContrastOfTheWhole) {
  const std::vector<PhotoCells> photos = {Photo(0, Hilly, {1, 0}), Photo(30, Hilly, {1.3, -20})};
  const BalancedTones balanced = BalanceTones(photos);
  EXPECT_NEAR(balanced.tones[0][0].gain * balanced.tones[1][0].gain, 1, 1e-3);
  double change = 0;
  for (int row = 0; row < kSide; ++row)
    for (int col = 0; col < 30; ++col)
      for (const auto& [i, at] : {std::pair{0, col + 30}, std::pair{1, col}}) {
        const auto photo = static_cast<std::size_t>(i);
        change += Value(photos[photo], balanced.tones[photo], at, row) -
                  static_cast<double>(photos[photo].bands[0].At(at, row));
      }
  EXPECT_NEAR(change / (2 * kSide * 30), 0, 1);
}

// A strip of photos 30 cells apart, `tones` as they show it, with noise.
std::vector<PhotoCells> Strip(const std::vector<Tone>& tones, double noise) {
  std::mt19937 random(7);
  std::normal_distribution<float> off(0, static_cast<float>(noise));
  std::vector<PhotoCells> photos;
  for (std::size_t i = 0; i < tones.size(); ++i) {
    photos.push_back(Photo(30 * static_cast<int>(i), Hilly, tones[i]));
    for (float& value : photos.back().bands[0].values) value += off(random);
  }
  return photos;
}

void ExpectOneTone(const std::vector<PhotoCells>& photos, double within) {
  const BalancedTones balanced = BalanceTones(photos);
  for (std::size_t i = 0; i + 1 < photos.size(); ++i) {
    double brightness = 0;
    for (int row = 0; row < kSide; ++row)
      for (int col = 30; col < kSide; ++col)
        brightness += Value(photos[i], balanced.tones[i], col, row) -
                      Value(photos[i + 1], balanced.tones[i + 1], col - 30, row);
    EXPECT_NEAR(brightness / (30 * kSide), 0, within) << i;
  }
}

TEST(BalancedTones, CorrectTheOnePhotoThatIsOtherThanManyThatAgree) {
  for (const Tone& odd : {Tone{1, -80}, Tone{1, 60}, Tone{0.5, 50}, Tone{2, -60}}) {
    std::vector<Tone> tones(11);
    tones[5] = odd;
    ExpectOneTone(Strip(tones, 2), 1.5);
    const BalancedTones balanced = BalanceTones(Strip(tones, 2));
    EXPECT_NEAR(balanced.tones[5][0].gain / balanced.tones[4][0].gain, odd.gain, 0.1 * odd.gain);
    EXPECT_NEAR(balanced.tones[1][0].gain / balanced.tones[9][0].gain, 1, 0.05);
  }
}

TEST(BalancedTones, JoinTwoStripsThatAgreeEachInItself) {
  std::vector<Tone> tones(12);
  for (std::size_t i = 6; i < tones.size(); ++i) tones[i].offset = -40;
  const std::vector<PhotoCells> photos = Strip(tones, 2);
  ExpectOneTone(photos, 3);
  EXPECT_LT(BalanceTones(photos).after.value(), 3);
}

TEST(BalancedTones, OfAGrainyPhotoAreNoFlatterThanThoseOfOthers) {
  std::vector<PhotoCells> photos = Strip(std::vector<Tone>(7), 2);
  std::mt19937 random(3);
  for (float& value : photos[3].bands[0].values)
    value += std::normal_distribution<float>(0, 20)(random);
  const BalancedTones balanced = BalanceTones(photos);
  EXPECT_GT(balanced.tones[3][0].gain, 0.65) << "a regression makes it 0.5";
  EXPECT_LT(balanced.after.value(), 1.2 * balanced.before.value());
}

TEST(BalancedTones, OfAnInvertedPhotoAreNotInvertedAndSpoilNoOther) {
  std::vector<PhotoCells> photos = Strip(std::vector<Tone>(7), 2);
  for (float& value : photos[3].bands[0].values) value = 240 - value;
  const BalancedTones balanced = BalanceTones(photos);
  for (const std::vector<Tone>& tones : balanced.tones) EXPECT_NEAR(tones[0].gain, 1, 0.15);
}

TEST(BalancedTones, AreBoundedAndSayWhere) {
  std::vector<Tone> tones(9);
  tones[4] = {5, -400};
  const BalancedTones balanced = BalanceTones(Strip(tones, 0.2));
  EXPECT_EQ(balanced.bounded, std::vector<int>{4});
  EXPECT_EQ(balanced.tones[4][0].gain, 2.5);
}

TEST(BalancedTones, AreNotMovedByAQuarterThatHasChanged) {
  const auto changed = [](int col, int row) { return row < 15 ? 250.0 : Hilly(col, row); };
  const std::vector<PhotoCells> photos = {Photo(0, Hilly, {1, 0}), Photo(30, changed, {1.2, -10})};
  const BalancedTones balanced = BalanceTones(photos);
  for (int col = 30; col < kSide; ++col)
    EXPECT_NEAR(Value(photos[0], balanced.tones[0], col, 40),
                Value(photos[1], balanced.tones[1], col - 30, 40), 3);
}

TEST(BalancedTones, OfAFlatOverlapAreShiftsAlone) {
  const auto flat = [](int, int) { return 100.0; };
  const std::vector<PhotoCells> photos = {Photo(0, flat, {1, 0}), Photo(30, flat, {1, -40})};
  const BalancedTones balanced = BalanceTones(photos);
  for (const std::vector<Tone>& tones : balanced.tones) EXPECT_EQ(tones[0].gain, 1);
  EXPECT_LT(balanced.after.value(), 0.5);
}

TEST(BalancedTones, OfPhotosWithoutOverlapAreTheirOwn) {
  const BalancedTones balanced = BalanceTones(
      {Photo(0, Hilly, {1, 0}), Photo(30, Hilly, {1.2, 0}), Photo(1000, Hilly, {1, 0})});
  EXPECT_EQ(balanced.alone, std::vector<int>{2});
  EXPECT_EQ(balanced.tones[2][0].gain, 1);
  EXPECT_EQ(balanced.tones[2][0].offset, 0);
  EXPECT_FALSE(BalanceTones({Photo(0, Hilly, {1, 0})}).before.has_value());
  EXPECT_TRUE(BalanceTones({}).tones.empty());
}

TEST(BalancedTones, OfPhotosWithoutTextureAreTheirOwn) {
  const auto black = [](int, int) { return 0.0; };
  const BalancedTones balanced = BalanceTones({Photo(0, black, {1, 0}), Photo(30, black, {1, 0})});
  EXPECT_EQ(balanced.tones[1][0].gain, 1);
  EXPECT_EQ(balanced.tones[1][0].offset, 0);
}

TEST(BalancedTones, AreThoseOfEachBandAndShown) {
  std::vector<PhotoCells> photos = {Photo(0, Hilly, {1, 0}, 2), Photo(30, Hilly, {1, 0}, 2)};
  photos[1].bands[1] = Photo(30, Hilly, {1.25, 0}).bands[0];
  const BalancedTones balanced = BalanceTones(photos);
  EXPECT_NEAR(balanced.tones[1][0].gain, 1, 1e-3);
  EXPECT_NEAR(balanced.tones[1][1].gain / balanced.tones[0][1].gain, 1.25, 0.01);
  ShowInTones(balanced.tones, &photos);
  EXPECT_NEAR(photos[0].bands[1].At(45, 9), photos[1].bands[1].At(15, 9), 0.5);
}

}  // namespace
}  // namespace orient::ortho
