#include "block/stages/exterior_setting.h"

#include <algorithm>

#include "block/inputs/approximations.h"
#include "block/inputs/block_camera.h"
#include "block/inputs/film_pixel.h"
#include "block/inputs/mark_shapes.h"
#include "block/inputs/measurement_inputs.h"
#include "core/base/date.h"
#include "core/base/error.h"
#include "core/base/median.h"
#include "exterior/search/search_prior.h"
#include "exterior/steps/predict.h"

namespace orient::block {
namespace {

// Includes the area of photos that show measured ground points: a frame's size around these points
// at the smallest scale at which photos are taken.
void IncludePoints(const ExteriorRunOptions& options, const Camera& camera, Bounds* region) {
  constexpr double kSmallestScale = 1e5;
  const double reach = 2e-3 * kSmallestScale * camera.FrameRadius();
  for (const std::string& path : options.photos)
    for (const auto& seen : options.measurements.ImagePointsOf(PhotoName(path)))
      if (const GroundPoint* point = options.measurements.Point(seen.point)) {
        region->Include(point->ground_m.x() - reach, point->ground_m.y() - reach);
        region->Include(point->ground_m.x() + reach, point->ground_m.y() + reach);
      }
}

// Where the photos' footprints may lie, so that only that part of the DEM is read.
Bounds Region(const OrientationTable& table, const Camera& camera,
              const ExteriorRunOptions& options) {
  Bounds region = Bounds::OfNothing();
  for (const std::string& path : options.photos) {
    const OrientationRow* row = table.Find(PhotoName(path));
    if (row == nullptr) continue;
    const double height = std::max(100.0, row->pose.position_m.z() - kLowestGround_m);
    const Vector6d sigma = SigmaOfApproximation(*row, options.position_sigma_m, std::nullopt);
    const double reach = 1.5 * height * camera.FrameRadius() / camera.principal_distance_mm +
                         3 * sigma.head<2>().maxCoeff();
    region.Include(row->pose.position_m.x() - reach, row->pose.position_m.y() - reach);
    region.Include(row->pose.position_m.x() + reach, row->pose.position_m.y() + reach);
  }
  IncludePoints(options, camera, &region);
  if (region.Empty() && options.approximations.empty())
    throw InputError(
        "no photo has an approximate position: there is no table of approximations, and none was "
        "read from the photos' files (EXIF; digital images only); give a table of approximations");
  if (region.Empty())
    throw InputError(options.approximations +
                     ": none of the given photos is in this table; its "
                     "'filename' column holds file names without folder and extension");
  return region;
}

Crs StoredCrs(const std::string& patchdb) {
  return patchdb::ControlPatches::Open(patchdb).GroundCrs();
}

Crs BlockCrs(const ExteriorRunOptions& options, const OrientationTable& table) {
  const Crs crs = options.crs ? *options.crs : table.crs ? *table.crs : StoredCrs(options.patchdb);
  RequireCrs(crs, table, options.approximations);
  return crs;
}

OrientationTable TableOfFile(const ExteriorRunOptions& options) {
  if (options.approximations.empty()) return {};
  OrientationTable table = ReadApproximations(
      options.approximations, options.crs ? *options.crs : StoredCrs(options.patchdb),
      options.flying_height_m ? Heights::kMayBeAbsent : Heights::kRequired);
  const std::vector<std::string> photos = PhotoNames(options.photos);
  RequireOneCamera(table, options.approximations, {photos.begin(), photos.end()});
  if (options.flying_height_m)
    CompleteHeights(options.dem, BlockCrs(options, table), *options.flying_height_m, &table.rows);
  return table;
}

// No approximation is known worse than this.
constexpr double kLargestSigma_m = 1e6;

// No photo is taken from higher above the ground.
constexpr double kHighestFlight_m = 30e3;

// Height of a photo of which only measured points are known, from its scale between the two points
// farthest apart in it. Empty with fewer than two.
std::optional<double> HeightByPoints(const ExteriorRunOptions& options, const Camera& camera,
                                     const std::string& photo, double pixel_mm) {
  struct Seen {
    Eigen::Vector2d photo_mm;
    Eigen::Vector3d ground_m;
  };
  std::vector<Seen> seen;
  for (const ImagePointMeasurement& point : options.measurements.ImagePointsOf(photo))
    if (const GroundPoint* ground = options.measurements.Point(point.point))
      seen.push_back({point.pixel ? pixel_mm * *point.pixel : *point.photo_mm, ground->ground_m});
  double farthest_mm = 0, apart_m = 0, ground_m = 0;
  for (const Seen& a : seen)
    for (const Seen& b : seen) {
      const double apart_mm = (a.photo_mm - b.photo_mm).norm();
      if (apart_mm <= farthest_mm) continue;
      farthest_mm = apart_mm;
      apart_m = (a.ground_m - b.ground_m).head<2>().norm();
      ground_m = (a.ground_m.z() + b.ground_m.z()) / 2;
    }
  if (farthest_mm == 0) return std::nullopt;
  return ground_m + apart_m / farthest_mm * camera.principal_distance_mm;
}

// The median over the run's photos, without impossible heights: earth curvature and refraction are
// treated alike in all photos.
double FlyingHeight(const OrientationTable& table, const ExteriorRunOptions& options,
                    const Camera& camera, double pixel_mm, double ground_m) {
  std::vector<double> heights;
  for (const std::string& path : options.photos) {
    const OrientationRow* row = table.Find(PhotoName(path));
    const std::optional<double> height_m =
        row ? row->pose.position_m.z() : HeightByPoints(options, camera, PhotoName(path), pixel_mm);
    if (height_m && *height_m > ground_m && *height_m < ground_m + kHighestFlight_m)
      heights.push_back(*height_m);
  }
  return heights.empty() ? ground_m : UpperMedian(std::move(heights));
}

CameraFile CameraOfRun(const ExteriorRunOptions& options) {
  if (!options.earth_k1) RefuseBlockCamera(options.camera, options.earth);
  CameraFile camera = ReadCameraFile(options.camera);
  if (camera.camera.kind == CameraKind::kFilm && !options.interior)
    throw UsageError(options.camera +
                     " is a film camera: name the folder with the results of 'orient interior' "
                     "with --interior");
  for (const std::string& photo : options.photos)
    RequireKnownMarks(options.measurements, PhotoName(photo), camera);
  return camera;
}

OrientationTable TableOfRun(const ExteriorRunOptions& options) {
  if (options.table) return *options.table;
  OrientationTable table = TableOfFile(options);
  ApplyDecidedPositions(
      options.measurements, PhotoNames(options.photos),
      {options.position_sigma_m, options.attitude_sigma_rad, options.kappa_sigma_rad}, {},
      &table.rows);
  return table;
}

// `camera`: as read from its file.
ExteriorSetting SettingOf(const ExteriorRunOptions& options, CameraFile camera,
                          OrientationTable table, const Crs& crs) {
  GroundSurface surface =
      GroundSurface::FromFile(options.dem, crs, Region(table, camera.camera, options));
  interior::MarkShapes marks;
  if (camera.camera.kind == CameraKind::kFilm) marks = LoadMarkShapes(camera);
  const double ground_m = surface.MeanHeight();
  const double own_k1 = camera.camera.earth_k1;
  const double pixel_mm = camera.camera.kind == CameraKind::kDigital
                              ? DigitalPhotoFromPixel(camera.camera).A(0, 0)
                              : FilmPixel_mm(camera.camera, options.photos).value_or(kFilmPixel_mm);
  camera.camera =
      options.earth_k1
          ? WithEarth(camera.camera, *options.earth_k1)
          : WithEarthEffects(camera.camera, options.earth,
                             FlyingHeight(table, options, camera.camera, pixel_mm, ground_m),
                             ground_m, pixel_mm);
  const double added_k1 = options.earth_k1.value_or(camera.camera.earth_k1 - own_k1);
  return {options, std::move(camera),  added_k1,    std::move(marks), std::move(table),
          crs,     std::move(surface), std::nullopt};
}

}  // namespace

void RequireCrsOfPatches(const std::string& patchdb, const Crs& crs) {
  const patchdb::ControlPatches patches = patchdb::ControlPatches::Open(patchdb);
  patches.RequireCurrentIndex();
  const Crs stored = patches.GroundCrs();
  if (!crs.SameAs(stored))
    throw InputError(patchdb + ": its CRS is " + stored.Name() + ", the block's is " + crs.Name() +
                     "; use a patch database in the block's CRS");
}

ExteriorSetting PrepareExterior(const ExteriorRunOptions& options) {
  CameraFile camera = CameraOfRun(options);
  OrientationTable table = TableOfRun(options);
  const Crs crs = BlockCrs(options, table);
  RequireCrsOfPatches(options.patchdb, crs);
  ExteriorSetting setting = SettingOf(options, std::move(camera), std::move(table), crs);
  if (patchdb::IsRegionFolder(options.patchdb))
    setting.regions = patchdb::ControlPatches::Open(options.patchdb);
  return setting;
}

Bounds AreaOf(const ExteriorSetting& setting, const PosePrior& prior, double sigmas) {
  return exterior::UncertainFootprint(setting.camera.camera, prior, setting.surface.MinHeight(),
                                      setting.surface.MaxHeight(), sigmas);
}

std::string PatchContentOfRun(const ExteriorRunOptions& options) {
  if (!patchdb::IsRegionFolder(options.patchdb))
    return patchdb::ControlPatches::Open(options.patchdb).ContentWithin({});
  const ExteriorSetting setting = PrepareExterior(options);
  std::vector<Bounds> areas = {Bounds::OfNothing()};
  IncludePoints(options, setting.camera.camera, &areas.front());
  for (const std::string& path : options.photos)
    if (const OrientationRow* row = setting.approximations.Find(PhotoName(path))) {
      const Vector6d sigma = SigmaOfApproximation(
          *row, options.position_sigma_m, options.attitude_sigma_rad, options.kappa_sigma_rad);
      const PosePrior prior{row->pose, sigma.cwiseAbs2().asDiagonal().toDenseMatrix()};
      areas.push_back(AreaOf(setting, prior, kStatedSigmas));
      areas.push_back(
          AreaOf(setting, exterior::Widened(prior, setting.surface.MeanHeight()), kWideSigmas));
    }
  return setting.regions->ContentWithin(areas);
}

double EarthK1OfRun(const ExteriorRunOptions& options) {
  CameraFile camera = CameraOfRun(options);
  OrientationTable table = TableOfRun(options);
  const Crs crs = BlockCrs(options, table);
  return SettingOf(options, std::move(camera), std::move(table), crs).earth_k1;
}

std::optional<std::string> ExteriorRunOptions::Check() const {
  if (photos.empty()) return "no photo given";
  if (position_sigma_m && !(*position_sigma_m > 0 && *position_sigma_m <= kLargestSigma_m))
    return "position-sigma-m must be positive and at most 1000000";
  if (attitude_sigma_rad && !(*attitude_sigma_rad > 0 && *attitude_sigma_rad < 3.2))
    return "attitude-sigma-deg must lie between 0 and 180";
  if (kappa_sigma_rad && !(*kappa_sigma_rad > 0 && *kappa_sigma_rad < 3.2))
    return "kappa-sigma-deg must lie between 0 and 180";
  if (flying_height_m && !(*flying_height_m > 0 && *flying_height_m <= kHighestFlight_m))
    return "flying-height-m must be positive and at most 30000";
  if (target_m && !(*target_m > 0)) return "target-m must be positive";
  if (date && !DateProblem(*date).empty()) return DateProblem(*date);
  if (principal_distance_sigma_mm && !(*principal_distance_sigma_mm > 0))
    return "principal-distance-sigma-mm must be positive";
  if (jobs < 0) return "jobs must not be negative";
  return std::nullopt;
}

}  // namespace orient::block
