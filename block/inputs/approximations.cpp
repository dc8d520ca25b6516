#include "block/inputs/approximations.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
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
#include "core/base/median.h"
#include "core/base/number_text.h"
#include "core/base/open_dataset.h"
#include "core/base/quiet_gdal.h"
#include "core/base/trimmed.h"

namespace orient::block {
namespace {

constexpr double kReach = 0.5;  // half the side of a frame's footprint, in flying heights

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
    if (point->IsEmpty() || !xy.allFinite())
      throw InputError(fmt::format("{} (photo {}) is an empty point", where, row.photo));
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
    const std::optional<double> in_column = HeightInColumn(feature, where);
    const double height = in_column ? *in_column : point.Is3D() != 0 ? point.getZ() : std::nan("");
    if (std::isfinite(height)) return height;
    if (heights_ == Heights::kMayBeAbsent) return std::nan("");
    throw InputError(where +
                     " has no flying height; give points a z or a column height (m), or the "
                     "flying height above the ground: flying_height_m or scale under [flight] of a "
                     "block file, or --flying-height-m of 'orient exterior'");
  }

  // Empty where the column says nothing. GDAL would make 0 of a text that is not a number.
  std::optional<double> HeightInColumn(const OGRFeature& feature, const std::string& where) const {
    if (height_ < 0 || !feature.IsFieldSetAndNotNull(height_)) return std::nullopt;
    if (feature.GetFieldDefnRef(height_)->GetType() != OFTString)
      return feature.GetFieldAsDouble(height_);
    const std::string text(Trimmed(feature.GetFieldAsString(height_)));
    if (text.empty()) return std::nullopt;
    const auto height = SignedNumberIn(text);
    if (!height)
      throw InputError(
          fmt::format("{}: the height \"{}\" is not a number with a point as its "
                      "decimal mark",
                      where, text));
    return height;
  }

  std::string path_;
  const Crs& crs_;
  Heights heights_;
  GDALDatasetUniquePtr dataset_;
  OGRLayer* layer_ = nullptr;
  int name_ = -1, height_ = -1;
};

}  // namespace

std::string Listed(const std::vector<std::string>& names) {
  constexpr std::size_t kMost = 5;
  const auto end = names.begin() + static_cast<std::ptrdiff_t>(std::min(names.size(), kMost));
  return fmt::format("{}{}", fmt::join(names.begin(), end, ", "),
                     names.size() > kMost ? ", ..." : "");
}

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
  sigma[2] = std::max(sigma[2], row.least_height_sigma_m);
  return sigma;
}

OrientationTable ReadApproximations(const std::string& path, const Crs& crs, Heights heights) {
  if (IsOrientationTable(path))
    return ReadOrientationTable(
        path, heights == Heights::kRequired ? OpenCells::kAngles : OpenCells::kAnglesAndHeights);
  const QuietGdal quiet;
  OrientationTable table = FlightIndex(path, crs, heights).Read();
  quiet.ThrowFaults();
  return table;
}

Findings RemarksOn(const OrientationTable& table, const std::string& path) {
  Findings remarks;
  const auto add = [&](Reason reason, const std::vector<std::string>& names) {
    if (names.empty()) return;
    remarks.push_back({.reason = reason,
                       .value = static_cast<double>(names.size()),
                       .where = path + ": " + Listed(names)});
  };
  add(Reason::kAngleColumnsIgnored, table.ignored_angles);
  add(Reason::kRowsWithoutPosition, table.without_position);
  return remarks;
}

void NameOtherPhotos(const std::vector<OrientationRow>& rows, const std::string& path,
                     const std::set<std::string>& photos, Findings* remarks,
                     std::vector<std::string>* not_there) {
  std::vector<std::string> others;
  for (const OrientationRow& row : rows)
    if (!photos.contains(row.photo)) others.push_back(row.photo);
  if (others.empty()) return;
  remarks->push_back({.reason = Reason::kApproximationsOfOtherPhotos,
                      .value = static_cast<double>(others.size()),
                      .where = path + ": " + Listed(others)});
  if (IsOrientationTable(path)) not_there->insert(not_there->end(), others.begin(), others.end());
}

