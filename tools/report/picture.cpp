#include "tools/report/picture.h"

#include <cpl_conv.h>
#include <cpl_string.h>
#include <cpl_vsi.h>
#include <gdal_priv.h>
#include <gdal_utils.h>

#include <algorithm>
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

}  // namespace

std::optional<InlinePicture> LoadPicture(const std::string& path) {
  RegisterGdalDrivers();
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
