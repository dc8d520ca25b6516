// A cross measured by its lines, on windows whose truth is known.
#include "interior/marks/cross_position.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <numbers>
#include <random>

#include "core/raster/resample.h"
#include "interior/marks/subpixel.h"
#include "tests/support/film_frame.h"
#include "tests/support/shared_data.h"

namespace orient::interior {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

constexpr int kSide = 220;
constexpr double kPixelMm = 0.025;
constexpr double kMaxShiftPx = 8;

// A P31's cross.
MarkShape ThinCross(double angle_rad = 0) {
  MarkShape shape;
  shape.drawing.elements = {CrossElement{2.4, 0.06, 0, angle_rad}};
  shape.drawing.background = MarkBackground::kImage;
  return shape;
}

struct Trial {
  MarkShape shape = ThinCross();
  double turn_rad = 0;
  double brightness = 235;
  double noise = 3;
  bool dark = false;
  bool painted = true;
  unsigned seed = 1;

  Matrix2d PixelFromMm() const {
    return Eigen::Rotation2Dd(turn_rad).toRotationMatrix() *
           Eigen::DiagonalMatrix<double, 2>(1, -1) / kPixelMm;
  }
};

// How much of a square of `size_px` around `at` (from the cross's centre) the cross covers, where
// its outline is straight.
double Covered(const Trial& trial, const Matrix2d& mm_from_pixel, const Vector2d& at,
               double size_px) {
  const double outside_px = StrokeDistance(trial.shape.drawing, mm_from_pixel * at) / kPixelMm;
  return std::clamp(0.5 - outside_px / size_px, 0.0, 1.0);
}

// The picture with the cross in it, whose surroundings are painted in finer pixels: optics blur
// before the scanner's pixels average.
Image Scanned(const Trial& trial, const Image& picture, const Vector2d& truth) {
  constexpr int kFiner = 3, kMargin = 4;
  constexpr double kBlurPx = 0.6;
  const Matrix2d mm_from_pixel = trial.PixelFromMm().inverse();
  const int half = static_cast<int>(MarkRadius(trial.shape) / kPixelMm) + 2 * kMargin + 2;
  const int left = static_cast<int>(truth.x()) - half, top = static_cast<int>(truth.y()) - half;
  const int side = 2 * half + 1;
  Image fine(kFiner * side, kFiner * side);
  for (int row = 0; row < fine.height; ++row)
    for (int col = 0; col < fine.width; ++col) {
      const Vector2d at = Vector2d(left + (col + 0.5) / kFiner, top + (row + 0.5) / kFiner) - truth;
      const float under = picture.At(left + col / kFiner, top + row / kFiner);
      fine.At(col, row) =
          under + static_cast<float>(Covered(trial, mm_from_pixel, at, 1.0 / kFiner) *
                                     (trial.brightness - static_cast<double>(under)));
    }
  fine = GaussianBlur(fine, kFiner * kBlurPx);
  Image scan = GaussianBlur(picture, kBlurPx);
  for (int row = kMargin; row < side - kMargin; ++row)
    for (int col = kMargin; col < side - kMargin; ++col) {
      float sum = 0;
      for (int i = 0; i < kFiner * kFiner; ++i)
        sum += fine.At(kFiner * col + i % kFiner, kFiner * row + i / kFiner);
      scan.At(left + col, top + row) = sum / (kFiner * kFiner);
    }
  return scan;
}

class CrossPosition : public testing::Test {
 protected:
  // Paints the cross over the picture, scans, adds grain, and measures from a pixel beside it.
  std::optional<MeasuredCross> Measure(const Trial& trial, Image picture, const Vector2d& truth,
                                       bool by_lines = true) {
    std::mt19937 random(trial.seed);
    std::normal_distribution<float> grain(0, static_cast<float>(trial.noise));
    picture = trial.painted ? Scanned(trial, picture, truth) : GaussianBlur(picture, 0.6);
    for (float& value : picture.values) {
      value = std::clamp(value + grain(random), 0.0f, 255.0f);
      if (trial.dark) value = 255 - value;
    }
    WriteScan(folder_ / "a.png", picture);
    const Raster raster = Raster::Open(folder_ / "a.png");
    const Polarity polarity = trial.dark ? Polarity::kNegative : Polarity::kPositive;
    const Vector2d start = truth + Vector2d(0.6, -0.8);
    if (!by_lines) {
      const auto matched =
          MeasureMark(raster, trial.shape, trial.PixelFromMm(), start, polarity, kMaxShiftPx);
      if (!matched) return std::nullopt;
      return MeasuredCross{matched->pixel, matched->covariance, 0, 0};
    }
    return MeasureCross(raster, std::get<CrossElement>(trial.shape.drawing.elements[0]),
                        trial.PixelFromMm(), start, polarity, kMaxShiftPx);
  }

