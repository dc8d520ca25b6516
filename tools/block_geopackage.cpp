#include "tools/block_geopackage.h"

#include <cpl_conv.h>
#include <cpl_error.h>
#include <gdal_priv.h>
#include <ogrsf_frmts.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <mutex>
#include <utility>

#include "core/error.h"
#include "core/geometry/quiet_gdal.h"
#include "tools/report/html_text.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

struct Field {
  const char* name;
  OGRFieldType type;
};

// One layer and the path to name where it fails.
class Layer {
 public:
  Layer(OGRLayer* layer, std::string path) : layer_(layer), path_(std::move(path)) {}

  // A new feature with the values that are there.
  class Row {
   public:
    explicit Row(OGRLayer* layer) : feature_(OGRFeature::CreateFeature(layer->GetLayerDefn())) {}
    void Set(const char* field, const std::string& text) {
      feature_->SetField(field, ValidText(text).c_str());
    }
    void Set(const char* field, const std::optional<double>& number) {
      if (number && std::isfinite(*number)) feature_->SetField(field, *number);
    }
    void SetInteger(const char* field, std::int64_t number) {
      feature_->SetField(field, static_cast<GIntBig>(number));
    }
    void SetGeometry(const OGRGeometry& geometry) { feature_->SetGeometry(&geometry); }
    OGRFeature* Feature() { return feature_.get(); }

   private:
    OGRFeatureUniquePtr feature_;
  };

  Row NewRow() { return Row(layer_); }
  void Write(Row row) {
    if (layer_->CreateFeature(row.Feature()) != OGRERR_NONE)
      throw InputError("cannot write " + path_ + ": " + CPLGetLastErrorMsg());
  }

 private:
  OGRLayer* layer_;
  std::string path_;
};

