#include "core/raster/overviews.h"

#include <gdal_priv.h>

#include <algorithm>

#include "core/base/open_dataset.h"
#include "core/base/quiet_gdal.h"
#include "core/raster/colour_bands.h"
#include "core/raster/reading_errors.h"

namespace orient {

double CoarsestOverview(const std::string& path) {
  RegisterGdalDrivers();
  const ReadingErrors errors;
  const GdalFaults faults;
  const GDALDatasetUniquePtr dataset = OpenRasterDataset(path);
  if (dataset == nullptr || dataset->GetRasterCount() == 0) return 1;
  GDALRasterBand* band = dataset->GetRasterBand(1);
  const GDALColorTable* palette = ColourTableOf(dataset.get(), band);
  double coarsest = 1;
  for (int i = 0; palette == nullptr && i < band->GetOverviewCount(); ++i)
    if (GDALRasterBand* overview = band->GetOverview(i))
      coarsest = std::max(coarsest, std::min(double(band->GetXSize()) / overview->GetXSize(),
                                             double(band->GetYSize()) / overview->GetYSize()));
  faults.ThrowIfAny();
  return coarsest;
}

}  // namespace orient