  // RMS of the errors over their sigmas of a reseau's thin crosses on picture texture, on films
  // that hardly turn, where a stroke lies alike in all its pixels.
  double NormalisedOnTexture(unsigned count) {
    double normalised = 0, squares = 0;
    int found = 0;
    for (unsigned i = 0; i < count; ++i) {
      Trial trial;
      trial.seed = 900 + i;
      trial.turn_rad = 0.002 + 0.004 * (i % 4);
      trial.shape.drawing.elements = {CrossElement{1.2, 0.04, 0, 0}};
      Image picture = RenderTexture(kSide, kSide, trial.seed);
      for (float& value : picture.values) value = 40 + 0.5f * value;
      const Vector2d truth(110 + 0.37 * i - std::floor(0.37 * i), 108.1 + 0.29 * (i % 7));
      const auto position = Measure(trial, GaussianBlur(picture, 1), truth);
      if (!position) continue;
      const Vector2d error = position->pixel - truth;
      squares += error.squaredNorm();
      normalised += error.cwiseAbs2().cwiseQuotient(position->covariance.diagonal()).sum();
      ++found;
    }
    EXPECT_GE(found, 0.9 * count);
    RecordProperty("rms_px", std::to_string(std::sqrt(squares / (2 * found))));
    const double rms = std::sqrt(normalised / (2 * found));
    RecordProperty("rms_normalised", std::to_string(rms));
    return rms;
  }

