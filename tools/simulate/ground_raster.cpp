#include "tools/simulate/ground_raster.h"

#include <tbb/parallel_for.h>

#include "tools/simulate/ground_tone.h"
#include "tools/simulate/noise.h"
#include "tools/simulate/object_drawing.h"

namespace orient::simulation {
namespace {

constexpr int kBandRows = 64;  // a multiple of GroundRaster::tile

std::uint16_t Quantise(float value, float scale) {
  return static_cast<std::uint16_t>(std::clamp(value * scale + 0.5f, 0.0f, 65535.0f));
}

constexpr int kSlowStep = 6;  // cells between places at which slow things are computed

// Slow fields at every kSlowStep-th cell of a row of places, one more than needed on the right.
std::vector<SlowField> SlowRow(const GroundTone& tones, const GroundBand& band, int row) {
  std::vector<SlowField> slow;
  const float y = band.north - (static_cast<float>(row) + 0.5f) * band.cell;
  for (int col = 0; col < band.width + kSlowStep; col += kSlowStep)
    slow.push_back(tones.SlowAt(band.west + (static_cast<float>(col) + 0.5f) * band.cell, y));
  return slow;
}

SlowField Between(const SlowField& a, const SlowField& b, float f) {
  return {a.bend_x + f * (b.bend_x - a.bend_x), a.bend_y + f * (b.bend_y - a.bend_y),
          a.soil + f * (b.soil - a.soil)};
}

// Tones of the bare ground, lit by the sun.
void PaintGround(const GroundTone& tones, const Terrain& terrain, const Eigen::MatrixXf& shading,
                 const GroundRaster& raster, int first_row, GroundBand* band) {
  std::vector<SlowField> above, below;
  for (int row = 0; row < band->height; ++row) {
    if (row % kSlowStep == 0) {
      above = SlowRow(tones, *band, row);
      below = SlowRow(tones, *band, row + kSlowStep);
    }
    const float f = static_cast<float>(row % kSlowStep) / kSlowStep;
    const double north = raster.north - (first_row + row + 0.5) * raster.cell;
    const float y = band->north - (static_cast<float>(row) + 0.5f) * band->cell;
    for (int col = 0; col < band->width; ++col) {
      const auto place = static_cast<size_t>(col / kSlowStep);
      const SlowField slow = Between(Between(above[place], below[place], f),
                                     Between(above[place + 1], below[place + 1], f),
                                     static_cast<float>(col % kSlowStep) / kSlowStep);
      const double east = raster.west + (col + 0.5) * raster.cell;
      const float x = band->west + (static_cast<float>(col) + 0.5f) * band->cell;
      const auto light = static_cast<float>(terrain.Bilinear(shading, east, north));
      band->tone.push_back(tones.At(x, y, slow) * light);
    }
  }
}

GroundBand EmptyBand(const Scene& scene, const GroundRaster& raster, int first_row) {
  GroundBand band;
  band.cell = static_cast<float>(raster.cell);
  band.west = static_cast<float>(raster.west - scene.extent.min_x);
  band.north = static_cast<float>(raster.north - first_row * raster.cell - scene.extent.min_y);
  band.width = raster.width;
  band.height = std::min(kBandRows, raster.height - first_row);
  const size_t cells = static_cast<size_t>(band.width) * static_cast<size_t>(band.height);
  band.tone.reserve(cells);
  band.object_m.assign(cells, 0.0f);
  return band;
}

void Store(const GroundBand& band, int first_row, GroundRaster* raster) {
  const auto width = static_cast<size_t>(raster->width);
  for (int row = 0; row < band.height; ++row)
    for (size_t col = 0; col < width; ++col) {
      const size_t from = static_cast<size_t>(row) * width + col;
      const size_t to = static_cast<size_t>(first_row + row) * width + col;
      raster->tone[to] = Quantise(band.tone[from], 65535.0f);
      const std::uint16_t height = Quantise(band.object_m[from], 100.0f);
      raster->object_cm[to] = height;
      const size_t tile = static_cast<size_t>((first_row + row) / raster->tile) *
                              static_cast<size_t>(raster->tiles_across) +
                          col / static_cast<size_t>(raster->tile);
      raster->tallest_cm[tile] = std::max(raster->tallest_cm[tile], height);
    }
}

}  // namespace

GroundRaster RenderGround(const Scene& scene, const Terrain& terrain, Epoch epoch,
                          const Bounds& extent, double cell_m) {
  GroundRaster raster;
  raster.cell = cell_m;
  raster.west = extent.min_x;
  raster.north = extent.max_y;
  raster.width = static_cast<int>(std::ceil((extent.max_x - extent.min_x) / cell_m));
  raster.height = static_cast<int>(std::ceil((extent.max_y - extent.min_y) / cell_m));
  const size_t cells = static_cast<size_t>(raster.width) * static_cast<size_t>(raster.height);
  raster.tone.resize(cells);
  raster.object_cm.resize(cells);
  raster.tiles_across = (raster.width + raster.tile - 1) / raster.tile;
  const int tiles_down = (raster.height + raster.tile - 1) / raster.tile;
  raster.tallest_cm.assign(
      static_cast<size_t>(raster.tiles_across) * static_cast<size_t>(tiles_down), 0);

  const GroundTone tones(scene, epoch, static_cast<float>(cell_m));
  const Eigen::MatrixXf shading = terrain.Shading(SunDirection(epoch));
  const int bands = (raster.height + kBandRows - 1) / kBandRows;
  tbb::parallel_for(0, bands, [&](int band_index) {
    const int first_row = band_index * kBandRows;
    GroundBand band = EmptyBand(scene, raster, first_row);
    PaintGround(tones, terrain, shading, raster, first_row, &band);
    DrawShadows(scene, epoch, &band);
    DrawObjects(scene, epoch, &band);
    Store(band, first_row, &raster);
  });
  return raster;
}

float GroundRaster::ToneAt(double x, double y) const {
  const auto col = static_cast<float>((x - west) / cell - 0.5);
  const auto row = static_cast<float>((north - y) / cell - 0.5);
  const int i = std::clamp(FloorInt(col), 0, width - 2);
  const int j = std::clamp(FloorInt(row), 0, height - 2);
  const float fx = std::clamp(col - static_cast<float>(i), 0.0f, 1.0f);
  const float fy = std::clamp(row - static_cast<float>(j), 0.0f, 1.0f);
  const std::uint16_t* p =
      tone.data() + static_cast<size_t>(j) * static_cast<size_t>(width) + static_cast<size_t>(i);
  const std::uint16_t* q = p + width;
  const auto a = static_cast<float>(p[0]), b = static_cast<float>(p[1]);
  const auto c = static_cast<float>(q[0]), d = static_cast<float>(q[1]);
  const float top = a + fx * (b - a), bottom = c + fx * (d - c);
  return (top + fy * (bottom - top)) * (1 / 65535.0f);
}

float GroundRaster::ObjectAt(double x, double y) const {
  const int col = FloorInt(static_cast<float>((x - west) / cell));
  const int row = FloorInt(static_cast<float>((north - y) / cell));
  if (col < 0 || row < 0 || col >= width || row >= height) return 0;
  return 0.01f *
         static_cast<float>(object_cm[static_cast<size_t>(row) * static_cast<size_t>(width) +
                                      static_cast<size_t>(col)]);
}

float GroundRaster::TallestNear(double x, double y, double reach_m) const {
  const double size = tile * cell;
  const auto index = [&](double distance, int count) {
    return std::clamp(FloorInt(static_cast<float>(distance / size)), 0, count - 1);
  };
  const int down = static_cast<int>(tallest_cm.size()) / tiles_across;
  const int col0 = index(x - reach_m - west, tiles_across);
  const int col1 = index(x + reach_m - west, tiles_across);
  const int row0 = index(north - y - reach_m, down), row1 = index(north - y + reach_m, down);
  std::uint16_t tallest = 0;
  for (int row = row0; row <= row1; ++row)
    for (int col = col0; col <= col1; ++col)
      tallest = std::max(tallest,
                         tallest_cm[static_cast<size_t>(row) * static_cast<size_t>(tiles_across) +
                                    static_cast<size_t>(col)]);
  return 0.01f * static_cast<float>(tallest);
}

}  // namespace orient::simulation
