#include "ortho/frame_table.h"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include "tests/support/generators.h"
#include "tests/support/hilly_view.h"

namespace orient::ortho {
namespace {

using Eigen::Vector2d;

// The table against what it tabulates, all over the frame.
double LargestError(const PhotoView& view) {
  const FrameTable table(view, 0);
  double largest = 0;
  EXPECT_TRUE(rc::check("the table is what it tabulates", [&] {
    const Vector2d half = 0.499 * view.camera.frame_mm;
    const Vector2d photo_mm = view.camera.frame_centre_mm + Vector2d(*InRange(-half.x(), half.x()),
                                                                     *InRange(-half.y(), half.y()));
    const auto ideal = UndistortPoint(view.camera.lens, photo_mm - view.camera.principal_point_mm);
    RC_ASSERT(ideal.has_value());
    const auto pixel = table.PixelOf(*ideal);
    RC_ASSERT(pixel.has_value());
    largest = std::max(largest, (*pixel - view.PixelFromPhoto(photo_mm)).norm());
  }));
  return largest;
}

TEST(FrameTable, IsExactToTwoHundredthsOfAPixel) {
  PhotoView view = HillyView();
  view.photo_from_pixel.A << 0.0001, -0.01, -0.01, -0.0001;  // 10 um: the finest scans
  FilmCorrection film = *view.film_correction;               // bends by 0.1 mm in 105 mm
  film.step_px = {10500, 10500};
  view.film_correction = std::make_shared<const FilmCorrection>(film);
  EXPECT_LT(LargestError(view), 0.02);
  view.camera.lens = RadialTable{{0, 40, 80, 120, 150}, {0, 6, -4, 12, -20}};
  EXPECT_LT(LargestError(view), 0.02) << "with kinks";
  view.camera.lens = std::monostate();
  EXPECT_LT(LargestError(view), 0.02);
}

TEST(FrameTable, NothingIsSeenOutsideTheFrameAndInItsBorder) {
  PhotoView view = HillyView();
  view.camera.lens = std::monostate();
  const FrameTable all(view, 0), inner(view, 5);
  const auto at = [&](double x_mm) -> Vector2d {
    return Vector2d(x_mm, 0) - view.camera.principal_point_mm;
  };
  EXPECT_TRUE(all.PixelOf(at(99.9)));
  EXPECT_FALSE(all.PixelOf(at(100.1)));
  EXPECT_TRUE(inner.PixelOf(at(94.9)));
  EXPECT_FALSE(inner.PixelOf(at(95.1)));
  EXPECT_FALSE(all.PixelOf(at(1e9)));
  EXPECT_FALSE(all.PixelOf({std::nan(""), 0}));
}

TEST(FrameTable, MarksAreNotSeen) {
  PhotoView view = HillyView();
  view.camera.lens = std::monostate();
  const FrameTable table(view, 0, {{-50.1, -20, -49.9, 20}, {60, 60, 100, 100}});
  const auto at = [&](double x_mm, double y_mm) -> Vector2d {
    return Vector2d(x_mm, y_mm) - view.camera.principal_point_mm;
  };
  EXPECT_FALSE(table.PixelOf(at(-50, 0))) << "thinner than the table's cells";
  EXPECT_TRUE(table.PixelOf(at(-50.2, 0)));
  EXPECT_TRUE(table.PixelOf(at(-50, 20.1)));
  EXPECT_FALSE(table.PixelOf(at(80, 60.1)));
  EXPECT_TRUE(table.PixelOf(at(80, 59.9)));
}

// A lens whose model folds over shows points far outside once more within the frame.
TEST(FrameTable, WhatALensFoldsBackIntoTheFrameIsNotSeen) {
  PhotoView view = HillyView();
  view.camera.lens = BrownDistortion{{-1e-5, 0, 0}, {0, 0}};
  view.camera.frame_mm = {150, 150};
  const FrameTable table(view, 0);
  const Vector2d beyond(230, 0);  // folded: 230 (1 - 1e-5 230^2) = 108, about where 125 lies
  EXPECT_FALSE(InsideFold(view.camera.lens, beyond));
  EXPECT_FALSE(table.PixelOf(beyond));
}

TEST(FrameTable, ABorderWiderThanTheFrameLeavesNothing) {
  EXPECT_FALSE(FrameTable(HillyView(), 150).PixelOf({10, 10}));
}

}  // namespace
}  // namespace orient::ortho