  TemporaryFolder folder_;
};
using SlowCrossPosition = CrossPosition;  // labelled slow by its name

Image HalfAndHalf(double edge_col) {
  Image picture(kSide, kSide, 60);
  for (int row = 0; row < kSide; ++row)
    for (int col = static_cast<int>(edge_col); col < kSide; ++col) picture.At(col, row) = 150;
  return picture;
}

TEST_F(CrossPosition, IsRightToItsSigmaAtEveryTurnAndInEitherPolarity) {
  double squares = 0, normalised = 0;
  int count = 0;
  for (unsigned i = 0; i < 40; ++i) {
    Trial trial;
    trial.seed = 100 + i;
    trial.noise = 8;
    trial.dark = i % 2 == 1;
    trial.turn_rad = 0.002 * (i % 40) - 0.04;
    trial.shape = ThinCross(i % 4 < 2 ? 0 : std::numbers::pi / 4);
    const Vector2d truth(110 + 0.13 * (i % 40), 108 - 0.29 * (i % 40));
    const auto found = Measure(trial, Image(kSide, kSide, 90), truth);
    ASSERT_TRUE(found) << i;
    const Vector2d error = found->pixel - truth;
    squares += error.squaredNorm();
    normalised += error.dot(found->covariance.inverse() * error);
    count += 2;
  }
  RecordProperty("rms_px", std::to_string(std::sqrt(squares / count)));
  RecordProperty("rms_normalised", std::to_string(std::sqrt(normalised / count)));
  EXPECT_LT(std::sqrt(squares / count), 0.02);
  EXPECT_GT(std::sqrt(normalised / count), 0.8);
  EXPECT_LT(std::sqrt(normalised / count), 1.25);
}

TEST_F(CrossPosition, OfThinStrokesOnPictureTextureIsRightToItsSigma) {
  const double rms = NormalisedOnTexture(60);
  EXPECT_GT(rms, 0.8);
  EXPECT_LT(rms, 1.25);
}

TEST_F(SlowCrossPosition, OfThinStrokesOnPictureTextureIsRightToItsSigma) {
  const double rms = NormalisedOnTexture(600);
  EXPECT_GT(rms, 0.8);
  EXPECT_LT(rms, 1.25);
}

TEST_F(CrossPosition, LiesBesideTheMarksCentreAndIsDarkWhereItIsDrawnSo) {
  for (const bool dark : {false, true}) {
    Trial trial;
    trial.brightness = 10;
    trial.dark = dark;
    trial.turn_rad = 0.03;
    auto& cross = std::get<CrossElement>(trial.shape.drawing.elements[0]);
    cross.at_mm = {0.3, -0.2};
    cross.brightness = -1;
    const Vector2d truth(110.3, 107.6);
    const auto found = Measure(trial, Image(kSide, kSide, 120), truth);
    ASSERT_TRUE(found) << dark;
    EXPECT_LT((found->pixel - truth).norm(), 0.03) << dark;
  }
}

TEST_F(CrossPosition, IsNotPulledToTheBrighterSideOfAStroke) {
  const Vector2d truth(110.3, 107.6);
  const Image picture = HalfAndHalf(truth.x());
  const auto lines = Measure({}, picture, truth), matched = Measure({}, picture, truth, false);
  ASSERT_TRUE(lines && matched);
  RecordProperty("matched_px", std::to_string(matched->pixel.x() - truth.x()));
  const double error = std::abs(lines->pixel.x() - truth.x());
  EXPECT_LT(error, 0.2);
  EXPECT_LT(error, 0.5 * std::abs(matched->pixel.x() - truth.x()));
  EXPECT_LT(error, 3 * std::sqrt(lines->covariance(0, 0)));
}

TEST_F(CrossPosition, BlotsOnTheStrokesAreOutliers) {
  const Vector2d truth(110.3, 107.6);
  Image picture(kSide, kSide, 90);
  for (int row = 0; row < kSide; ++row)
    for (int col = 0; col < kSide; ++col)
      for (const Vector2d& blot : {Vector2d(130, 111), Vector2d(88, 110), Vector2d(113, 80)})
        if ((Vector2d(col, row) - blot).norm() < 3.5) picture.At(col, row) = 250;
  const auto found = Measure({}, picture, truth);
  ASSERT_TRUE(found);
  EXPECT_LT((found->pixel - truth).norm(), 0.05);
}

// Rows of bright spots that lie off their line by `scatter_px`, column by column.
Image Scattered(const Vector2d& centre, double scatter_px) {
  Image picture(kSide, kSide, 90);
  std::mt19937 random(3);
  std::normal_distribution<double> off(0, scatter_px);
  for (int along = -48; along <= 48; ++along) {
    const int col = static_cast<int>(centre.x()), row = static_cast<int>(centre.y());
    const int across = static_cast<int>(std::lround(off(random)));
    for (int wide = -1; wide <= 1; ++wide) {
      picture.At(col + along, row + across + wide) = 235;
      picture.At(col + across + wide, row + along) = 235;
    }
  }
  return picture;
}

TEST_F(CrossPosition, ProfilesFarFromTheLineDoNotFitItHoweverMuchAllScatter) {
  Trial trial;
  trial.painted = false;
  const Vector2d truth(110.5, 107.5);
  const auto share = [&](double scatter_px) {
    const auto found = Measure(trial, Scattered(truth, scatter_px), truth);
    return found ? found->share : 0;
  };
  EXPECT_GT(share(0.2), 0.9);
  for (const double scatter_px : {1.5, 2.0}) EXPECT_LT(share(scatter_px), 0.75) << scatter_px;
}

TEST_F(CrossPosition, WithoutLinesThereIsNone) {
  Trial trial;
  trial.brightness = 90;  // of the picture: nothing is seen
  trial.noise = 0;
  EXPECT_FALSE(Measure(trial, Image(kSide, kSide, 90), {110, 108}));
}

// The drawing's outline and the spline between pixels err, though no grain shows it.
TEST_F(CrossPosition, WithoutGrainASigmaKeepsItsFloor) {
  Trial trial;
  trial.noise = 0;
  const auto found = Measure(trial, Image(kSide, kSide, 20), {110.3, 108.6}, false);
  ASSERT_TRUE(found);
  EXPECT_GE(std::sqrt(found->covariance.diagonal().minCoeff()), 0.0005);
}

}  // namespace
}  // namespace orient::interior
