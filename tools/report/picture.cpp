#include "tools/report/picture.h"

#include <cpl_conv.h>
#include <cpl_string.h>
#include <cpl_vsi.h>
#include <gdal_priv.h>
#include <gdal_utils.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "core/base/atomic_write.h"
#include "core/base/error.h"
#include "core/base/quiet_gdal.h"

namespace orient {
namespace {

constexpr size_t kLargestPng = 256 * 1024;  // bytes
constexpr int kLargestSide = 1800;          // px, of a picture that is made smaller
constexpr int kLargestHeight = 6000;        // px; contact sheets are tall

// A file in memory that goes away with this object.
class MemoryFile {
 public:
  MemoryFile() : path_("/vsimem/orient_report_" + std::to_string(Id()) + ".jpg") {}
  ~MemoryFile() { VSIUnlink(path_.c_str()); }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;

  const std::string& Path() const { return path_; }
  std::string Contents() const {
    vsi_l_offset size = 0;
    const GByte* bytes = VSIGetMemFileBuffer(path_.c_str(), &size, FALSE);
    if (bytes == nullptr) return "";
    return std::string(reinterpret_cast<const char*>(bytes), static_cast<size_t>(size));
  }

 private:
  // /vsimem is one name space for the whole process; an address is unique while the object lives.
  std::uintptr_t Id() const { return reinterpret_cast<std::uintptr_t>(this); }
  std::string path_;
};

std::string DataUri(const char* type, const std::string& bytes) {
  const std::unique_ptr<char, void (*)(void*)> base64(
      CPLBase64Encode(static_cast<int>(bytes.size()), reinterpret_cast<const GByte*>(bytes.data())),
      &VSIFree);
  return std::string("data:image/") + type + ";base64," + base64.get();
}

std::string AsJpeg(GDALDataset* picture) {
  const double scale = std::min({1.0, double{kLargestSide} / picture->GetRasterXSize(),
                                 double{kLargestHeight} / picture->GetRasterYSize()});
  const auto side = [&](int px) {
    return std::to_string(std::max(1, static_cast<int>(px * scale)));
  };
  std::vector<std::string> words = {"-of",
                                    "JPEG",
                                    "-co",
                                    "QUALITY=82",
                                    "-ot",
                                    "Byte",
                                    "-r",
                                    "average",
                                    "-outsize",
                                    side(picture->GetRasterXSize()),
                                    side(picture->GetRasterYSize())};
  const int bands = picture->GetRasterCount() >= 3 ? 3 : 1;  // an alpha channel has no place
  for (int band = 1; band <= bands; ++band) {
    words.push_back("-b");
    words.push_back(std::to_string(band));
  }
  if (picture->GetRasterBand(1)->GetColorTable() != nullptr)
    words.insert(words.end(), {"-expand", "rgb"});
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  const std::unique_ptr<GDALTranslateOptions, void (*)(GDALTranslateOptions*)> options(
      GDALTranslateOptionsNew(argv.data(), nullptr), &GDALTranslateOptionsFree);
  const MemoryFile file;
  const GDALDatasetH jpeg =
      GDALTranslate(file.Path().c_str(), GDALDataset::ToHandle(picture), options.get(), nullptr);
  if (jpeg == nullptr) return "";
  GDALClose(jpeg);
  return file.Contents();
}

// A band reduced to bytes: grey values between the second and the 98th percentile of
// those that are there, unless they are bytes already; white where nothing is.
std::vector<GByte> ReducedBand(GDALRasterBand* band, int width, int height) {
  const std::size_t count = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  std::vector<float> values(count);
  std::vector<GByte> mask(count), bytes(count, 255);
  GDALRasterIOExtraArg averaged;
  INIT_RASTERIO_EXTRA_ARG(averaged);
  averaged.eResampleAlg = GRIORA_Average;
  if (band->RasterIO(GF_Read, 0, 0, band->GetXSize(), band->GetYSize(), values.data(), width,
                     height, GDT_Float32, 0, 0, &averaged) != CE_None ||
      band->GetMaskBand()->RasterIO(GF_Read, 0, 0, band->GetXSize(), band->GetYSize(), mask.data(),
                                    width, height, GDT_Byte, 0, 0, nullptr) != CE_None)
    return {};
  std::vector<float> seen;
  for (std::size_t i = 0; i < count; ++i) {
    if (!std::isfinite(values[i])) mask[i] = 0;
    if (mask[i] > 0) seen.push_back(values[i]);
  }
  if (seen.empty()) return bytes;
  float low = 0, high = 255;
  if (band->GetRasterDataType() != GDT_Byte) {
    std::sort(seen.begin(), seen.end());
    low = seen[seen.size() / 50];
    high = std::max(low + 1, seen[seen.size() - 1 - seen.size() / 50]);
  }
  for (std::size_t i = 0; i < count; ++i)
    if (mask[i] > 0)
      bytes[i] =
          static_cast<GByte>(std::clamp(255 * (values[i] - low) / (high - low), 0.0f, 255.0f));
  return bytes;
}

// A map, reduced; null where it cannot be read.
GDALDatasetUniquePtr Reduced(GDALDataset* map) {
  constexpr double kLargest = 1200;  // px
  const double scale =
      std::min(1.0, kLargest / std::max(map->GetRasterXSize(), map->GetRasterYSize()));
  const int width = std::max(1, static_cast<int>(scale * map->GetRasterXSize()));
  const int height = std::max(1, static_cast<int>(scale * map->GetRasterYSize()));
  const int bands = map->GetRasterCount() >= 3 ? 3 : 1;
  GDALDatasetUniquePtr reduced(GetGDALDriverManager()->GetDriverByName("MEM")->Create(
      "", width, height, bands, GDT_Byte, nullptr));
  for (int band = 1; reduced && band <= bands; ++band) {
    std::vector<GByte> bytes = ReducedBand(map->GetRasterBand(band), width, height);
    if (bytes.empty() ||
        reduced->GetRasterBand(band)->RasterIO(GF_Write, 0, 0, width, height, bytes.data(), width,
                                               height, GDT_Byte, 0, 0, nullptr) != CE_None)
      return nullptr;
  }
  return reduced;
}

std::optional<InlinePicture> LoadMap(const std::string& path) {
  const QuietGdal quiet;
  const char* const drivers[] = {"GTiff", nullptr};
  const GDALDatasetUniquePtr map(
      GDALDataset::Open(path.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY, drivers));
  quiet.ThrowFaults();
  if (!map || map->GetRasterCount() == 0) return std::nullopt;
  const GDALDatasetUniquePtr reduced = Reduced(map.get());
  const std::string jpeg = reduced ? AsJpeg(reduced.get()) : "";
  quiet.ThrowFaults();
  if (jpeg.empty()) return std::nullopt;
  return InlinePicture{DataUri("jpeg", jpeg), reduced->GetRasterXSize(), reduced->GetRasterYSize()};
}

}  // namespace

std::optional<InlinePicture> LoadPicture(const std::string& path) {
  RegisterGdalDrivers();
  if (path.ends_with(".tif")) return LoadMap(path);
  const QuietGdal quiet;
  const char* const drivers[] = {"PNG", nullptr};
  const GDALDatasetUniquePtr dataset(
      GDALDataset::Open(path.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY, drivers));
  quiet.ThrowFaults();
  if (!dataset || dataset->GetRasterCount() == 0) return std::nullopt;
  InlinePicture picture{"", dataset->GetRasterXSize(), dataset->GetRasterYSize()};
  std::string png;
  try {
    png = ReadFile(path);
  } catch (const InputError&) {  // a picture is an extra: its photo is reported without
    return std::nullopt;
  }
  const std::string jpeg = png.size() > kLargestPng ? AsJpeg(dataset.get()) : "";
  quiet.ThrowFaults();
  if (png.size() > kLargestPng && jpeg.empty()) return std::nullopt;
  picture.data_uri =
      jpeg.empty() || jpeg.size() >= png.size() ? DataUri("png", png) : DataUri("jpeg", jpeg);
  return picture;
}

}  // namespace orient
