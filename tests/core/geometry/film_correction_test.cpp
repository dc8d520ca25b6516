#include "core/geometry/film_correction.h"

#include <gtest/gtest.h>

namespace orient {
namespace {

using Eigen::Vector2d;

// A correction that is linear in col and row, which a bilinear grid holds exactly.
Vector2d Linear(const Vector2d& pixel) {
  return {0.01 + 1e-5 * pixel.x(), -0.02 + 2e-5 * pixel.y()};
}

FilmCorrection Grid() {
  FilmCorrection grid;
  grid.origin_px = {100, 200};
  grid.step_px = {300, 250};
  grid.columns = 4;
  grid.rows = 3;
  for (int row = 0; row < grid.rows; ++row)
    for (int col = 0; col < grid.columns; ++col)
      grid.correction_mm.push_back(
          Linear(grid.origin_px + grid.step_px.cwiseProduct(Vector2d(col, row))));
  return grid;
}

TEST(FilmCorrection, ALinearCorrectionIsHeldExactly) {
  const FilmCorrection grid = Grid();
  for (const Vector2d& pixel : {Vector2d(100, 200), Vector2d(517.3, 401.9), Vector2d(1000, 700)})
    EXPECT_LT((grid.At(pixel) - Linear(pixel)).norm(), 1e-15);
}

TEST(FilmCorrection, BeyondTheGridItsBorderCounts) {
  const FilmCorrection grid = Grid();
  EXPECT_EQ(grid.At({-500, 300}), grid.At({100, 300}));
  EXPECT_EQ(grid.At({5000, 9000}), grid.At({1000, 700}));
}

TEST(FilmCorrection, TheWayBackEndsWhereItBegan) {
  const FilmCorrection grid = Grid();
  Affine2d affine;
  affine.A << 0.0249, 1e-4, 2e-4, -0.0251;
  affine.t << -20, 30;
  for (const Vector2d& pixel : {Vector2d(0, 0), Vector2d(333, 650), Vector2d(990, 210)}) {
    const Vector2d photo = PhotoFromPixel(affine, &grid, pixel);
    EXPECT_LT((photo - (affine * pixel + grid.At(pixel))).norm(), 1e-15);
    EXPECT_LT((PixelFromPhoto(affine, &grid, photo) - pixel).norm(), 1e-9);
    EXPECT_LT((PixelFromPhoto(affine, nullptr, affine * pixel) - pixel).norm(), 1e-9);
  }
}

TEST(FilmCorrection, AGridThatIsNotFullIsABrokenPromise) {
  FilmCorrection grid = Grid();
  grid.correction_mm.pop_back();
  EXPECT_THROW(grid.At({0, 0}), std::invalid_argument);
}

}  // namespace
}  // namespace orient
