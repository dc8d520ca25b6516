#include "block/inputs/harvest_sources.h"

#include <filesystem>

#include "block/inputs/photo_interior.h"
#include "core/base/error.h"
#include "core/files/results.h"
#include "patchdb/harvest/source_view.h"

namespace orient::block {
namespace {
namespace fs = std::filesystem;

class Photos : public HarvestSources {
 public:
  Photos(const PhotosToHarvest& photos, double orientation_sigma_px)
      : photos_(photos), orientation_sigma_px_(orientation_sigma_px) {
    for (const std::string& path : photos.paths)
      Footprint(RowOf(path), kLowestGround_m, kHighestGround_m);
  }
  patchdb::SourceKind Kind() const override { return patchdb::SourceKind::kPhoto; }

  Bounds Footprint(std::size_t source, double low_m, double high_m) const override {
    return Footprint(RowOf(photos_.paths[source]), low_m, high_m);
  }

  OpenSource Open(std::size_t source, const GroundSurface& surface,
                  bool /*as_witness*/) const override {
    OpenSource open;
    open.raster = std::make_unique<Raster>(Raster::Open(photos_.paths[source]));
    open.view = patchdb::MakePhotoSource(View(source, *open.raster, surface), Covariance(source),
                                         orientation_sigma_px_, surface);
    return open;
  }

  patchdb::HarvestResult Harvest(std::size_t source, const Raster& raster,
                                 const GroundSurface& surface,
                                 const patchdb::HarvestOptions& options,
                                 const patchdb::HarvestProgress& progress,
                                 const patchdb::HarvestContext& context) const override {
    return patchdb::HarvestPhoto(raster, View(source, raster, surface), Covariance(source), surface,
                                 options, progress, context);
  }

 private:
  const OrientationRow& RowOf(const std::string& photo) const {
    const OrientationRow* row = photos_.orientation.Find(PhotoName(photo));
    if (row == nullptr)
      throw InputError(photos_.orientation_path + " has no row for photo '" + PhotoName(photo) +
                       "'; add its orientation or leave the photo out");
    return *row;
  }

  Bounds Footprint(const OrientationRow& row, double low_m, double high_m) const {
    const auto bounds = FootprintBounds(photos_.camera.camera, row.pose, low_m, high_m);
    if (!bounds)
      throw InputError(photos_.orientation_path + ": photo '" + row.photo +
                       "' does not point at the ground; check its height and angles");
    return *bounds;
  }

  PhotoView View(std::size_t source, const Raster& raster, const GroundSurface& surface) const {
    const PhotoInterior interior =
        PhotoInteriorOf(raster, photos_.camera, photos_.interior_folder,
                        [&] { return ScanOrientationOf(photos_.paths[source]); });
    const Pose& pose = RowOf(photos_.paths[source]).pose;
    PhotoView view{photos_.camera.camera, interior.photo_from_pixel, pose,
                   interior.film_correction};
    view.camera = WithEarthEffects(view.camera, photos_.earth, pose.position_m.z(),
                                   surface.MeanHeight(), view.PixelSize());
    return view;
  }

  std::optional<ScanOrientation> ScanOrientationOf(const std::string& photo) const {
    const std::string folder = fs::path(photos_.orientation_path).parent_path().string();
    const std::string result = ExteriorResultPath(folder, PhotoName(photo));
    if (!fs::exists(result)) return std::nullopt;
    const ExteriorResult exterior = ReadExteriorResult(result);
    // The table's pose need not be this result's: in another scan orientation kappa is another.
    constexpr double kSame_m = 0.01, kSame_rad = 1e-5;
    const Pose& row = RowOf(photo).pose;
    const bool same = exterior.pose &&
                      (exterior.pose->position_m - row.position_m).norm() < kSame_m &&
                      (exterior.pose->opk_rad - row.opk_rad).norm() < kSame_rad;
    return same ? exterior.orientation : std::nullopt;
  }

  std::optional<Matrix6d> Covariance(std::size_t source) const {
    const OrientationRow& row = RowOf(photos_.paths[source]);
    if (!row.sigma) return std::nullopt;
    return Matrix6d(row.sigma->cwiseAbs2().asDiagonal());
  }

  const PhotosToHarvest& photos_;
  double orientation_sigma_px_;
};

class Orthophotos : public HarvestSources {
 public:
  Orthophotos(const std::vector<std::string>& paths, const Crs& crs, double orientation_sigma_px)
      : paths_(paths), crs_(crs), orientation_sigma_px_(orientation_sigma_px) {
    for (const std::string& path : paths)
      footprints_.push_back(patchdb::OrthoFootprint(Raster::Open(path), crs));
  }
  patchdb::SourceKind Kind() const override { return patchdb::SourceKind::kOrthophoto; }

  Bounds Footprint(std::size_t source, double /*low_m*/, double /*high_m*/) const override {
    return footprints_[source];
  }

  OpenSource Open(std::size_t source, const GroundSurface& surface,
                  bool as_witness) const override {
    OpenSource open;
    open.raster = std::make_unique<Raster>(Raster::Open(paths_[source]));
    open.view = patchdb::MakeOrthoSource(*open.raster, crs_, orientation_sigma_px_, surface);
    if (as_witness) open.coverage = std::make_unique<patchdb::Coverage>(*open.raster);
    return open;
  }

  patchdb::HarvestResult Harvest(std::size_t /*source*/, const Raster& raster,
                                 const GroundSurface& surface,
                                 const patchdb::HarvestOptions& options,
                                 const patchdb::HarvestProgress& progress,
                                 const patchdb::HarvestContext& context) const override {
    return patchdb::HarvestOrtho(raster, crs_, surface, options, progress, context);
  }

 private:
  const std::vector<std::string>& paths_;
  const Crs& crs_;
  double orientation_sigma_px_;
  std::vector<Bounds> footprints_;
};

}  // namespace

std::unique_ptr<HarvestSources> PhotoSources(const PhotosToHarvest& photos,
                                             double orientation_sigma_px) {
  return std::make_unique<Photos>(photos, orientation_sigma_px);
}

std::unique_ptr<HarvestSources> OrthophotoSources(const std::vector<std::string>& paths,
                                                  const Crs& crs, double orientation_sigma_px) {
  return std::make_unique<Orthophotos>(paths, crs, orientation_sigma_px);
}

}  // namespace orient::block
