#include "core/raster/overviews.h"

#include <gtest/gtest.h>

#include "tests/core/raster/gdal_writer.h"
#include "tests/support/shared_data.h"

namespace orient {
namespace {

TEST(Overviews, TheCoarsestIsTold) {
  const TemporaryFolder folder;
  RasterRecipe recipe;
  recipe.value = [](int, double x, double) { return x; };
  WriteRaster(folder / "without.tif", recipe);
  EXPECT_EQ(CoarsestOverview(folder / "without.tif"), 1);
  recipe.overviews = {2, 4};
  WriteRaster(folder / "with.tif", recipe);
  EXPECT_EQ(CoarsestOverview(folder / "with.tif"), 4);
  EXPECT_EQ(CoarsestOverview(folder / "gone.tif"), 1);
}

}  // namespace
}  // namespace orient
