#include "ortho/seamlines.h"

#include <cpl_conv.h>
#include <cpl_vsi.h>
#include <fmt/format.h>
#include <gdal_alg.h>
#include <gdal_priv.h>
#include <ogrsf_frmts.h>

#include <algorithm>
#include <utility>

#include "core/base/atomic_write.h"
#include "core/base/error.h"
#include "core/base/geopackage/self_description.h"
#include "core/base/open_dataset.h"
#include "core/base/quiet_gdal.h"

namespace orient::ortho {
namespace {

using Eigen::Vector2d;
using Geometry = OGRGeometryUniquePtr;

constexpr const char* kLayer = "seamlines";
constexpr const char* kPhoto = "photo";

Geometry PolygonOf(const std::vector<Vector2d>& outline) {
  auto* ring = new OGRLinearRing;  // its polygon takes it over
  for (const Vector2d& point : outline) ring->addPoint(point.x(), point.y());
  ring->closeRings();
  auto polygon = std::make_unique<OGRPolygon>();
  polygon->addRingDirectly(ring);
  Geometry valid(polygon->MakeValid());
  return valid ? std::move(valid) : Geometry(polygon.release());
}

// The area nearer to `from` than to `to`, as far as the photos' ground reaches.
Geometry NearerTo(const Vector2d& from, const Vector2d& to, double reach) {
  const Vector2d away = (from - to).normalized() * reach, middle = 0.5 * (from + to);
  const Vector2d along(-away.y(), away.x());
  return PolygonOf({middle + along, middle - along, middle - along + away, middle + along + away,
                    middle + along});
}

double ReachOf(const std::vector<SeamPhoto>& photos) {
  Bounds all = Bounds::OfNothing();
  for (const SeamPhoto& photo : photos) {
    all.Include(photo.nadir_m.x(), photo.nadir_m.y());
    for (const Vector2d& point : photo.outline_m) all.Include(point.x(), point.y());
  }
  return 4 * std::max(all.max_x - all.min_x, all.max_y - all.min_y) + 1;
}

// Whether `a` takes precedence over `b`: of photos with the same nadir, the first does.
bool Precedes(const std::vector<SeamPhoto>& photos, std::size_t a, std::size_t b) {
  return photos[a].nadir_m == photos[b].nadir_m && a < b;
}

// The photo's ground without what another photo shows from a nearer nadir.
Geometry PartOf(const std::vector<SeamPhoto>& photos, const std::vector<Geometry>& shown,
                std::size_t i, double reach) {
  Geometry part(shown[i]->clone());
  for (std::size_t j = 0; j < photos.size() && part && !part->IsEmpty(); ++j) {
    if (j == i || !part->Intersects(shown[j].get()) || Precedes(photos, i, j)) continue;
    Geometry theirs(shown[j]->clone());
    if (photos[i].nadir_m != photos[j].nadir_m) {
      const Geometry nearer = NearerTo(photos[j].nadir_m, photos[i].nadir_m, reach);
      theirs.reset(theirs->Intersection(nearer.get()));
    }
    if (theirs) part.reset(part->Difference(theirs.get()));
  }
  return part;
}

// A raster of integers in memory.
GDALDatasetUniquePtr LabelRaster(const MapGrid& grid, const PixelWindow& window) {
  RegisterGdalDrivers();
  GDALDatasetUniquePtr memory(GetGDALDriverManager()->GetDriverByName("MEM")->Create(
      "", window.width, window.height, 1, GDT_Int32, nullptr));
  if (!memory) throw InputError("no memory for the seamlines");
  const Bounds bounds = grid.BoundsOf(window);
  std::array<double, 6> transform = {bounds.min_x, grid.gsd_m, 0, bounds.max_y, 0, -grid.gsd_m};
  memory->SetGeoTransform(transform.data());
  return memory;
}

OGRSpatialReference ReferenceOf(const Crs& crs) {
  OGRSpatialReference reference;
  reference.importFromWkt(crs.Wkt().c_str());
  reference.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
  return reference;
}

}  // namespace

struct Seamlines::Impl {
  std::vector<std::string> photos;
  std::vector<Geometry> polygons;

