#include "tools/report/new_geopackage.h"

#include <cpl_conv.h>
#include <cpl_error.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>

#include "core/base/error.h"
#include "core/base/quiet_gdal.h"
#include "tools/report/html_text.h"

namespace orient {
namespace fs = std::filesystem;

void NewLayer::Row::Set(const char* field, const std::string& text) {
  feature_->SetField(field, ValidText(text).c_str());
}

void NewLayer::Row::Set(const char* field, const std::optional<double>& number) {
  if (number && std::isfinite(*number)) feature_->SetField(field, *number);
}

void NewLayer::Row::SetInteger(const char* field, std::int64_t number) {
  feature_->SetField(field, static_cast<GIntBig>(number));
}

void NewLayer::Write(Row row) {
  if (layer_->CreateFeature(row.Feature()) != OGRERR_NONE)
    throw InputError("cannot write " + path_ + ": " + CPLGetLastErrorMsg());
}

NewGeopackage::NewGeopackage(const std::string& path, const Crs& crs)
    : path_(path),
      // GDAL wants the ending .gpkg for the file to be a valid GeoPackage.
      partial_(fs::path(path).replace_extension().string() + "." + std::to_string(getpid()) +
               ".part.gpkg") {
  RegisterGdalDrivers();
  if (crs_.importFromWkt(crs.Wkt().c_str()) != OGRERR_NONE)
    throw InputError(path + ": the block's CRS cannot be written: " + CPLGetLastErrorMsg());
  crs_.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
  GDALDriver* driver = GetGDALDriverManager()->GetDriverByName("GPKG");
  if (driver == nullptr) Fail("this GDAL has no GeoPackage driver; install GDAL with SQLite");
  fs::remove(partial_);
  dataset_.reset(driver->Create(partial_.c_str(), 0, 0, 0, GDT_Unknown, nullptr));
  if (!dataset_)
    Fail(std::string(CPLGetLastErrorMsg()) + "; choose a folder that you may write to");
  if (dataset_->StartTransaction() != OGRERR_NONE) Fail(CPLGetLastErrorMsg());
}

NewGeopackage::~NewGeopackage() {
  dataset_.reset();
  std::error_code ignored;  // after the rename it is gone already
  fs::remove(partial_, ignored);
  fs::remove(partial_ + "-journal", ignored);
}

NewLayer NewGeopackage::AddLayer(const char* name, OGRwkbGeometryType type, const char* description,
                                 const std::vector<LayerField>& fields) {
  char** options = CSLSetNameValue(nullptr, "DESCRIPTION", description);
  OGRLayer* layer = dataset_->CreateLayer(name, type == wkbNone ? nullptr : &crs_, type, options);
  CSLDestroy(options);
  if (layer == nullptr) Fail(CPLGetLastErrorMsg());
  for (const LayerField& field : fields) {
    OGRFieldDefn definition(field.name, field.type);
    if (layer->CreateField(&definition) != OGRERR_NONE) Fail(CPLGetLastErrorMsg());
  }
  return NewLayer(layer, path_);
}

void NewGeopackage::Finish() {
  if (dataset_->CommitTransaction() != OGRERR_NONE) Fail(CPLGetLastErrorMsg());
  CPLErrorReset();
  dataset_.reset();  // writes the spatial indexes
  if (CPLGetLastErrorType() >= CE_Failure) Fail(CPLGetLastErrorMsg());
  std::error_code error;
  fs::rename(partial_, path_, error);
  if (error) Fail(error.message());
}

void NewGeopackage::Fail(const std::string& why) const {
  throw InputError("cannot write " + path_ + ": " + why);
}

}  // namespace orient
