// A mosaic's orthophotos in cells of many pixels: their tones and the seamlines between them are
// decided by these.
#pragma once

#include <vector>

#include "core/base/progress.h"
#include "core/raster/image.h"
#include "ortho/mosaic_part.h"

namespace orient::ortho {

struct PhotoCells {
  MapGrid grid;              // of cells: its gsd_m is their side; the cells of all photos coincide
  std::vector<Image> bands;  // mean grey value; NaN where less than half of the cell has data

  bool Has(int col, int row) const { return !std::isnan(bands.front().At(col, row)); }
};

// Side of a cell, pixels, for one or more parts: the smallest with at most 1000 cells in a row of a
// photo, a quarter of a gigabyte for all photos' values, and 16 million cells for the whole mosaic.
int CellSide(const std::vector<MosaicPart>& parts, int bands);

// Of each part; a pixel that is not finite in some band is no data. Reads in tiles, photos side by
// side. `listener` may be null. Throws InputError: a damaged file, parts of different numbers of
// bands.
std::vector<PhotoCells> ReadCells(const std::vector<MosaicPart>& parts, int threads,
                                  ProgressListener* listener);

// The cells that two photos may have in common, as a window of either; empty where width is 0.
struct CommonCells {
  PixelWindow in_first, in_second;
};
CommonCells Common(const MapGrid& first, const MapGrid& second);

}  // namespace orient::ortho
