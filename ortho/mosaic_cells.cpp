#include "ortho/mosaic_cells.h"

#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "core/base/side_by_side.h"
#include "core/raster/band_raster.h"
#include "ortho/new_cog.h"

namespace orient::ortho {
namespace {

std::int64_t FloorOf(std::int64_t pixels, int side) {
  const std::int64_t whole = pixels / side;
  return whole - (pixels % side < 0 ? 1 : 0);
}

MapGrid CellsAround(const MapGrid& pixels, int side) {
  MapGrid cells;
  cells.gsd_m = pixels.gsd_m * side;
  cells.west = FloorOf(pixels.west, side);
  cells.north = -FloorOf(-pixels.north, side);
  cells.width = static_cast<int>(FloorOf(pixels.west + pixels.width - 1, side) - cells.west) + 1;
  cells.height = static_cast<int>(cells.north - FloorOf(pixels.north - pixels.height, side));
  return cells;
}

// Sums up one photo's pixels.
class CellSums {
 public:
  CellSums(const MapGrid& pixels, int side, std::size_t bands)
      : pixels_(pixels), side_(side), grid_(CellsAround(pixels, side)), sums_(bands) {
    const std::size_t cells =
        static_cast<std::size_t>(grid_.width) * static_cast<std::size_t>(grid_.height);
    for (std::vector<double>& sums : sums_) sums.assign(cells, 0);
    counts_.assign(cells, 0);
  }

  void Add(const PixelWindow& tile, const std::vector<Image>& values,
           const std::vector<std::uint8_t>& mask) {
    std::size_t pixel = 0;
    for (int row = 0; row < tile.height; ++row)
      for (int col = 0; col < tile.width; ++col, ++pixel) {
        if (mask[pixel] == 0 || !AllFinite(values, pixel)) continue;
        const std::size_t cell = CellAt(tile.col + col, tile.row + row);
        ++counts_[cell];
        for (std::size_t band = 0; band < sums_.size(); ++band)
          sums_[band][cell] += static_cast<double>(values[band].values[pixel]);
      }
  }

  PhotoCells Means() const {
    PhotoCells cells{grid_, {}};
    for (const std::vector<double>& sums : sums_) {
      Image& band = cells.bands.emplace_back(grid_.width, grid_.height, kNoData);
      for (std::size_t i = 0; i < sums.size(); ++i)
        if (2 * counts_[i] >= side_ * side_)
          band.values[i] = static_cast<float>(sums[i] / counts_[i]);
    }
    return cells;
  }

 private:
  static bool AllFinite(const std::vector<Image>& bands, std::size_t pixel) {
    return std::all_of(bands.begin(), bands.end(),
                       [&](const Image& band) { return std::isfinite(band.values[pixel]); });
  }
  std::size_t CellAt(int col, int row) const {
    const std::int64_t across = FloorOf(pixels_.west + col, side_) - grid_.west;
    const std::int64_t down = grid_.north + FloorOf(row - pixels_.north, side_);
    return static_cast<std::size_t>(down * grid_.width + across);
  }

  const MapGrid& pixels_;
  int side_;
  MapGrid grid_;
  std::vector<std::vector<double>> sums_;
  std::vector<int> counts_;
};

PhotoCells CellsOf(const MosaicPart& part, int side, int bands) {
  const BandRaster raster = BandRaster::Open(part.path);
  if (raster.Format().bands != bands)
    throw InputError(part.path + " differs in its number of bands; make mosaics of each kind");
  CellSums sums(part.grid, side, static_cast<std::size_t>(bands));
  for (const PixelWindow& tile : TilesOf(part.grid))
    sums.Add(tile, raster.Read(tile), raster.ReadMask(tile));
  return sums.Means();
}

}  // namespace

int CellSide(const std::vector<MosaicPart>& parts, int bands) {
  constexpr int kInARow = 1000;
  constexpr double kMostValues = 64e6, kMostPlaces = 16e6;
  double pixels = 0;
  int side = 1;
  MapGrid all = parts.front().grid;
  for (const MosaicPart& part : parts) {
    const MapGrid& grid = part.grid;
    pixels += 1.0 * grid.width * grid.height;
    side = std::max(side, (std::max(grid.width, grid.height) + kInARow - 1) / kInARow);
    all = all.With(grid);
  }
  const double places = 1.0 * all.width * all.height;
  const double least = std::sqrt(std::max(pixels * bands / kMostValues, places / kMostPlaces));
  return std::max(side, static_cast<int>(std::ceil(least)));
}

std::vector<PhotoCells> ReadCells(const std::vector<MosaicPart>& parts, int threads,
                                  ProgressListener* listener) {
  if (parts.empty()) return {};
  const int bands = BandRaster::Open(parts.front().path).Format().bands;
  const int side = CellSide(parts, bands);
  std::vector<PhotoCells> cells(parts.size());
  ProgressTask progress(listener, "overlaps", static_cast<int>(parts.size()));
  const auto read = [&](std::size_t i) {
    cells[i] = CellsOf(parts[i], side, bands);
    progress.Advance();
  };
  OnThreads(threads, [&] { SideBySide(parts.size(), read); });
  return cells;
}

CommonCells Common(const MapGrid& first, const MapGrid& second) {
  const PixelWindow in_first = second.WindowIn(first, {0, 0, second.width, second.height});
  if (in_first.width <= 0 || in_first.height <= 0) return {};
  return {in_first, first.WindowIn(second, {0, 0, first.width, first.height})};
}

}  // namespace orient::ortho
