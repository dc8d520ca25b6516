// Each locator alone, on windows with one mark whose place is known.
#include "interior/locators/locator.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "core/matching/correlation.h"
#include "core/raster/resample.h"
#include "interior/locators/hough_locator.h"
#include "interior/locators/lines_locator.h"
#include "tests/support/film_frame.h"
#include "tests/support/shared_data.h"

namespace orient::interior {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

constexpr double kPixelMm = 0.05;
constexpr int kSide = 300;  // 15 mm

struct Trial {
  MarkShape shape;
  bool in_picture = false;  // else on a dark corner
  double contrast = 150;    // of the strokes against what is below them
  double noise = 4;
  double turn_rad = 0;
  bool dark = false;        // a negative
  bool drawn_dark = false;  // strokes darker than what is around them on a positive
};

struct Window {
  Image image;
  Vector2d truth;
};

MarkShape Drawn(std::vector<MarkElement> elements,
                MarkBackground background = MarkBackground::kDark) {
  MarkShape shape;
  shape.drawing.elements = std::move(elements);
  shape.drawing.background = background;
  return shape;
}

double Coverage(const MarkShape& shape, const Matrix2d& mm_from_px, const Vector2d& corner) {
  constexpr int kSamples = 6;
  int inside = 0;
  for (int j = 0; j < kSamples; ++j)
    for (int i = 0; i < kSamples; ++i)
      if (StrokeDistance(shape.drawing,
                         mm_from_px * (corner + Vector2d(i + 0.5, j + 0.5) / kSamples)) <= 0)
        ++inside;
  return static_cast<double>(inside) / (kSamples * kSamples);
}

Matrix2d Upright(double pixel_mm) {
  return Eigen::DiagonalMatrix<double, 2>(1, -1) * Matrix2d::Identity() / pixel_mm;
}

Window Simulate(const Trial& trial, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> place(60, kSide - 60);
  std::normal_distribution<float> grain(0, static_cast<float>(trial.noise));
  Window window{RenderTexture(kSide, kSide, seed), {place(random), place(random)}};
  const Matrix2d mm_from_px =
      (Eigen::Rotation2Dd(trial.turn_rad).toRotationMatrix() * Upright(kPixelMm)).inverse();
  for (int row = 0; row < kSide; ++row)
    for (int col = 0; col < kSide; ++col) {
      const Vector2d from_mark = Vector2d(col, row) - window.truth;
      double value = static_cast<double>(window.image.At(col, row));
      if (!trial.in_picture && from_mark.norm() * kPixelMm < 5) value = trial.dark ? 200 : 25;
      if (from_mark.norm() * kPixelMm < MarkRadius(trial.shape) + 0.1)
        value += (trial.dark != trial.drawn_dark ? -1 : 1) * trial.contrast *
                 Coverage(trial.shape, mm_from_px, from_mark);
      window.image.At(col, row) = static_cast<float>(value);
    }
  window.image = GaussianBlur(window.image, 0.7);
  for (float& value : window.image.values) value = std::clamp(value + grain(random), 0.0f, 255.0f);
  return window;
}

class LocatorAlone : public testing::Test {
 protected:
  MarkCandidates Find(LocatorKind kind, const Trial& trial, const Image& image) {
    const std::string path = folder_ / "window.png";
    WriteScan(path, image);
    const Raster raster = Raster::Open(path);
    ScanWindows scan(raster);
    return MakeLocator(kind)->Find(scan, trial.shape,
                                   {{20, 20, kSide - 40, kSide - 40}, Upright(kPixelMm)});
  }

  // Share of windows in which some candidate of the right polarity lies within `tolerance_px`.
  double HitRate(LocatorKind kind, const Trial& trial, double tolerance_px, int count = 6) {
    int hits = 0;
    for (int i = 0; i < count; ++i) {
      const Window window = Simulate(trial, 50 + static_cast<unsigned>(i));
      const MarkCandidates found = Find(kind, trial, window.image);
      const auto& candidates = trial.dark ? found.dark : found.bright;
      EXPECT_LE(candidates.size(), 20u);
      hits += std::any_of(candidates.begin(), candidates.end(), [&](const MarkCandidate& c) {
        return (c.pixel - window.truth).norm() <= tolerance_px;
      });
    }
    const double rate = static_cast<double>(hits) / count;
    RecordProperty("hit_rate", std::to_string(rate));
    return rate;
  }

