// Real photos: our orthophotos of the four NGI frames beside those that were published.
#include <gtest/gtest.h>

#include <algorithm>
#include <iostream>

#include "core/matching/correlation.h"
#include "core/raster/raster.h"
#include "tests/support/ngi.h"
#include "tests/support/run_orient.h"
#include "tests/support/shared_data.h"

namespace orient {
namespace {

using Eigen::Vector2d;

// How far the published orthophoto shows what ours shows from where, px of 5 m, on a grid.
std::vector<double> Shifts(const Raster& ours, const Raster& published) {
  constexpr int kSide = 31, kReach = 4, kStep = 25;
  constexpr double kAlike = 0.8;
  const auto g = ours.GeoTransform().value(), p = published.GeoTransform().value();
  const Image all = ours.ReadGrey().image;
  std::vector<double> shifts;
  for (int row = 0; row + kSide < all.height; row += kStep)
    for (int col = 0; col + kSide < all.width; col += kStep) {
      Image part(kSide, kSide);
      for (int r = 0; r < kSide; ++r) std::copy_n(all.Row(row + r) + col, kSide, part.Row(r));
      const Vector2d corner((g[0] + g[1] * col - p[0]) / p[1], (g[3] + g[5] * row - p[3]) / p[5]);
      const Eigen::Vector2i first = corner.array().floor().matrix().cast<int>();
      const PixelWindow window{first.x() - kReach, first.y() - kReach, kSide + 2 * kReach,
                               kSide + 2 * kReach};
      const Image there = published.ReadGrey(window).image;
      const auto peaks = FindPeaks(Correlate(part, there, 1), 1, 1, kAlike);
      if (peaks.empty()) continue;
      const Vector2d found = Vector2d(window.col, window.row) + peaks.front().position;
      shifts.push_back((found - corner).norm());
    }
  std::sort(shifts.begin(), shifts.end());
  return shifts;
}

// The published ones agree with their own photos, by the published orientation and this DEM, to 0.3
// to 0.6 px, and the fourth is shifted (ngi_test.cpp): no orthophoto can agree with them better.
TEST(SlowNgiOrthophotos, AgreeWithThePublishedOnesAsWellAsThoseDoWithTheirPhotos) {
  ORIENT_REQUIRE_SHARED_DATA(folder, "ngi");
  const Ngi ngi(folder);
  const TemporaryFolder out;
  const ProgramRun run = RunOrient(
      {"ortho", folder + "/published_orientation.csv", folder + "/photos/*", "--camera",
       folder + "/camera.toml", "--dem", folder + "/dem.tif", "--gsd-m", "5", "--out", out.Path()});
  ASSERT_EQ(run.exit_code, 0) << run.err << run.out;
  for (const std::string number : {"0182", "0184", "0251", "0253"}) {
    const std::string name = PhotoName(ngi.Photo(number));
    const auto shifts =
        Shifts(Raster::Open(out / (name + ".ortho.tif")), Raster::Open(ngi.Orthophoto(number)));
    ASSERT_GT(shifts.size(), 1000U) << number;
    const double median = shifts[shifts.size() / 2], most = shifts[shifts.size() * 95 / 100];
    std::cout << number << ": " << shifts.size() << " places, median " << median << " px, 95 % "
              << most << " px\n";
    EXPECT_LT(median, number == "0253" ? 0.75 : 0.5);
    EXPECT_LT(most, 1.8);
  }
}

}  // namespace
}  // namespace orient
