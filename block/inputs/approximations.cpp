#include "block/inputs/approximations.h"

#include <fmt/format.h>
#include <gdal_priv.h>
#include <ogrsf_frmts.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <memory>
#include <numbers>
#include <set>

#include "core/base/error.h"
#include "core/base/open_dataset.h"
#include "core/base/quiet_gdal.h"

namespace orient::block {
namespace {

// The first of these columns that the layer has (whatever its case), or -1.
template <std::size_t kCount>
int FieldOf(OGRLayer* layer, const std::array<const char*, kCount>& names) {
  for (const char* name : names)
    if (const int field = layer->GetLayerDefn()->GetFieldIndex(name); field >= 0) return field;
  return -1;
}

constexpr std::array kNameFields = {"filename", "photo", "image", "name", "id"};
constexpr std::array kHeightFields = {"z",   "height",        "altitude",
                                      "alt", "flying_height", "flying_hei"};

class FlightIndex {
 public:
  FlightIndex(const std::string& path, const Crs& crs, Heights heights)
      : path_(path), crs_(crs), heights_(heights) {
    RegisterGdalDrivers();
    dataset_ = OpenVectorDataset(path);
    if (!dataset_)
      throw InputError(
          path + ": neither an OPK CSV nor a vector file that GDAL reads: " + CPLGetLastErrorMsg());
    if (dataset_->GetLayerCount() != 1)
      throw InputError(fmt::format("{}: has {} layers; approximations are the points of one", path,
                                   dataset_->GetLayerCount()));
    layer_ = dataset_->GetLayer(0);
    name_ = FieldOf(layer_, kNameFields);
    height_ = FieldOf(layer_, kHeightFields);
    if (name_ < 0) throw InputError(path + ": no column holds the photos' names; call it filename");
  }

  OrientationTable Read() {
    OrientationTable table;
    table.crs = crs_;
    const auto transform = Transform();
    std::set<std::string> seen;
    for (const OGRFeatureUniquePtr& feature : *layer_) {
      OrientationRow row = Row(*feature, transform);
      if (!seen.insert(row.photo).second)
        throw InputError(fmt::format("{}: photo {} appears twice; keep one", path_, row.photo));
      table.rows.push_back(std::move(row));
    }
    if (table.rows.empty()) throw InputError(path_ + ": has no points");
    return table;
  }

 private:
  // Empty where the points are in the block's CRS already.
  std::optional<CoordinateTransform> Transform() const {
    const OGRSpatialReference* own = layer_->GetSpatialRef();
    if (own == nullptr)
      throw InputError(path_ + ": does not say which CRS its points are in; add one");
    char* wkt = nullptr;
    own->exportToWkt(&wkt);
    const std::string definition = wkt == nullptr ? "" : wkt;
    CPLFree(wkt);
    if (SameHorizontalCrs(definition, crs_.Wkt())) return std::nullopt;
    return CoordinateTransform::Between(crs_.Wkt(), definition);
  }

  OrientationRow Row(const OGRFeature& feature,
                     const std::optional<CoordinateTransform>& transform) const {
    OrientationRow row;
    row.attitude_known = false;
    row.photo = PhotoName(feature.GetFieldAsString(name_));
    const std::string where = fmt::format("{}: feature {}", path_, feature.GetFID());
    if (row.photo.empty()) throw InputError(where + " has no photo name");
    const OGRGeometry* geometry = feature.GetGeometryRef();
    if (geometry == nullptr || wkbFlatten(geometry->getGeometryType()) != wkbPoint)
      throw InputError(fmt::format("{} (photo {}) is not a point", where, row.photo));
    const OGRPoint* point = geometry->toPoint();
    Eigen::Vector2d xy(point->getX(), point->getY());
    if (transform) {
      const auto there = (*transform)(xy);
      if (!there)
        throw InputError(where + " (photo " + row.photo + ") cannot be transformed to " +
                         crs_.Name());
      xy = *there;
    }
    const double height = Height(feature, *point, where);
    row.pose.position_m << xy, height;
    return row;
  }

  double Height(const OGRFeature& feature, const OGRPoint& point, const std::string& where) const {
    const bool in_column = height_ >= 0 && feature.IsFieldSetAndNotNull(height_);
    const double height = in_column           ? feature.GetFieldAsDouble(height_)
                          : point.Is3D() != 0 ? point.getZ()
                                              : std::nan("");
    if (std::isfinite(height)) return height;
    if (heights_ == Heights::kMayBeAbsent) return std::nan("");
    throw InputError(where +
                     " has no flying height; give points a z or a column height (m), or the block "
                     "file's [flight] a scale or flying_height_m");
  }

  std::string path_;
  const Crs& crs_;
  Heights heights_;
  GDALDatasetUniquePtr dataset_;
  OGRLayer* layer_ = nullptr;
  int name_ = -1, height_ = -1;
};

}  // namespace

bool IsOrientationTable(const std::string& path) {
  std::string extension = std::filesystem::path(path).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension == ".csv" || extension == ".txt";
}

Vector6d SigmaOfApproximation(const OrientationRow& row, std::optional<double> position_m,
                              std::optional<double> attitude_rad, std::optional<double> kappa_rad) {
  if (row.sigma) return *row.sigma;
  Vector6d sigma;
  sigma << Eigen::Vector3d::Constant(position_m.value_or(kPositionSigma_m)),
      Eigen::Vector3d::Constant(attitude_rad.value_or(kAttitudeSigma_rad));
  if (kappa_rad) sigma[5] = *kappa_rad;
  if (!row.attitude_known) sigma[5] = std::numbers::pi;
  return sigma;
}

OrientationTable ReadApproximations(const std::string& path, const Crs& crs, Heights heights) {
  if (IsOrientationTable(path)) return ReadOrientationTable(path, Attitudes::kMayBeAbsent);
  const QuietGdal quiet;
  OrientationTable table = FlightIndex(path, crs, heights).Read();
  quiet.ThrowFaults();
  return table;
}

}  // namespace orient::block