  TemporaryFolder folder_;
};
using SlowLocatorAlone = LocatorAlone;  // labelled slow by its name

const std::vector<MarkElement> kRing = {CircleElement{1.7, 0.2},
                                        CrossElement{3.5, 0.13, 0.56, std::numbers::pi / 4}};
const std::vector<MarkElement> kCross = {CrossElement{3.0, 0.12, 0.4, 0}};
const std::vector<MarkElement> kDot = {DotElement{0.9}};
const std::vector<MarkElement> kCircle = {CircleElement{2.2, 0.15}};
const std::vector<MarkElement> kThinCross = {CrossElement{4.0, 0.1, 0, 0}};
// 0.8 and -0.5 mm beside the mark's centre.
const std::vector<MarkElement> kCrossBeside = {CrossElement{4.0, 0.1, 0, 0, Vector2d(0.8, -0.5)}};
const std::vector<MarkElement> kDarkCross = {
    CrossElement{4.0, 0.1, 0, 0, Vector2d(0.8, -0.5), -1.0}};
const std::vector<MarkElement> kLeaningCross = {CrossElement{4.0, 0.1, 0, std::numbers::pi / 4}};

TEST_F(LocatorAlone, HoughFindsEveryKindOfMarkOnADarkCorner) {
  for (const auto& elements : {kRing, kCross, kDot, kCircle})
    EXPECT_EQ(HitRate(LocatorKind::kHough, {Drawn(elements)}, 2), 1.0) << elements.size();
}

TEST_F(LocatorAlone, NccFindsEveryKindOfMarkOnADarkCorner) {
  for (const auto& elements : {kRing, kCross, kDot, kCircle})
    EXPECT_EQ(HitRate(LocatorKind::kNcc, {Drawn(elements)}, 2), 1.0) << elements.size();
}

TEST_F(LocatorAlone, HoughAndNccFindAFaintTurnedNegativeMark) {
  Trial trial{Drawn(kRing)};
  trial.contrast = 30;
  trial.noise = 12;
  trial.turn_rad = 0.05;
  trial.dark = true;
  EXPECT_EQ(HitRate(LocatorKind::kHough, trial, 2), 1.0);
  EXPECT_EQ(HitRate(LocatorKind::kNcc, trial, 2), 1.0);
}

// Strokes of a pixel, three sigma of the grain above the ground: grain alone keeps the drawing from
// correlating, which the score allows for, and the picture's texture around the dark corner is not
// helped by it.
TEST_F(LocatorAlone, NccScoresAFaintThinMarkWithoutItsGrain) {
  Trial trial{Drawn({CrossElement{1.5, 0.05, 0, 0}})};
  trial.contrast = 36;
  trial.noise = 12;
  for (const bool dark : {false, true}) {
    trial.dark = dark;
    for (unsigned seed = 1; seed <= 4; ++seed) {
      const Window window = Simulate(trial, seed);
      const MarkCandidates found = Find(LocatorKind::kNcc, trial, window.image);
      const auto& candidates = dark ? found.dark : found.bright;
      ASSERT_GE(candidates.size(), 2u);
      EXPECT_LT((candidates[0].pixel - window.truth).norm(), 1.5) << seed;
      EXPECT_GT(candidates[0].ncc, 0.75) << seed;
      EXPECT_LT(candidates[1].ncc, 0.6) << seed;
    }
  }
}

// Grey values that are all alike are no sign of film without grain.
TEST_F(LocatorAlone, NccScoresAFaintThinMarkWithoutItsGrainBesideABlackScannerBed) {
  Trial trial{Drawn({CrossElement{1.5, 0.05, 0, 0}})};
  trial.contrast = 36;
  trial.noise = 12;
  Window window = Simulate(trial, 1);
  const int black = static_cast<int>(window.truth.x()) - 40;
  ASSERT_GT(black, 0.3 * window.image.width);
  for (int row = 0; row < window.image.height; ++row)
    for (int col = 0; col < black; ++col) window.image.At(col, row) = 0;
  const MarkCandidates found = Find(LocatorKind::kNcc, trial, window.image);
  ASSERT_FALSE(found.bright.empty());
  EXPECT_LT((found.bright[0].pixel - window.truth).norm(), 1.5);
  EXPECT_GT(found.bright[0].ncc, 0.75);
}

TEST_F(LocatorAlone, LinesFindsThinCrossesInThePicture) {
  Trial trial{Drawn(kThinCross, MarkBackground::kImage), true};
  for (const bool dark : {false, true}) {
    trial.dark = dark;
    trial.turn_rad = dark ? 0.02 : -0.03;
    EXPECT_GE(HitRate(LocatorKind::kLines, trial, 1), 0.9) << dark;
  }
}

TEST_F(LocatorAlone, LinesFindsCrossesAt45Degrees) {
  EXPECT_GE(HitRate(LocatorKind::kLines, {Drawn(kLeaningCross, MarkBackground::kImage), true}, 1),
            0.9);
}

TEST_F(LocatorAlone, LinesFindsCrossesBesideTheMarksCentreWhateverTheFilmsTurn) {
  Trial trial{Drawn(kCrossBeside, MarkBackground::kImage), true};
  for (const double turn : {-0.07, 0.0, 0.07}) {
    trial.turn_rad = turn;
    EXPECT_GE(HitRate(LocatorKind::kLines, trial, 1), 0.9) << turn;
  }
}

TEST_F(LocatorAlone, LinesFindsCrossesThatAreDrawnDarkInEitherPolarity) {
  Trial trial{Drawn(kDarkCross, MarkBackground::kImage), true};
  trial.drawn_dark = true;
  for (const bool dark : {false, true}) {
    trial.dark = dark;
    EXPECT_GE(HitRate(LocatorKind::kLines, trial, 1), 0.9) << dark;
  }
}

TEST_F(LocatorAlone, LinesFindsCrossesWithAGapOnADarkCorner) {
  EXPECT_EQ(HitRate(LocatorKind::kLines, {Drawn(kCross)}, 1), 1.0);
}

TEST_F(SlowLocatorAlone, HitRatesOverManyWindows) {
  const Trial thin{Drawn(kThinCross, MarkBackground::kImage), true};
  const Trial leaning{Drawn(kLeaningCross, MarkBackground::kImage), true};
  Trial faint{Drawn(kRing)};
  faint.contrast = 25;
  faint.noise = 14;
  for (const Trial& trial : {thin, leaning, faint})
    for (const LocatorKind kind : {LocatorKind::kHough, LocatorKind::kNcc, LocatorKind::kLines}) {
      const double rate = HitRate(kind, trial, 2, 60);
      std::printf("contrast %.0f locator %d: hit rate %.3f\n", trial.contrast,
                  static_cast<int>(kind), rate);
      EXPECT_GE(rate, kind == LocatorKind::kLines && !trial.in_picture ? 0.0 : 0.9);
    }
}

TEST_F(LocatorAlone, NothingIsFoundOnFlatFilm) {
  for (const LocatorKind kind : {LocatorKind::kHough, LocatorKind::kNcc, LocatorKind::kLines}) {
    const MarkCandidates found = Find(kind, {Drawn(kCross)}, Image(kSide, kSide, 20));
    EXPECT_TRUE(found.bright.empty());
    EXPECT_TRUE(found.dark.empty());
  }
}

TEST(SkeletonTemplate, CorrelationIsTheDifferenceOfTheMeansOverTheSpread) {
  const MarkTemplate skeleton = SkeletonTemplate(Drawn(kRing), Upright(0.09));
  const Image image = RenderTexture(120, 120, 7);
  const Image ncc = Correlate(skeleton.values, image);
  ASSERT_FALSE(ncc.Empty());
  for (int row = 0; row < ncc.height; row += 7) {
    for (int col = 0; col < ncc.width; col += 5) {
      double line = 0, around = 0, squares = 0;
      int on_line = 0, beside = 0;
      for (int r = 0; r < skeleton.values.height; ++r)
        for (int c = 0; c < skeleton.values.width; ++c) {
          const float kind = skeleton.values.At(c, r);
          if (std::isnan(kind)) continue;
          const double grey = static_cast<double>(image.At(col + c, row + r));
          squares += grey * grey;
          (kind > 0 ? line : around) += grey;
          ++(kind > 0 ? on_line : beside);
        }
      const double n = on_line + beside, mean = (line + around) / n;
      const double spread = std::sqrt(squares / n - mean * mean);
      const double hough = (line / on_line - around / beside) / spread;
      EXPECT_NEAR(static_cast<double>(ncc.At(col, row)),
                  hough * std::sqrt(static_cast<double>(on_line) * beside) / n, 1e-4);
    }
  }
}

TEST(SkeletonTemplate, LinesAreOnePixelWideAndTheNeighbourhoodTwoPixelsAway) {
  // A bar-like cross: 40 px long, 5 px wide.
  const MarkTemplate skeleton = SkeletonTemplate(Drawn({CrossElement{4, 0.5, 0, 0}}), Upright(0.1));
  const int centre = static_cast<int>(skeleton.centre.x());
  std::vector<float> across;
  for (int row = centre - 6; row <= centre + 6; ++row)
    across.push_back(skeleton.values.At(centre + 10, row));
  int lines = 0;
  for (size_t i = 0; i < across.size(); ++i) {
    if (across[i] == 1) {
      ++lines;
      EXPECT_EQ(i, 6u);
    }
    if (across[i] == 0) {
      EXPECT_NEAR(std::abs(static_cast<double>(i) - 6), 2.5 + 2, 0.6);
    }
  }
  EXPECT_EQ(lines, 1);
}

TEST(LocatorFor, GoesByTheDrawing) {
  EXPECT_EQ(UsualLocator(Drawn(kRing)), LocatorKind::kNcc);
  EXPECT_EQ(UsualLocator(Drawn(kThinCross)), LocatorKind::kNcc);
  EXPECT_EQ(UsualLocator(Drawn(kThinCross, MarkBackground::kImage)), LocatorKind::kLines);
  EXPECT_EQ(LocatorFor(Drawn(kRing), LocatorKind::kHough), LocatorKind::kHough);
  EXPECT_EQ(LocatorFor(Drawn(kDot), LocatorKind::kLines), LocatorKind::kNcc);
  const MarkShape dark_cross =
      Drawn({DotElement{3}, CrossElement{2.4, 0.1, 0, 0, Vector2d::Zero(), 0.0}});
  EXPECT_EQ(LocatorFor(dark_cross, LocatorKind::kHough), LocatorKind::kNcc);
  MarkShape picture;
  picture.picture = Image(20, 20);
  EXPECT_EQ(LocatorFor(picture, LocatorKind::kHough), LocatorKind::kNcc);
}

}  // namespace
}  // namespace orient::interior
