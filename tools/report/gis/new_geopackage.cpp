#include "tools/report/gis/new_geopackage.h"

#include <cpl_conv.h>
#include <cpl_error.h>
#include <cpl_vsi.h>
#include <fmt/format.h>

#include <cmath>

#include "core/base/atomic_write.h"
#include "core/base/error.h"
#include "core/base/quiet_gdal.h"
#include "tools/report/html_text.h"

namespace orient {

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
      // One name space for the whole process; GDAL wants the ending .gpkg.
      in_memory_(fmt::format("/vsimem/{}.gpkg", fmt::ptr(this))) {
  RegisterGdalDrivers();
  if (crs_.importFromWkt(crs.Wkt().c_str()) != OGRERR_NONE)
    throw InputError(path + ": the block's CRS cannot be written: " + CPLGetLastErrorMsg());
  crs_.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
  GDALDriver* driver = GetGDALDriverManager()->GetDriverByName("GPKG");
  if (driver == nullptr) Fail("this GDAL has no GeoPackage driver; install GDAL with SQLite");
  dataset_.reset(driver->Create(in_memory_.c_str(), 0, 0, 0, GDT_Unknown, nullptr));
  if (!dataset_) Fail(CPLGetLastErrorMsg());
  if (dataset_->StartTransaction() != OGRERR_NONE) Fail(CPLGetLastErrorMsg());
}

NewGeopackage::~NewGeopackage() {
  dataset_.reset();
  VSIUnlink(in_memory_.c_str());
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

void NewGeopackage::Execute(const std::vector<std::string>& statements) {
  for (const std::string& statement : statements) {
    CPLErrorReset();
    dataset_->ReleaseResultSet(dataset_->ExecuteSQL(statement.c_str(), nullptr, nullptr));
    if (CPLGetLastErrorType() >= CE_Failure) Fail(CPLGetLastErrorMsg());
  }
}

void NewGeopackage::Finish() {
  if (dataset_->CommitTransaction() != OGRERR_NONE) Fail(CPLGetLastErrorMsg());
  CPLErrorReset();
  dataset_.reset();  // writes the spatial indexes
  if (CPLGetLastErrorType() >= CE_Failure) Fail(CPLGetLastErrorMsg());
  vsi_l_offset size = 0;
  const GByte* bytes = VSIGetMemFileBuffer(in_memory_.c_str(), &size, FALSE);
  if (bytes == nullptr) Fail("GDAL lost it");
  WriteFileAtomically(path_, {reinterpret_cast<const char*>(bytes), static_cast<size_t>(size)});
}

void NewGeopackage::Fail(const std::string& why) const {
  throw InputError("cannot write " + path_ + ": " + why);
}

}  // namespace orient