  void Add(const std::string& photo, Geometry polygon) {
    if (!polygon || polygon->IsEmpty()) return;
    photos.push_back(photo);
    polygons.push_back(std::move(polygon));
  }
};

Seamlines::Seamlines(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Seamlines::Seamlines(Seamlines&&) noexcept = default;
Seamlines& Seamlines::operator=(Seamlines&&) noexcept = default;
Seamlines::~Seamlines() = default;

Seamlines Seamlines::ByNearestNadir(const std::vector<SeamPhoto>& photos) {
  const QuietGdal quiet;
  std::vector<Geometry> shown;
  for (const SeamPhoto& photo : photos) shown.push_back(PolygonOf(photo.outline_m));
  const double reach = ReachOf(photos);
  auto impl = std::make_unique<Impl>();
  for (std::size_t i = 0; i < photos.size(); ++i)
    impl->Add(photos[i].name, PartOf(photos, shown, i, reach));
  return Seamlines(std::move(impl));
}

Seamlines Seamlines::OfCells(const std::vector<std::string>& photos, const MapGrid& cells,
                             const std::vector<int>& photo_of_cell) {
  const QuietGdal quiet;
  const GDALDatasetUniquePtr labels = LabelRaster(cells, {0, 0, cells.width, cells.height});
  GDALRasterBand* band = labels->GetRasterBand(1);
  std::vector<int> values = photo_of_cell;  // GDAL's functions take no constant
  const GDALDatasetUniquePtr shapes(
      GetGDALDriverManager()->GetDriverByName("Memory")->Create("", 0, 0, 0, GDT_Unknown, nullptr));
  OGRLayer* layer = shapes->CreateLayer("cells", nullptr, wkbPolygon, nullptr);
  OGRFieldDefn column("label", OFTInteger);
  if (band->RasterIO(GF_Write, 0, 0, cells.width, cells.height, values.data(), cells.width,
                     cells.height, GDT_Int32, 0, 0, nullptr) != CE_None ||
      layer == nullptr || layer->CreateField(&column) != OGRERR_NONE ||
      GDALPolygonize(band, nullptr, layer, 0, nullptr, nullptr, nullptr) != CE_None)
    throw InputError("seamlines cannot be drawn" + quiet.Message());
  std::vector<OGRMultiPolygon> of_photos(photos.size());
  for (const auto& feature : *layer) {
    const int label = feature->GetFieldAsInteger(0);
    if (label >= 0)
      of_photos[static_cast<std::size_t>(label)].addGeometry(feature->GetGeometryRef());
  }
  auto impl = std::make_unique<Impl>();
  for (std::size_t i = 0; i < photos.size(); ++i)
    impl->Add(photos[i], Geometry(of_photos[i].clone()));
  return Seamlines(std::move(impl));
}

Seamlines Seamlines::FromFile(const std::string& path, const Crs& crs) {
  const QuietGdal quiet;
  const GDALDatasetUniquePtr file = OpenVectorDataset(path);
  if (!file) throw InputError(path + ": cannot be read" + quiet.Message());
  OGRLayer* layer = file->GetLayerByName(kLayer);
  quiet.ThrowFaults();
  const int column = layer ? layer->GetLayerDefn()->GetFieldIndex(kPhoto) : -1;
  if (column < 0)
    throw InputError(path + ": has no layer \"seamlines\" with a column \"photo\"; take the file " +
                     "that 'orient ortho --mosaic' writes and edit its polygons");
  if (const OGRSpatialReference* reference = layer->GetSpatialRef()) {
    char* wkt = nullptr;
    reference->exportToWkt(&wkt);
    const std::string definition = wkt == nullptr ? "" : wkt;
    CPLFree(wkt);
    if (!SameHorizontalCrs(definition, crs.Wkt()))
      throw InputError(path + ": is in another CRS than the orthophotos (" + crs.Name() +
                       "); save it in theirs");
  }
  auto impl = std::make_unique<Impl>();
  for (const auto& feature : *layer) {
    const OGRGeometry* geometry = feature->GetGeometryRef();
    if (geometry == nullptr || geometry->IsEmpty()) continue;
    // Arcs are replaced by short straight segments: GDAL can draw only these.
    Geometry polygon(geometry->getLinearGeometry());
    const OGRwkbGeometryType type = polygon ? wkbFlatten(polygon->getGeometryType()) : wkbUnknown;
    const std::string photo = feature->GetFieldAsString(column);
    if (type != wkbPolygon && type != wkbMultiPolygon)
      throw InputError(fmt::format("{}: the seamline of photo {} is a {}; draw it as a polygon",
                                   path, photo, geometry->getGeometryName()));
    impl->Add(photo, std::move(polygon));
  }
  quiet.ThrowFaults();  // a fault would pass for the end of the polygons
  if (impl->photos.empty()) throw InputError(path + ": its layer \"seamlines\" has no polygon");
  return Seamlines(std::move(impl));
}

void Seamlines::Write(const std::string& path, const Crs& crs,
                      const std::map<std::string, std::string>& metadata) const {
  RegisterGdalDrivers();
  const QuietGdal quiet;
  const auto require = [&](bool done) {
    if (!done) throw InputError("cannot write " + path + quiet.Message());
  };
  const std::string in_memory = "/vsimem/" + std::to_string(std::uintptr_t(this)) + ".gpkg";
  // Otherwise the date of writing would be the only difference between two runs.
  const CPLConfigOptionSetter no_date("OGR_CURRENT_DATE", "1970-01-01T00:00:00.000Z", false);
  GDALDatasetUniquePtr file(GetGDALDriverManager()->GetDriverByName("GPKG")->Create(
      in_memory.c_str(), 0, 0, 0, GDT_Unknown, nullptr));
  require(file != nullptr);
  OGRSpatialReference reference = ReferenceOf(crs);
  OGRLayer* layer = file->CreateLayer(kLayer, &reference, wkbMultiPolygon, nullptr);
  OGRFieldDefn column(kPhoto, OFTString);
  require(layer != nullptr && layer->CreateField(&column) == OGRERR_NONE);
  for (std::size_t i = 0; i < impl_->photos.size(); ++i) {
    OGRFeature feature(layer->GetLayerDefn());
    feature.SetField(kPhoto, impl_->photos[i].c_str());
    feature.SetGeometryDirectly(
        OGRGeometryFactory::forceToMultiPolygon(impl_->polygons[i]->clone()));
    require(layer->CreateFeature(&feature) == OGRERR_NONE);
  }
  for (const std::string& statement : StatementsOfMetadata(metadata)) {
    CPLErrorReset();
    file->ReleaseResultSet(file->ExecuteSQL(statement.c_str(), nullptr, nullptr));
    require(CPLGetLastErrorType() < CE_Failure);
  }
  file.reset();  // writes the spatial index
  vsi_l_offset size = 0;
  const GByte* bytes = VSIGetMemFileBuffer(in_memory.c_str(), &size, FALSE);
  require(bytes != nullptr);
  WriteFileAtomically(path, {reinterpret_cast<const char*>(bytes), static_cast<size_t>(size)});
  VSIUnlink(in_memory.c_str());
}

const std::vector<std::string>& Seamlines::Photos() const { return impl_->photos; }

std::vector<int> Seamlines::PhotoAt(const MapGrid& grid, const PixelWindow& window) const {
  RegisterGdalDrivers();
  const QuietGdal quiet;
  std::vector<int> labels(
      static_cast<std::size_t>(window.width) * static_cast<std::size_t>(window.height), -1);
  const GDALDatasetUniquePtr memory = LabelRaster(grid, window);
  const Bounds bounds = grid.BoundsOf(window);
  memory->GetRasterBand(1)->Fill(-1);
  std::vector<OGRGeometryH> shapes;
  std::vector<double> values;
  // In reverse order, since the last one drawn prevails.
  for (std::size_t i = impl_->polygons.size(); i-- > 0;) {
    OGREnvelope box;
    impl_->polygons[i]->getEnvelope(&box);
    if (!bounds.Overlaps({box.MinX, box.MinY, box.MaxX, box.MaxY})) continue;
    shapes.push_back(OGRGeometry::ToHandle(impl_->polygons[i].get()));
    values.push_back(static_cast<double>(i));
  }
  if (shapes.empty()) return labels;
  int band = 1;
  if (GDALRasterizeGeometries(GDALDataset::ToHandle(memory.get()), 1, &band,
                              static_cast<int>(shapes.size()), shapes.data(), nullptr, nullptr,
                              values.data(), nullptr, nullptr, nullptr) != CE_None ||
      memory->GetRasterBand(1)->RasterIO(GF_Read, 0, 0, window.width, window.height, labels.data(),
                                         window.width, window.height, GDT_Int32, 0, 0,
                                         nullptr) != CE_None)
    throw InputError("seamlines cannot be drawn" + quiet.Message());
  return labels;
}

}  // namespace orient::ortho
