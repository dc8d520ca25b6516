#include "interior/orientation/film_transform.h"

#include <gtest/gtest.h>

namespace orient::interior {
namespace {

using Eigen::Vector2d;

constexpr double kPixelMm = 0.025;
constexpr double kExactUm = 1e-9;

// Marks at these places on an upright scan of 1000 px a side.
std::vector<MeasuredMark> MarksAt(const std::vector<Vector2d>& places_mm) {
  std::vector<MeasuredMark> marks;
  for (const Vector2d& mm : places_mm)
    marks.push_back({{500 + mm.x() / kPixelMm, 500 - mm.y() / kPixelMm}, mm});
  return marks;
}

TEST(FilmTransform, FourMarksGiveAnAffineThatFits) {
  const auto film = FitFilm(MarksAt({{-10, -10}, {10, -10}, {10, 10}, {-10, 10}}), false);
  ASSERT_TRUE(film);
  EXPECT_TRUE(film->affine);
  EXPECT_NEAR(film->sigma0_um, 0, kExactUm);
  EXPECT_NEAR(film->pixel_um, 25, kExactUm);
}

TEST(FilmTransform, ResidualsAreCalibratedMinusTransformedMarks) {
  auto marks = MarksAt({{-10, -10}, {10, -10}, {10, 10}, {-10, 10}});
  marks[0].pixel += Vector2d(0.4, 0.8);  // 10 um to the right, 20 um down: the affine keeps 3/4
  const auto film = FitFilm(marks, false);
  ASSERT_TRUE(film);
  EXPECT_LT(film->residual_um[0].x(), 0);
  EXPECT_GT(film->residual_um[0].y(), 0);
}

TEST(FilmTransform, ThreeMarksGiveASimilarity) {
  const auto film = FitFilm(MarksAt({{-10, -10}, {10, -10}, {10, 10}}), false);
  ASSERT_TRUE(film);
  EXPECT_FALSE(film->affine);
  EXPECT_NEAR(film->pixel_um, 25, kExactUm);
}

TEST(FilmTransform, TwoMarksAreTooFew) {
  EXPECT_FALSE(FitFilm(MarksAt({{-10, -10}, {10, 10}}), false));
}

TEST(FilmTransform, MarksOnOneLineGiveNone) {
  EXPECT_FALSE(FitFilm(MarksAt({{-10, 10}, {0, 10}, {10, 10}}), false));
  auto noisy = MarksAt({{-10, 10}, {-3, 10.02}, {3, 9.98}, {10, 10}});
  noisy[1].pixel += Vector2d(0.1, -0.1);
  EXPECT_FALSE(FitFilm(noisy, false)) << "noise is not a second direction";
}

TEST(FilmTransform, MarksAtOnePlaceGiveNone) {
  EXPECT_FALSE(FitFilm(MarksAt({{5, 5}, {5, 5}, {5, 5}, {5, 5}}), false));
}

}  // namespace
}  // namespace orient::interior
