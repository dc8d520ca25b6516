// Fields of crop rows and car parks: what a harvest takes from them must not be mistaken for its
// neighbours.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iostream>
#include <random>
#include <vector>

#include "core/matching/correlation.h"
#include "core/raster/resample.h"
#include "patchdb/harvest/harvest.h"
#include "tests/patchdb/harvest/synthetic_ground.h"
#include "tests/support/shared_data.h"

namespace orient::patchdb {
namespace {

constexpr double kGsd_m = 0.25;
constexpr int kSide_px = 1600;
constexpr double kPlot_m = 100;
constexpr int kPlots = 4;           // a side
constexpr int kSearch_px = 40;      // 10 m, what a flight with GNSS leaves open
constexpr double kItself_px = 1.5;  // half of the shortest distance between two rows

enum class PlotKind { kRows, kParking };

// What grows or stands on a square of ground, always the same in itself.
struct Plot {
  PlotKind kind = PlotKind::kRows;
  double across_x = 1, across_y = 0;  // direction across the rows
  double period_m = 2, phase_m = 0;
  double contrast = 30, base = 110;
  std::vector<float> cars;  // brightness above the ground by bay; 0: empty
};

// Crop rows 0.75 to 8 m apart, and cars in bays of 2.5 x 5 m, in two rows nose to nose beside a
// lane.
class RepeatedGround {
 public:
  explicit RepeatedGround(unsigned seed) : soil_(seed), random_(seed) {
    for (int i = 0; i < kPlots * kPlots; ++i) plots_.push_back(MakePlot());
  }

  // `x`, `y`: metres east and south of the north-west corner.
  double At(double x, double y) const {
    const int col = std::clamp(static_cast<int>(x / kPlot_m), 0, kPlots - 1);
    const int row = std::clamp(static_cast<int>(y / kPlot_m), 0, kPlots - 1);
    const Plot& plot = plots_[static_cast<std::size_t>(row * kPlots + col)];
    return plot.base + (plot.kind == PlotKind::kRows ? Rows(plot, x, y) : Cars(plot, x, y));
  }

  // The soil shows through everywhere, weaker than the noise; metres across at the finest.
  double Soil(double x, double y) const {
    return 0.01 * (static_cast<double>(soil_.At(3 * x, 3 * y)) - 127.5);
  }

 private:
  double Uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }

  Plot MakePlot() {
    Plot plot;
    plot.kind = Uniform(0, 1) < 0.5 ? PlotKind::kRows : PlotKind::kParking;
    const double angle = Uniform(0, M_PI);
    plot.across_x = std::cos(angle);
    plot.across_y = std::sin(angle);
    plot.period_m = plot.kind == PlotKind::kRows ? 0.75 * std::pow(8 / 0.75, Uniform(0, 1)) : 2.5;
    plot.phase_m = Uniform(0, 10);
    plot.contrast = Uniform(10, 40);
    plot.base = Uniform(90, 150);
    // From a dealer's yard full of one model to an office's on a Monday.
    const double typical = Uniform(-60, 60), variety = Uniform(0, 60), empty = Uniform(0, 0.3);
    for (int bay = 0; bay < 1000; ++bay)
      plot.cars.push_back(
          Uniform(0, 1) < empty ? 0 : static_cast<float>(typical + Uniform(-variety, variety)));
    return plot;
  }

  static double Rows(const Plot& plot, double x, double y) {
    const double across = plot.across_x * x + plot.across_y * y + plot.phase_m;
    return plot.contrast * std::sin(2 * M_PI * across / plot.period_m);
  }

  static double Cars(const Plot& plot, double x, double y) {
    constexpr double kDepth = 16;  // two bays and the lane
    const double u = plot.across_x * x + plot.across_y * y + 1000;
    const double v = -plot.across_y * x + plot.across_x * y + 1000;
    const double in_bay = std::fmod(u, plot.period_m), deep = std::fmod(v, kDepth);
    if (deep > 10) return -10;
    if (in_bay < 0.15 || std::abs(deep - 5) < 0.08) return 60;  // painted
    const double along = std::fmod(deep, 5);
    if (in_bay < 0.45 || in_bay > 2.2 || along < 0.4 || along > 4.6) return -10;
    const auto bay = static_cast<std::size_t>(u / plot.period_m) * 31 +
                     static_cast<std::size_t>(v / kDepth) * 2 + (deep < 5 ? 1 : 0);
    const float car = plot.cars[bay % plot.cars.size()];
    return car == 0 ? -10 : car;
  }

