// Which bands of a GDAL dataset are its colours. Internal to core/imaging.
#pragma once

#include <vector>

class GDALDataset;
class GDALRasterBand;

namespace orient {

// Red, green and blue, by what the bands are said to mean, otherwise the first three that are not
// transparency; one band where there are fewer.
std::vector<GDALRasterBand*> ColourBands(GDALDataset* dataset);

}  // namespace orient