// The new file under another name, renamed at the end; removed where that is never reached.
class NewGeopackage {
 public:
  NewGeopackage(const std::string& path, const Crs& crs)
      : path_(path),
        // GDAL wants the ending .gpkg for the file to be a valid GeoPackage.
        partial_(fs::path(path).replace_extension().string() + "." + std::to_string(getpid()) +
                 ".part.gpkg") {
    static std::once_flag registered;
    std::call_once(registered, [] { GDALAllRegister(); });
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
  NewGeopackage(const NewGeopackage&) = delete;
  NewGeopackage& operator=(const NewGeopackage&) = delete;
  ~NewGeopackage() {
    dataset_.reset();
    std::error_code ignored;  // after the rename it is gone already
    fs::remove(partial_, ignored);
    fs::remove(partial_ + "-journal", ignored);
  }

  Layer AddLayer(const char* name, OGRwkbGeometryType type, const char* description,
                 const std::vector<Field>& fields) {
    char** options = CSLSetNameValue(nullptr, "DESCRIPTION", description);
    OGRLayer* layer = dataset_->CreateLayer(name, &crs_, type, options);
    CSLDestroy(options);
    if (layer == nullptr) Fail(CPLGetLastErrorMsg());
    for (const Field& field : fields) {
      OGRFieldDefn definition(field.name, field.type);
      if (layer->CreateField(&definition) != OGRERR_NONE) Fail(CPLGetLastErrorMsg());
    }
    return Layer(layer, path_);
  }

  void Finish() {
    if (dataset_->CommitTransaction() != OGRERR_NONE) Fail(CPLGetLastErrorMsg());
    CPLErrorReset();
    dataset_.reset();  // writes the spatial indexes
    if (CPLGetLastErrorType() >= CE_Failure) Fail(CPLGetLastErrorMsg());
    std::error_code error;
    fs::rename(partial_, path_, error);
    if (error) Fail(error.message());
  }

 private:
  [[noreturn]] void Fail(const std::string& why) const {
    throw InputError("cannot write " + path_ + ": " + why);
  }

  std::string path_, partial_;
  OGRSpatialReference crs_;
  GDALDatasetUniquePtr dataset_;
};

std::string Joined(const std::vector<std::string>& messages) {
  std::string text;
  for (const std::string& message : messages) text += (text.empty() ? "" : "; ") + message;
  return text;
}

OGRPoint Point(const Eigen::Vector3d& p) { return OGRPoint(p.x(), p.y(), p.z()); }

std::optional<double> Component(const std::optional<Eigen::Vector2d>& vector, int i) {
  if (!vector) return std::nullopt;
  return (*vector)[i];
}

void WritePose(const ExteriorResult& result, Layer::Row* row) {
  constexpr const char* kAngles[] = {"omega", "phi", "kappa"};
  constexpr const char* kSigmas[] = {"sigma_x",     "sigma_y",   "sigma_z",
                                     "sigma_omega", "sigma_phi", "sigma_kappa"};
  if (result.pose) {
    row->SetGeometry(Point(result.pose->position_m));
    for (int i = 0; i < 3; ++i)
      row->Set(kAngles[i], DegFromRad(NormalizeAngle(result.pose->opk_rad[i])));
  }
  for (int i = 0; result.covariance && i < 6; ++i) {
    const double sigma = std::sqrt(std::max(0.0, (*result.covariance)(i, i)));
    row->Set(kSigmas[i], i < 3 ? sigma : DegFromRad(sigma));
  }
}

void WritePhotos(const std::vector<ExteriorResult>& results, NewGeopackage* file) {
  Layer layer = file->AddLayer("photos", wkbPoint25D, "Projection centres",
                               {{"name", OFTString},
                                {"status", OFTString},
                                {"omega", OFTReal},
                                {"phi", OFTReal},
                                {"kappa", OFTReal},
                                {"sigma_x", OFTReal},
                                {"sigma_y", OFTReal},
                                {"sigma_z", OFTReal},
                                {"sigma_omega", OFTReal},
                                {"sigma_phi", OFTReal},
                                {"sigma_kappa", OFTReal},
                                {"sigma0_px", OFTReal},
                                {"matched", OFTInteger},
                                {"searched", OFTInteger},
                                {"message", OFTString}});
  for (const ExteriorResult& result : results) {
    std::int64_t matched = 0, searched = 0;
    for (const PatchResult& patch : result.patches) {
      matched += patch.state == PatchState::kMatched;
      searched += patch.state != PatchState::kNotVisible;
    }
    Layer::Row row = layer.NewRow();
    WritePose(result, &row);
    row.Set("name", result.photo);
    row.Set("status", std::string(Name(result.status)));
    row.Set("sigma0_px", result.sigma0_px);
    row.SetInteger("matched", matched);
    row.SetInteger("searched", searched);
    row.Set("message", Joined(result.messages));
    layer.Write(std::move(row));
  }
}

void WriteFootprints(const std::vector<ExteriorResult>& results, NewGeopackage* file) {
  Layer layer = file->AddLayer("footprints", wkbPolygon, "Outlines of the frames on the ground",
                               {{"name", OFTString}, {"status", OFTString}});
  for (const ExteriorResult& result : results) {
    if (result.footprint_m.size() < 3) continue;
    OGRLinearRing ring;
    for (const Eigen::Vector3d& corner : result.footprint_m) ring.addPoint(corner.x(), corner.y());
    ring.closeRings();
    OGRPolygon polygon;
    polygon.addRing(&ring);
    Layer::Row row = layer.NewRow();
    row.SetGeometry(polygon);
    row.Set("name", result.photo);
    row.Set("status", std::string(Name(result.status)));
    layer.Write(std::move(row));
  }
}

void WritePatches(const std::vector<ExteriorResult>& results, NewGeopackage* file) {
  Layer layer = file->AddLayer("patches", wkbPoint25D, "Patches as each photo found them",
                               {{"patch", OFTInteger64},
                                {"photo", OFTString},
                                {"state", OFTString},
                                {"ncc", OFTReal},
                                {"residual_col_px", OFTReal},
                                {"residual_row_px", OFTReal},
                                {"sigma_col_px", OFTReal},
                                {"sigma_row_px", OFTReal},
                                {"reason", OFTString}});
  for (const ExteriorResult& result : results)
    for (const PatchResult& patch : result.patches) {
      Layer::Row row = layer.NewRow();
      if (patch.ground_m) row.SetGeometry(Point(*patch.ground_m));
      row.SetInteger("patch", patch.id);
      row.Set("photo", result.photo);
      row.Set("state", std::string(Name(patch.state)));
      row.Set("ncc", patch.ncc);
      row.Set("residual_col_px", Component(patch.residual_px, 0));
      row.Set("residual_row_px", Component(patch.residual_px, 1));
      row.Set("sigma_col_px", Component(patch.sigma_px, 0));
      row.Set("sigma_row_px", Component(patch.sigma_px, 1));
      row.Set("reason", patch.reason);
      layer.Write(std::move(row));
    }
}

// The linear part of ground_from_pixel [m per px] that the matched patches agree on: enough to turn
// and scale a residual, whatever the relief. Empty with fewer than three patches.
std::optional<Eigen::Matrix2d> GroundFromPixelScale(const ExteriorResult& result) {
  std::vector<PointPair2d> pairs;
  for (const PatchResult& patch : result.patches)
    if (patch.state == PatchState::kMatched && patch.ground_m && patch.pixel)
      pairs.push_back({*patch.pixel, patch.ground_m->head<2>(), 1.0});
  const auto fit = FitAffine(pairs);
  if (!fit) return std::nullopt;
  return fit->transform.A;
}

// The same for every photo of a block, so that lengths can be compared in the map.
constexpr double kExaggeration = 100;

void WriteResiduals(const std::vector<ExteriorResult>& results, NewGeopackage* file) {
  Layer layer = file->AddLayer("residuals", wkbLineString, "Residuals on the ground, exaggerated",
                               {{"patch", OFTInteger64},
                                {"photo", OFTString},
                                {"state", OFTString},
                                {"length_px", OFTReal},
                                {"exaggeration", OFTReal}});
  for (const ExteriorResult& result : results) {
    const auto scale = GroundFromPixelScale(result);
    if (!scale) continue;
    for (const PatchResult& patch : result.patches) {
      if (!patch.ground_m || !patch.residual_px) continue;
      const Eigen::Vector2d from = patch.ground_m->head<2>();
      const Eigen::Vector2d to = from + kExaggeration * *scale * *patch.residual_px;
      OGRLineString line;
      line.addPoint(from.x(), from.y());
      line.addPoint(to.x(), to.y());
      Layer::Row row = layer.NewRow();
      row.SetGeometry(line);
      row.SetInteger("patch", patch.id);
      row.Set("photo", result.photo);
      row.Set("state", std::string(Name(patch.state)));
      row.Set("length_px", patch.residual_px->norm());
      row.Set("exaggeration", kExaggeration);
      layer.Write(std::move(row));
    }
  }
}

}  // namespace

std::string WriteBlockGeopackage(const std::string& directory, const Crs& crs,
                                 const std::vector<ExteriorResult>& results) {
  const std::string path = (fs::path(directory) / "block.gpkg").string();
  const QuietGdal quiet;
  NewGeopackage file(path, crs);
  WritePhotos(results, &file);
  WriteFootprints(results, &file);
  WritePatches(results, &file);
  WriteResiduals(results, &file);
  file.Finish();
  return path;
}

}  // namespace orient