void NameAbsentOfStrips(const FlightPlan& flight, const std::set<std::string>& photos,
                        Findings* remarks) {
  std::vector<std::string> absent;
  for (const FlightStrip& strip : flight.strips)
    for (const std::string& photo : strip.photos)
      if (!photos.contains(photo)) absent.push_back(photo);
  if (!absent.empty())
    remarks->push_back({.reason = Reason::kStripPhotosAbsent,
                        .value = static_cast<double>(absent.size()),
                        .where = Listed(absent)});
}

void RequireCrs(const Crs& crs, const OrientationTable& table, const std::string& path) {
  if (table.crs && !table.crs->SameAs(crs))
    throw InputError(
        fmt::format("{}: its .prj says {}, the block's CRS is {}; convert the table to the block's",
                    path, table.crs->Name(), crs.Name()));
}

void RequireOneCamera(const OrientationTable& table, const std::string& path,
                      const std::set<std::string>& photos) {
  std::set<std::string> cameras;
  for (const OrientationRow& row : table.rows)
    if (photos.contains(row.photo) && !row.camera.empty()) cameras.insert(row.camera);
  if (cameras.size() < 2) return;
  throw InputError(
      fmt::format("{} names {} cameras of the given photos in its column camera ({}), but there is "
                  "one camera file; orient each camera's photos by themselves",
                  path, cameras.size(), fmt::join(cameras, ", ")));
}

GroundSurface SurfaceAround(const std::string& dem, const Crs& crs,
                            const std::vector<OrientationRow>& rows, double reach_m) {
  constexpr double kLeast_m = 50;
  const double margin_m = std::max(kLeast_m, reach_m);
  Bounds bounds = Bounds::OfNothing();
  for (const OrientationRow& row : rows) {
    const auto& place = row.pose.position_m;
    bounds.Include(place.x() - margin_m, place.y() - margin_m);
    bounds.Include(place.x() + margin_m, place.y() + margin_m);
  }
  return GroundSurface::FromFile(dem, crs, bounds);
}

double GroundAround(const GroundSurface& surface, const Eigen::Vector3d& place, double reach_m) {
  constexpr int kRings = 20, kDirections = 16;
  if (const auto height = surface.HeightAt(place.x(), place.y())) return *height;
  std::vector<double> heights;
  for (int ring = 1; ring <= kRings; ++ring) {
    for (int direction = 0; direction < kDirections; ++direction) {
      const double radius_m = reach_m * ring / kRings;
      const double angle = 2 * std::numbers::pi * direction / kDirections;
      if (const auto height = surface.HeightAt(place.x() + radius_m * std::cos(angle),
                                               place.y() + radius_m * std::sin(angle)))
        heights.push_back(*height);
    }
  }
  return heights.empty() ? surface.MeanHeight() : Median(std::move(heights));
}

double HeightOver(const GroundSurface& surface, const Eigen::Vector3d& place,
                  double flying_height_m) {
  return GroundAround(surface, place, kReach * flying_height_m) + flying_height_m;
}

std::set<std::string> CompleteHeights(const std::string& dem, const Crs& crs,
                                      double flying_height_m, std::vector<OrientationRow>* rows) {
  std::set<std::string> completed;
  const auto lacks = [](const OrientationRow& row) { return std::isnan(row.pose.position_m.z()); };
  if (std::none_of(rows->begin(), rows->end(), lacks)) return completed;
  const GroundSurface surface = SurfaceAround(dem, crs, *rows, flying_height_m);
  for (OrientationRow& row : *rows) {
    if (!lacks(row)) continue;
    completed.insert(row.photo);
    Eigen::Vector3d& place = row.pose.position_m;
    place.z() = HeightOver(surface, place, flying_height_m);
    row.least_height_sigma_m = kFlyingHeightSpread * flying_height_m;
    if (row.sigma) (*row.sigma)[2] = std::max((*row.sigma)[2], row.least_height_sigma_m);
  }
  return completed;
}

}  // namespace orient::block
