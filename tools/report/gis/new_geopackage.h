// A GeoPackage written whole or not at all.
#pragma once

#include <gdal_priv.h>
#include <ogrsf_frmts.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/terrain/crs.h"

namespace orient {

struct LayerField {
  const char* name;
  OGRFieldType type;
};

// One layer and the path to name where it fails.
class NewLayer {
 public:
  NewLayer(OGRLayer* layer, std::string path) : layer_(layer), path_(std::move(path)) {}

  // A new feature with the values that are there.
  class Row {
   public:
    explicit Row(OGRLayer* layer) : feature_(OGRFeature::CreateFeature(layer->GetLayerDefn())) {}
    void Set(const char* field, const std::string& text);  // made valid UTF-8
    void Set(const char* field, const std::optional<double>& number);
    void SetInteger(const char* field, std::int64_t number);
    void SetGeometry(const OGRGeometry& geometry) { feature_->SetGeometry(&geometry); }
    OGRFeature* Feature() { return feature_.get(); }

   private:
    OGRFeatureUniquePtr feature_;
  };

  Row NewRow() { return Row(layer_); }
  void Write(Row row);

 private:
  OGRLayer* layer_;
  std::string path_;
};

// Made in memory, since SQLite would write files of its own beside it. All members throw InputError
// naming the file where it cannot be written.
class NewGeopackage {
 public:
  NewGeopackage(const std::string& path, const Crs& crs);
  NewGeopackage(const NewGeopackage&) = delete;
  NewGeopackage& operator=(const NewGeopackage&) = delete;
  ~NewGeopackage();

  // `type` wkbNone: a table without places, and without a CRS.
  NewLayer AddLayer(const char* name, OGRwkbGeometryType type, const char* description,
                    const std::vector<LayerField>& fields);
  // SQL, as it stands, after all layers.
  void Execute(const std::vector<std::string>& statements);
  void Finish();

 private:
  [[noreturn]] void Fail(const std::string& why) const;

  std::string path_, in_memory_;
  OGRSpatialReference crs_;
  GDALDatasetUniquePtr dataset_;
};

}  // namespace orient
