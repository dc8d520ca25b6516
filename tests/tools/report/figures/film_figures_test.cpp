#include "tools/report/figures/film_figures.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/tools/report/example_block.h"

namespace orient {
namespace {

TEST(FilmFigures, SpreadIsThatOfASample) {
  EXPECT_FALSE(MeanAndSpreadOf({}));
  EXPECT_FALSE(MeanAndSpreadOf({7})->spread);
  const auto two = MeanAndSpreadOf({1, 3});
  EXPECT_EQ(two->mean, 2);
  EXPECT_NEAR(*two->spread, std::sqrt(2.0), 1e-12);
}

TEST(FilmFigures, PixelSizesMakeRollsOfTheirOwn) {
  const InteriorResult fine = ExampleInterior("1"), other = ExampleInterior("2");
  InteriorResult coarse = ExampleInterior("3"), none = ExampleInterior("4");
  coarse.photo_from_pixel = Affine2d{Eigen::Vector2d(0.05, -0.05).asDiagonal(), {-25, 25}};
  none.photo_from_pixel.reset();
  const auto rolls = FilmRolls({&fine, &other, &coarse, &none, nullptr});
  ASSERT_EQ(rolls.size(), 2u);
  EXPECT_EQ(rolls[0].photos, 2);
  EXPECT_EQ(rolls[0].last, "2");
  EXPECT_EQ(rolls[0].marks_used, 2);
  EXPECT_NEAR(rolls[1].column_um.mean, 50, 1e-9);
}

}  // namespace
}  // namespace orient
