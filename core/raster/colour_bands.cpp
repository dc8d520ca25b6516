#include "core/raster/colour_bands.h"

#include <gdal_priv.h>

#include <cstdlib>

namespace orient {

int BitsPerSample(GDALRasterBand* band) {
  const char* bits = band->GetMetadataItem("NBITS", "IMAGE_STRUCTURE");
  if (bits != nullptr && std::atoi(bits) > 0) return std::atoi(bits);
  return GDALGetDataTypeSizeBits(band->GetRasterDataType());
}

std::vector<GDALRasterBand*> ColourBands(GDALDataset* dataset) {
  GDALRasterBand* red = nullptr;
  GDALRasterBand* green = nullptr;
  GDALRasterBand* blue = nullptr;
  std::vector<GDALRasterBand*> plain;  // all but alpha
  for (int i = 1; i <= dataset->GetRasterCount(); ++i) {
    GDALRasterBand* band = dataset->GetRasterBand(i);
    const GDALColorInterp meaning = band->GetColorInterpretation();
    if (meaning == GCI_RedBand && red == nullptr) red = band;
    if (meaning == GCI_GreenBand && green == nullptr) green = band;
    if (meaning == GCI_BlueBand && blue == nullptr) blue = band;
    if (meaning != GCI_AlphaBand) plain.push_back(band);
  }
  if (red != nullptr && green != nullptr && blue != nullptr) return {red, green, blue};
  if (plain.size() >= 3) return {plain[0], plain[1], plain[2]};
  return {plain.empty() ? dataset->GetRasterBand(1) : plain[0]};
}

bool IsWhiteZero(GDALDataset* dataset) {
  GDALRasterBand* band = dataset->GetRasterBand(1);
  const GDALDataType type = band->GetRasterDataType();
  return ColourBands(dataset).size() == 1 && (type == GDT_Byte || type == GDT_UInt16) &&
         (dataset->GetMetadataItem("MINISWHITE", "IMAGE_STRUCTURE") != nullptr ||
          band->GetMetadataItem("MINISWHITE", "IMAGE_STRUCTURE") != nullptr);
}

const GDALColorTable* ColourTableOf(GDALDataset* dataset, GDALRasterBand* band) {
  return IsWhiteZero(dataset) && BitsPerSample(band) >= 8 ? nullptr : band->GetColorTable();
}

}  // namespace orient
