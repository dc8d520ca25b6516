// Grey values out of a GDAL dataset: band choice, palette, masks, overviews, area averaging.
// Internal to core/raster; Raster adds the lock.
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "core/raster/area_average.h"
#include "core/raster/image.h"
#include "core/raster/window_reader.h"

class GDALDataset;
class GDALRasterBand;

namespace orient {

class GreyReader {
 public:
  // `dataset` must outlive the reader and have at least one band. Throws InputError naming `path`
  // for complex-valued bands.
  GreyReader(GDALDataset* dataset, std::string path);

  ImageWindow Read(const PixelWindow& window, double reduction) const;

 private:
  // The raster itself or one of its overviews.
  struct Level {
    std::vector<GDALRasterBand*> colours;  // 1: grey or palette index; 3: red, green, blue
    GDALRasterBand* mask = nullptr;        // 0: no data; absent: everything is data
    int width = 0, height = 0;
    double col_scale = 1, row_scale = 1;    // raster pixels per level pixel
    double col_origin = 0, row_origin = 0;  // raster pixel of the level's (0, 0)
    std::shared_ptr<WindowReader> windows;  // of the colours, then of the mask
  };
  struct Block {  // of a level's pixels
    int col = 0, row = 0, width = 0, height = 0;
  };
  struct Span {  // [first, stop) of a level's rows or columns
    int first = 0, stop = 0;
  };

  void ChooseBands();
  void ReadPalette();
  void AddOverviews();
  void AddLevel(Level level);
  const Level& LevelFor(double reduction) const;
  ImageWindow ReadUnreduced(const PixelWindow& window) const;
  // Into `grey`, whose memory is used again where its size is the block's.
  void ReadLevel(const Level& level, const Block& block, const PixelWindow& asked,
                 Image* grey) const;
  void ReadBand(const Level& level, std::size_t band, const Block& block, const PixelWindow& asked,
                float* values) const;
  // The values read are grey values as they stand.
  bool IsGrey() const;
  void ToGrey(const std::vector<Image>& colours, Image* grey) const;
  static Span SpanOf(const std::vector<CellWeights>& cells);

  GDALDataset* dataset_;
  std::string path_;
  std::vector<Level> levels_;               // finest first
  std::vector<float> palette_;              // grey of every index; empty: no palette
  std::vector<std::vector<float>> nodata_;  // of every colour band: empty or one value
  float white_is_ = -1;                     // the largest value where 0 means white, else -1
};

}  // namespace orient
