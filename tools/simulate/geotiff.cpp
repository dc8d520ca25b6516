#include "tools/simulate/geotiff.h"

#include <fmt/format.h>
#include <gdal_priv.h>

#include "core/base/error.h"
#include "core/base/new_file.h"
#include "core/base/quiet_gdal.h"

namespace orient::simulation {
namespace {

struct CloseDataset {
  void operator()(GDALDataset* dataset) const { GDALClose(dataset); }
};

[[noreturn]] void Fail(const NewFile& file) {
  file.Fail(std::string("GDAL failed: ") + CPLGetLastErrorMsg());
}

void SetResolution(double pixel_size_mm, GDALDataset* dataset) {
  const std::string per_cm = fmt::format("{:.9g}", 10 / pixel_size_mm);
  dataset->SetMetadataItem("TIFFTAG_XRESOLUTION", per_cm.c_str());
  dataset->SetMetadataItem("TIFFTAG_YRESOLUTION", per_cm.c_str());
  dataset->SetMetadataItem("TIFFTAG_RESOLUTIONUNIT", "3");  // pixels per centimetre
}

void SetReference(const GeoReference& reference, const NewFile& file, GDALDataset* dataset) {
  double transform[6] = {reference.west_m, reference.cell_m, 0, reference.north_m, 0,
                         -reference.cell_m};
  if (dataset->SetGeoTransform(transform) != CE_None ||
      dataset->SetProjection(reference.crs.Wkt().c_str()) != CE_None)
    Fail(file);
}

// Writes values of type `memory` into a file of type `stored`.
void WriteTiff(const std::string& path, int width, int height, const void* values,
               GDALDataType memory, GDALDataType stored, const std::optional<double>& pixel_size_mm,
               const std::optional<GeoReference>& reference) {
  RegisterGdalDrivers();
  const QuietGdal quiet;
  GDALDriver* driver = GetGDALDriverManager()->GetDriverByName("GTiff");
  if (driver == nullptr) throw InputError(path + ": this GDAL cannot write GeoTIFF");
  const char* tiling[] = {"TILED=YES", "BLOCKXSIZE=256", "BLOCKYSIZE=256", nullptr};
  NewFile file(path);
  std::unique_ptr<GDALDataset, CloseDataset> dataset(driver->Create(
      file.PartialPath().c_str(), width, height, 1, stored, const_cast<char**>(tiling)));
  if (dataset == nullptr) Fail(file);
  if (pixel_size_mm) SetResolution(*pixel_size_mm, dataset.get());
  if (reference) SetReference(*reference, file, dataset.get());
  CPLErrorReset();
  // GDAL only reads from the buffer here, though its interface cannot say so.
  if (dataset->GetRasterBand(1)->RasterIO(GF_Write, 0, 0, width, height, const_cast<void*>(values),
                                          width, height, memory, 0, 0) != CE_None)
    Fail(file);
  dataset.reset();
  if (CPLGetLastErrorType() == CE_Failure) Fail(file);  // what did not fit shows when it is flushed
  file.Keep();
}

}  // namespace

void WriteGreyTiff(const std::string& path, int width, int height,
                   const std::vector<std::uint16_t>& values, int bits,
                   const std::optional<double>& pixel_size_mm,
                   const std::optional<GeoReference>& reference) {
  WriteTiff(path, width, height, values.data(), GDT_UInt16, bits == 16 ? GDT_UInt16 : GDT_Byte,
            pixel_size_mm, reference);
}

void WriteFloatTiff(const std::string& path, int width, int height,
                    const std::vector<float>& values, const GeoReference& reference) {
  WriteTiff(path, width, height, values.data(), GDT_Float32, GDT_Float32, std::nullopt, reference);
}

struct SparseTiff::Impl {
  explicit Impl(const std::string& path) : file(path) {}

  QuietGdal quiet;
  NewFile file;
  Shape shape;
  std::unique_ptr<GDALDataset, CloseDataset> dataset;
};

SparseTiff::SparseTiff(const std::string& path, const Shape& shape, double pixel_size_mm)
    : impl_(std::make_unique<Impl>(path)) {
  RegisterGdalDrivers();
  GDALDriver* driver = GetGDALDriverManager()->GetDriverByName("GTiff");
  if (driver == nullptr) throw InputError(path + ": this GDAL cannot write GeoTIFF");
  const char* tiling[] = {"TILED=YES",
                          "BLOCKXSIZE=256",
                          "BLOCKYSIZE=256",
                          "SPARSE_OK=TRUE",
                          shape.bands == 3 ? "PHOTOMETRIC=RGB" : "PHOTOMETRIC=MINISBLACK",
                          nullptr};
  impl_->shape = shape;
  impl_->dataset.reset(driver->Create(impl_->file.PartialPath().c_str(), shape.width, shape.height,
                                      shape.bands, shape.bits == 16 ? GDT_UInt16 : GDT_Byte,
                                      const_cast<char**>(tiling)));
  if (impl_->dataset == nullptr) Fail(impl_->file);
  SetResolution(pixel_size_mm, impl_->dataset.get());
  CPLErrorReset();
}

SparseTiff::~SparseTiff() = default;

void SparseTiff::Write(const Eigen::Vector2i& origin, const Eigen::Vector2i& size,
                       const std::vector<std::uint16_t>& values) {
  const int bands = impl_->shape.bands;
  // GDAL only reads from the buffer here, though its interface cannot say so.
  if (impl_->dataset->RasterIO(GF_Write, origin.x(), origin.y(), size.x(), size.y(),
                               const_cast<std::uint16_t*>(values.data()), size.x(), size.y(),
                               GDT_UInt16, bands, nullptr, static_cast<GSpacing>(2 * bands),
                               static_cast<GSpacing>(2 * bands) * size.x(), 2, nullptr) != CE_None)
    Fail(impl_->file);
}

void SparseTiff::Finish() {
  impl_->dataset.reset();
  if (CPLGetLastErrorType() == CE_Failure) Fail(impl_->file);
  impl_->file.Keep();
}

}  // namespace orient::simulation
