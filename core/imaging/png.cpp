// PNG files and PNGs in memory: OpenCV writes, GDAL reads.
#include <cpl_vsi.h>
#include <gdal_priv.h>

#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

#include "core/error.h"
#include "core/imaging/gdal_quiet.h"
#include "core/imaging/grey_reader.h"
#include "core/imaging/png_bands.h"
#include "core/imaging/raster.h"

namespace orient {
namespace {

namespace fs = std::filesystem;

constexpr uint32_t kMaxDecodedSide = 4096;
constexpr unsigned char kSignature[] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};

void CheckSize(int width, int height, int channels, size_t count) {
  if (width <= 0 || height <= 0 || (channels != 1 && channels != 3) ||
      count !=
          static_cast<size_t>(width) * static_cast<size_t>(height) * static_cast<size_t>(channels))
    throw std::invalid_argument("EncodePng: the values do not fill " + std::to_string(width) +
                                " x " + std::to_string(height) + " x " + std::to_string(channels));
}

std::vector<unsigned char> Encode(const cv::Mat& image) {
  std::vector<unsigned char> png;
  // Level and strategy are fixed so that the same picture gives the same bytes.
  const std::vector<int> settings = {cv::IMWRITE_PNG_COMPRESSION, 6, cv::IMWRITE_PNG_STRATEGY,
                                     cv::IMWRITE_PNG_STRATEGY_DEFAULT};
  if (!cv::imencode(".png", image, png, settings))
    throw std::runtime_error("the PNG encoder refuses the image");
  return png;
}

uint32_t BigEndian(const unsigned char* b) {
  return uint32_t{b[0]} << 24 | uint32_t{b[1]} << 16 | uint32_t{b[2]} << 8 | uint32_t{b[3]};
}

// The header must be right before any decoder may allocate what it claims.
void CheckHeader(const std::vector<unsigned char>& png) {
  if (png.size() < 33 || std::memcmp(png.data(), kSignature, sizeof kSignature) != 0 ||
      std::memcmp(png.data() + 12, "IHDR", 4) != 0)
    throw InputError("PNG chip of " + std::to_string(png.size()) +
                     " bytes: not a PNG; the database or file that holds it is damaged");
  const uint32_t width = BigEndian(png.data() + 16), height = BigEndian(png.data() + 20);
  if (width == 0 || height == 0 || width > kMaxDecodedSide || height > kMaxDecodedSide)
    throw InputError("PNG chip of " + std::to_string(width) + " x " + std::to_string(height) +
                     " pixels: at most " + std::to_string(kMaxDecodedSide) + " a side are taken");
}

// The bytes as a file in GDAL's memory, for as long as this lives. The name is this object's
// address, so that no two living ones share it.
class MemoryFile {
 public:
  explicit MemoryFile(const std::vector<unsigned char>& bytes) {
    char name[64];
    std::snprintf(name, sizeof name, "/vsimem/orient-png-%p/chip.png", static_cast<void*>(this));
    name_ = name;
    // GDAL only reads; its interface has no const.
    VSIFCloseL(
        VSIFileFromMemBuffer(name_.c_str(), const_cast<GByte*>(bytes.data()), bytes.size(), FALSE));
  }
  ~MemoryFile() { VSIUnlink(name_.c_str()); }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;
  const std::string& Name() const { return name_; }

 private:
  std::string name_;
};

// A PNG in memory, open for reading.
class OpenPng {
 public:
  explicit OpenPng(const std::vector<unsigned char>& png)
      : bytes_(png.size()), file_(Checked(png)) {
    const char* const only_png[] = {"PNG", nullptr};
    const char* const no_siblings[] = {nullptr};
    dataset_.reset(GDALDataset::Open(file_.Name().c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY,
                                     only_png, nullptr, no_siblings));
    if (dataset_ == nullptr || dataset_->GetRasterCount() == 0) throw Damaged();
  }
  GDALDataset* Dataset() const { return dataset_.get(); }
  PixelWindow Whole() const {
    return {0, 0, dataset_->GetRasterXSize(), dataset_->GetRasterYSize()};
  }
  InputError Damaged() const {
    return InputError("PNG chip of " + std::to_string(bytes_) + " bytes: damaged (" +
                      quiet_.Message() + ")");
  }

 private:
  static const std::vector<unsigned char>& Checked(const std::vector<unsigned char>& png) {
    CheckHeader(png);
    RegisterGdalDrivers();
    return png;
  }
  size_t bytes_;
  GdalQuiet quiet_;
  MemoryFile file_;
  GDALDatasetUniquePtr dataset_;
};

}  // namespace

std::vector<unsigned char> EncodePng(int width, int height, int channels,
                                     const std::vector<unsigned char>& values) {
  CheckSize(width, height, channels, values.size());
  const cv::Mat image(height, width, channels == 1 ? CV_8UC1 : CV_8UC3,
                      const_cast<unsigned char*>(values.data()));
  if (channels == 1) return Encode(image);
  cv::Mat bgr;
  cv::cvtColor(image, bgr, cv::COLOR_RGB2BGR);
  return Encode(bgr);
}

std::vector<unsigned char> EncodePng16(int width, int height, const std::vector<uint16_t>& values) {
  CheckSize(width, height, 1, values.size());
  return Encode(cv::Mat(height, width, CV_16UC1, const_cast<uint16_t*>(values.data())));
}

void WritePng(const std::string& path, int width, int height, int channels,
              const std::vector<unsigned char>& values) {
  const std::vector<unsigned char> png = EncodePng(width, height, channels, values);
  const std::string beside = path + ".part";
  std::ofstream file(beside, std::ios::binary | std::ios::trunc);
  file.write(reinterpret_cast<const char*>(png.data()), static_cast<std::streamsize>(png.size()));
  file.close();
  std::error_code error;
  if (file) fs::rename(beside, path, error);
  if (file && !error) return;
  std::error_code ignored;  // the failure below is what the user needs to know
  fs::remove(beside, ignored);
  throw InputError(path + ": cannot be written; check that the folder exists, is writable and " +
                   "has space");
}

Image DecodePng(const std::vector<unsigned char>& png) {
  const OpenPng open(png);
  return GreyReader(open.Dataset(), "PNG chip").Read(open.Whole(), 1).image;
}

std::vector<Image> DecodePngBands(const std::vector<unsigned char>& png) {
  const OpenPng open(png);
  GDALDataset& dataset = *open.Dataset();
  const PixelWindow whole = open.Whole();
  const int count = dataset.GetRasterCount();
  const GDALDataType type = dataset.GetRasterBand(1)->GetRasterDataType();
  if ((count != 1 && count != 3) || (type != GDT_Byte && type != GDT_UInt16) ||
      dataset.GetRasterBand(1)->GetColorTable() != nullptr)
    throw InputError("PNG chip of " + std::to_string(png.size()) +
                     " bytes: neither grey nor RGB of 8 or 16 bits");
  std::vector<Image> bands;
  for (int i = 1; i <= count; ++i) {
    Image band(whole.width, whole.height);
    if (dataset.GetRasterBand(i)->RasterIO(GF_Read, 0, 0, whole.width, whole.height,
                                           band.values.data(), whole.width, whole.height,
                                           GDT_Float32, 0, 0) != CE_None)
      throw open.Damaged();
    bands.push_back(std::move(band));
  }
  return bands;
}

}  // namespace orient
