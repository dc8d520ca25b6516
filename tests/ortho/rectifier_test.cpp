#include "ortho/rectifier.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/raster/band_raster.h"
#include "tests/support/dem_files.h"
#include "tests/support/hilly_view.h"
#include "tests/support/shared_data.h"

namespace orient::ortho {
namespace {

// By how many pixels places are off at most, where they are interpolated between others.
double WorstPx(const GroundSurface& surface, const MapGrid& grid) {
  const TemporaryFolder folder;
  const PhotoView view = HillyView();
  WriteScan(folder / "a.tif", view, surface, [](double, double) { return 100.0; });
  const BandRaster scan = BandRaster::Open(folder / "a.tif");
  const Rectifier rectifier(view, surface, scan, {});
  const PixelWindow all{0, 0, grid.width, grid.height};
  const Rectifier::Places places = rectifier.PlacesOf(grid, all);
  double worst = 0;
  int seen = 0;
  for (int row = 0, i = 0; row < all.height; ++row)
    for (int col = 0; col < all.width; ++col, ++i) {
      if (places.shown[static_cast<std::size_t>(i)] != Shown::kSeen) continue;
      const Eigen::Vector2d at = grid.GroundFromPixel(col + 0.5, row + 0.5);
      const auto truth =
          view.PixelFromGround({at.x(), at.y(), surface.HeightAt(at.x(), at.y()).value()});
      worst = std::max(worst, (places.scan_px[static_cast<std::size_t>(i)] - *truth).norm());
      ++seen;
    }
  EXPECT_GT(seen, all.width * all.height / 2);
  return worst;
}

// Heights that go up and down from column to column and are random besides, in cells of these sides
// around the view.
GroundSurface Rough(const std::string& stem, double cell_x, double cell_y, double reach_m) {
  const Eigen::Vector3d centre = HillyView().pose.position_m;
  DemFile dem;
  dem.cell_x = cell_x;
  dem.cell_y = cell_y;
  dem.west = centre.x() - reach_m;
  dem.north = centre.y() + reach_m;
  dem.heights.resize(static_cast<Eigen::Index>(2 * reach_m / cell_y),
                     static_cast<Eigen::Index>(2 * reach_m / cell_x));
  std::mt19937 random(5);
  std::uniform_real_distribution<float> height(99.99f, 100.01f);
  for (Eigen::Index row = 0; row < dem.heights.rows(); ++row)
    for (Eigen::Index col = 0; col < dem.heights.cols(); ++col)
      dem.heights(row, col) = height(random) + (col % 2 == 0 ? 20.0f : -20.0f);
  const Bounds around{centre.x() - 600, centre.y() - 600, centre.x() + 600, centre.y() + 600};
  return GroundSurface::FromFile(WriteDem(stem, dem), Crs::Parse("EPSG:32635", "test"), around);
}

TEST(Rectifier, InterpolatedPlacesAreThoseComputedOneByOne) {
  const TemporaryFolder folder;
  const Eigen::Vector3d centre = HillyView().pose.position_m;
  const MapGrid grid =
      MapGrid::Around({centre.x() - 250, centre.y() - 250, centre.x() + 250, centre.y() + 250}, 2);
  EXPECT_LT(WorstPx(Rough(folder / "square", 60, 60, 3000), grid), 0.05);
  EXPECT_LT(WorstPx(Rough(folder / "long_to_the_north", 8, 2000, 4000), grid), 0.05);
  EXPECT_LT(WorstPx(Rough(folder / "long_to_the_east", 2000, 8, 4000), grid), 0.05);
}

TEST(Rectifier, DrawsCoarsePixelsInPartsAsInOne) {
  const TemporaryFolder folder;
  const PhotoView view = HillyView();
  const GroundSurface surface = Hills();
  WriteScan(folder / "a.tif", view, surface,
            [](double x, double y) { return 100 + 50 * std::sin(x / 90) * std::cos(y / 70); });
  const BandRaster scan = BandRaster::Open(folder / "a.tif");
  const Eigen::Vector2d centre = view.pose.position_m.head<2>();
  const MapGrid grid =
      MapGrid::Around({centre.x() - 250, centre.y() - 250, centre.x() + 250, centre.y() + 250}, 25);
  const PixelWindow all{0, 0, grid.width, grid.height};
  const OrthoTile one = Rectifier(view, surface, scan, {}).Draw(grid, all);
  RectifierOptions little;
  little.most_values = 3000;
  const OrthoTile parts = Rectifier(view, surface, scan, little).Draw(grid, all);
  EXPECT_EQ(parts.shown, one.shown);
  for (std::size_t i = 0; i < one.shown.size(); ++i)
    if (one.shown[i] == Shown::kSeen) {
      EXPECT_NEAR(parts.values[0].values[i], one.values[0].values[i], 1.5);
    }
}

}  // namespace
}  // namespace orient::ortho
