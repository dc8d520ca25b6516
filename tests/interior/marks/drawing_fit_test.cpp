// Drawings fitted to marks whose drawing is known: simulated films with one of the usual marks in
// all corners, clicked a pixel or two beside them.
#include "interior/marks/drawing_fit.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <numbers>

#include "interior/marks/mark_drawing.h"
#include "tests/support/film_frame.h"

namespace orient::interior {
namespace {

using Eigen::Vector2d;
using Elements = std::vector<MarkElement>;

struct Film {
  FilmFrame frame;
  std::vector<SeenMark> seen;
};

// `clicked_px`: the clicks are off by up to so much.
Film FilmOf(const Elements& elements, double pixel_mm, double clicked_px = 1.5,
            MarkBackground background = MarkBackground::kDark) {
  FilmFrameSpec spec;
  spec.camera = RingCamera(25, 60);
  spec.camera.marks["corner"] = {elements, background, std::nullopt};
  spec.pixel_mm = pixel_mm;
  spec.dark_corners = background == MarkBackground::kDark;
  Film film{RenderFilmFrame(spec), {}};
  for (size_t i = 0; i < 2; ++i) {  // enough, and quicker than four
    const double sign = i % 2 == 0 ? 1 : -1;
    const Vector2d near = film.frame.mark_pixels[i] + Vector2d(clicked_px, -sign * clicked_px);
    film.seen.push_back({film.frame.scan, near, film.frame.pixel_from_photo.A, 4});
  }
  return film;
}

// How alike two drawings look, as the scans show them.
double Likeness(const Elements& a, const Elements& b) {
  const FittedDrawing located = [&] {
    const Film film = FilmOf(a, 0.04, 0);
    return LocateDrawing(b, {film.seen.begin(), film.seen.begin() + 1});
  }();
  return located.correlation.front();
}

void ExpectFitted(const Elements& truth, double pixel_mm) {
  const Film film = FilmOf(truth, pixel_mm);
  const auto fitted = FitDrawing(film.seen);
  ASSERT_TRUE(fitted);
  EXPECT_GT(Likeness(truth, fitted->elements), 0.93);
  for (size_t i = 0; i < film.seen.size(); ++i) {
    EXPECT_LT((fitted->centre[i] - film.frame.mark_pixels[i]).norm(), 0.25) << i;
    EXPECT_GT(fitted->correlation[i], 0.9) << i;
  }
}

TEST(SlowFitDrawing, FindsACross) { ExpectFitted({CrossElement{2.4, 0.12, 0, 0}}, 0.06); }

TEST(FitDrawing, FindsADiagonalOpenCrossInACircle) {
  ExpectFitted({CircleElement{1.7, 0.2}, CrossElement{3.52, 0.13, 0.56, std::numbers::pi / 4}},
               0.07);
}

TEST(SlowFitDrawing, FindsACircleWithADot) {
  ExpectFitted({CircleElement{2.0, 0.15}, DotElement{0.2}}, 0.06);
}

TEST(FitDrawing, FindsASmallDot) { ExpectFitted({DotElement{0.25}}, 0.06); }

TEST(SlowFitDrawing, FindsADarkCrossOnADisc) {
  CrossElement cross{1.2, 0.1, 0, 0};
  cross.brightness = 0;
  ExpectFitted({DotElement{1.6}, cross}, 0.06);
}

TEST(SlowFitDrawing, FindsAWedge) {
  ExpectFitted({WedgeElement{1.4, 1.4, std::numbers::pi / 2}}, 0.06);
}

TEST(SlowFitDrawing, LengthsAreThoseOfTheMark) {
  const auto fitted = FitDrawing(FilmOf({CrossElement{2.4, 0.12, 0, 0}}, 0.06).seen);
  ASSERT_TRUE(fitted);
  ASSERT_EQ(fitted->elements.size(), 1u);
  const auto* cross = std::get_if<CrossElement>(fitted->elements.data());
  ASSERT_NE(cross, nullptr);
  EXPECT_NEAR(cross->length_mm, 2.4, 0.1);
  EXPECT_NEAR(cross->width_mm, 0.12, 0.04);
  EXPECT_EQ(cross->angle_rad, 0);
}

TEST(FitDrawing, OfNothingIsNone) { EXPECT_FALSE(FitDrawing({})); }

TEST(FitDrawing, OfAnEvenGroundIsNone) {
  SeenMark even;
  even.image = Image(400, 400, 100);
  even.near = {200, 200};
  even.pixel_from_mm = Eigen::DiagonalMatrix<double, 2>(1 / 0.03, -1 / 0.03);
  EXPECT_FALSE(FitDrawing({even}));
}

}  // namespace
}  // namespace orient::interior