  SyntheticTexture soil_;
  std::mt19937 random_;
  std::vector<Plot> plots_;
};

// One exposure: pixels average what they cover; each has noise, gain and offset of its own.
Image Exposure(const RepeatedGround& ground, double gain, double offset, unsigned seed) {
  constexpr int kSamples = 3;
  constexpr float kNoise = 4;
  std::mt19937 random(seed);
  std::normal_distribution<float> noise(0, kNoise);
  Image image(kSide_px, kSide_px);
  for (int row = 0; row < kSide_px; ++row)
    for (int col = 0; col < kSide_px; ++col) {
      double sum = 0;
      for (int down = 0; down < kSamples; ++down)
        for (int across = 0; across < kSamples; ++across)
          sum += ground.At((col + (across + 0.5) / kSamples) * kGsd_m,
                           (row + (down + 0.5) / kSamples) * kGsd_m);
      const double soil = ground.Soil((col + 0.5) * kGsd_m, (row + 0.5) * kGsd_m);
      const double grey = offset + gain * (soil + sum / (kSamples * kSamples));
      image.At(col, row) = std::clamp(static_cast<float>(grey) + noise(random), 1.0f, 255.0f);
    }
  return image;
}

// Whether the middle of the chip fits best where it was cut, of all places within the search.
bool FindsItself(const Patch& patch, const Image& image, int window_px) {
  const Eigen::Vector2d pixel((patch.ground_m.x() - kWest) / kGsd_m,
                              (kNorth - patch.ground_m.y()) / kGsd_m);
  const int half = window_px / 2 + kSearch_px;
  const Eigen::Vector2i first = pixel.array().floor().cast<int>() - half;
  Image around(2 * half + 1, 2 * half + 1, kNoData);
  for (int row = 0; row < around.height; ++row)
    for (int col = 0; col < around.width; ++col)
      if (first.x() + col >= 0 && first.y() + row >= 0 && first.x() + col < image.width &&
          first.y() + row < image.height)
        around.At(col, row) = image.At(first.x() + col, first.y() + row);
  const Image scores = Correlate(MiddleOf(patch.chip, window_px, window_px), around);
  const auto peaks = FindPeaks(scores, 1, 1, 0);
  if (peaks.empty()) return false;
  const Eigen::Vector2d found =
      peaks[0].position + first.cast<double>() + Eigen::Vector2d::Constant(0.5 * window_px);
  return (found - pixel).norm() <= kItself_px;
}

struct Taken {
  int patches = 0, strays = 0, refused = 0;
};

// What a harvest of one exposure accepts, and another exposure shows a neighbour of.
void Count(const Raster& ortho, const Image& other, int window_px, const HarvestOptions& options,
           Taken* taken) {
  const HarvestResult harvest =
      HarvestOrtho(ortho, Crs::Parse("EPSG:32635", "test"), SyntheticSurface(), options);
  taken->patches += static_cast<int>(harvest.patches.size());
  taken->refused += harvest.Refused(Refusal::kRepetitive);
  for (const Patch& patch : harvest.patches)
    taken->strays += FindsItself(patch, other, window_px) ? 0 : 1;
}

double Percent(const char* what, const Taken& taken) {
  const double percent = 100.0 * taken.strays / taken.patches;
  std::cout << what << ": " << taken.strays << " of " << taken.patches << " (" << percent
            << " %) taken for a neighbour, " << taken.refused << " refused as repetitive\n";
  return percent;
}

TEST(SlowRepeatedTexture, GivesFewPatchesThatAreTakenForTheirNeighbours) {
  constexpr int kGrounds = 3;
  Taken small, whole, unrefused;
  HarvestOptions anything;
  anything.min_distinctness = 0;
  for (unsigned i = 0; i < kGrounds; ++i) {
    const unsigned seed = TestSeed() + 10 * i;
    const RepeatedGround ground(seed);
    TemporaryFolder folder;
    Affine2d map_from_pixel;
    map_from_pixel.A << kGsd_m, 0, 0, -kGsd_m;
    map_from_pixel.t << kWest, kNorth;
    WriteOrtho(folder / "ortho.png", Exposure(ground, 1, 0, seed + 1), map_from_pixel,
               "EPSG:32635");
    const Raster ortho = Raster::Open(folder / "ortho.png");
    const Image other = Exposure(ground, 0.7, 30, seed + 2);
    Count(ortho, other, 31, {}, &small);
    Count(ortho, other, 61, {}, &whole);
    Count(ortho, other, 31, anything, &unrefused);
  }
  EXPECT_GT(small.patches, 100 * kGrounds);
  EXPECT_LE(Percent("31 px of the chips", small), 2);
  EXPECT_LE(Percent("61 px", whole), 2);
  EXPECT_GT(Percent("31 px, nothing refused", unrefused), 2) << "this ground shows nothing";
}

}  // namespace
}  // namespace orient::patchdb
