// What the bands of a GDAL dataset hold. Only for .cpp files that use GDAL.
#pragma once

#include <vector>

class GDALColorTable;
class GDALDataset;
class GDALRasterBand;

namespace orient {

// Red, green and blue, by what the bands are said to mean, otherwise the first three that are not
// transparency; one band where there are fewer.
std::vector<GDALRasterBand*> ColourBands(GDALDataset* dataset);

// As declared: 12 of a band of 16-bit values may be in use.
int BitsPerSample(GDALRasterBand* band);

// Of unsigned integers of so many bits; white where 0 is black, and what inverts grey values.
inline float GreatestValue(int bits) { return static_cast<float>((1 << bits) - 1); }

// Whether 0 is white in the dataset's only band of grey values (TIFF: MINISWHITE).
bool IsWhiteZero(GDALDataset* dataset);

// The band's palette; null if it has none. To grey values of which 0 is white GDAL gives a palette
// of 8-bit values, which would lose the others: from 8 bits on they are no palette.
const GDALColorTable* ColourTableOf(GDALDataset* dataset, GDALRasterBand* band);

}  // namespace orient
