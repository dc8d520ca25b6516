#include "tools/convert/resample_photos.h"

#include <gdal_priv.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/base/error.h"
#include "core/base/new_file.h"
#include "core/base/open_dataset.h"
#include "core/base/quiet_gdal.h"
#include "core/raster/colour_bands.h"
#include "core/raster/image.h"
#include "core/raster/resample.h"

namespace orient {
namespace {

constexpr int kBlock = 512;       // side of the blocks worked on, px
constexpr double kAverage = 1.2;  // reductions from here on average over areas

// What of the scan a block of the image needs.
struct Window {
  int col = 0, row = 0, width = 0, height = 0;
  bool Empty() const { return width <= 0 || height <= 0; }
};

struct BlockMap {
  int col = 0, row = 0, width = 0, height = 0;  // in the image
  std::vector<Eigen::Vector2d> scan;            // of each pixel's centre
  Window window;
};

Window WindowOf(const std::vector<Eigen::Vector2d>& places, double factor, int width, int height) {
  Eigen::Vector2d low = places.front(), high = low;
  for (const Eigen::Vector2d& place : places) {
    low = low.cwiseMin(place);
    high = high.cwiseMax(place);
  }
  const double margin = 4 * std::max(1.0, factor);
  const auto clipped = [](double value, int size) {
    return static_cast<int>(std::clamp(value, 0.0, static_cast<double>(size)));
  };
  Window window;
  window.col = clipped(std::floor(low.x() - margin), width);
  window.row = clipped(std::floor(low.y() - margin), height);
  window.width = clipped(std::ceil(high.x() + margin), width) - window.col;
  window.height = clipped(std::ceil(high.y() + margin), height) - window.row;
  return window;
}

BlockMap MapBlock(const FilmImage& film, const Camera& image, int col, int row, double factor) {
  BlockMap block{col,
                 row,
                 std::min(kBlock, image.image_px->x() - col),
                 std::min(kBlock, image.image_px->y() - row),
                 {},
                 {}};
  block.scan.resize(static_cast<std::size_t>(block.width) * static_cast<std::size_t>(block.height));
  tbb::parallel_for(0, block.height, [&](int j) {
    for (int i = 0; i < block.width; ++i)
      block.scan[static_cast<std::size_t>(j) * static_cast<std::size_t>(block.width) +
                 static_cast<std::size_t>(i)] = film.ScanFromImage({col + i + 0.5, row + j + 0.5});
  });
  block.window = WindowOf(block.scan, factor, film.ScanWidth(), film.ScanHeight());
  return block;
}

// One band's values of a block, 0 where the scan has none.
std::vector<float> Sample(const BlockMap& block, const Image& part, double factor) {
  const bool average = factor > kAverage;
  const Image reduced = average ? ReduceBy(part, factor) : Image();
  const Image& from = average ? reduced : part;
  const double scale = average ? factor : 1;
  const Eigen::Vector2d origin(block.window.col, block.window.row);
  std::vector<float> values(block.scan.size(), 0);
  tbb::parallel_for(std::size_t{0}, values.size(), [&](std::size_t i) {
    const float value = SampleBicubic(from, (block.scan[i] - origin) / scale);
    if (std::isfinite(value)) values[i] = value;
  });
  return values;
}

[[noreturn]] void Fail(const std::string& path, const char* what, const QuietGdal& quiet) {
  quiet.ThrowFaults();
  throw InputError(path + ": " + what + quiet.Message());
}

GDALDatasetUniquePtr OpenScan(const std::string& path, const FilmImage& film,
                              const QuietGdal& quiet) {
  RegisterGdalDrivers();
  GDALDatasetUniquePtr scan = OpenRasterDataset(path);
  if (!scan || scan->GetRasterCount() == 0) Fail(path, "not an image that GDAL can read", quiet);
  film.RequireScan(path, scan->GetRasterXSize(), scan->GetRasterYSize());
  if (ColourTableOf(scan.get(), scan->GetRasterBand(1)) != nullptr)
    throw InputError(path +
                     " has a palette, which cannot be interpolated; expand it first "
                     "(gdal_translate -expand rgb)");
  return scan;
}

GDALDatasetUniquePtr MakeImage(const std::string& path, GDALDataset* scan, const Camera& image,
                               const QuietGdal& quiet) {
  CPLStringList options;
  options.SetNameValue("TILED", "YES");
  options.SetNameValue("COMPRESS", "LZW");
  options.SetNameValue("BIGTIFF", "IF_SAFER");
  if (scan->GetRasterCount() == 3) options.SetNameValue("PHOTOMETRIC", "RGB");
  GDALDriver* driver = GetGDALDriverManager()->GetDriverByName("GTiff");
  GDALDatasetUniquePtr made(driver->Create(path.c_str(), image.image_px->x(), image.image_px->y(),
                                           scan->GetRasterCount(),
                                           scan->GetRasterBand(1)->GetRasterDataType(), options));
  if (!made) Fail(path, "cannot be written", quiet);
  const double dots_per_cm = 10 * image.image_px->x() / image.frame_mm.x();
  made->SetMetadataItem("TIFFTAG_XRESOLUTION", std::to_string(dots_per_cm).c_str());
  made->SetMetadataItem("TIFFTAG_YRESOLUTION", std::to_string(dots_per_cm).c_str());
  made->SetMetadataItem("TIFFTAG_RESOLUTIONUNIT", "3");
  return made;
}

void CopyBlock(const BlockMap& block, double factor, GDALDataset* scan, GDALDataset* made,
               const std::string& path, const QuietGdal& quiet) {
  if (block.window.Empty()) return;
  const Window& w = block.window;
  const bool white_is_zero = IsWhiteZero(scan);  // in the image 0 is black
  for (int band = 1; band <= scan->GetRasterCount(); ++band) {
    Image part(w.width, w.height);
    if (scan->GetRasterBand(band)->RasterIO(GF_Read, w.col, w.row, w.width, w.height,
                                            part.values.data(), w.width, w.height, GDT_Float32, 0,
                                            0, nullptr) != CE_None)
      Fail(path, "cannot be read", quiet);
    if (white_is_zero && scan->GetRasterBand(band)->GetColorInterpretation() != GCI_AlphaBand) {
      const float white = GreatestValue(BitsPerSample(scan->GetRasterBand(band)));
      for (float& value : part.values) value = white - value;
    }
    std::vector<float> values = Sample(block, part, factor);
    if (made->GetRasterBand(band)->RasterIO(GF_Write, block.col, block.row, block.width,
                                            block.height, values.data(), block.width, block.height,
                                            GDT_Float32, 0, 0, nullptr) != CE_None)
      Fail(path, "its resampled image cannot be written", quiet);
  }
}

// Scan pixels per image pixel, in the image's middle.
double Reduction(const FilmImage& film, const Camera& image) {
  const Eigen::Vector2d middle = 0.5 * image.image_px->cast<double>();
  const Eigen::Vector2d across =
      film.ScanFromImage(middle + Eigen::Vector2d(1, 0)) - film.ScanFromImage(middle);
  return across.norm();
}

double LargestDifference(const FilmImage& film, const Camera& image) {
  constexpr int kPlaces = 40;
  double largest = 0;
  for (int i = 0; i <= kPlaces; ++i)
    for (int j = 0; j <= kPlaces; ++j) {
      const Eigen::Vector2d at =
          image.image_px->cast<double>().cwiseProduct(Eigen::Vector2d(i, j)) / kPlaces;
      if (const auto back = film.ImageFromScan(film.ScanFromImage(at)))
        largest = std::max(largest, (*back - at).norm());
    }
  return largest;
}

}  // namespace

ResampledPhoto ResamplePhoto(const std::string& scan_path, const FilmImage& film,
                             const Camera& image, const std::string& path) {
  const QuietGdal quiet;
  const GDALDatasetUniquePtr scan = OpenScan(scan_path, film, quiet);
  NewFile file(path);
  {
    const GDALDatasetUniquePtr made = MakeImage(file.PartialPath(), scan.get(), image, quiet);
    const double factor = Reduction(film, image);
    for (int row = 0; row < image.image_px->y(); row += kBlock)
      for (int col = 0; col < image.image_px->x(); col += kBlock)
        CopyBlock(MapBlock(film, image, col, row, factor), factor, scan.get(), made.get(),
                  scan_path, quiet);
    CPLErrorReset();
    made->FlushCache();
    if (CPLGetLastErrorType() >= CE_Failure) file.Fail("GDAL failed" + quiet.Message());
  }
  file.Keep();
  return {path, image.image_px->x(), image.image_px->y(), scan->GetRasterCount(),
          LargestDifference(film, image)};
}

}  // namespace orient
