#include "tools/exterior_run.h"

#include <tbb/parallel_for_each.h>
#include <tbb/task_arena.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <mutex>
#include <numeric>

#include "core/error.h"
#include "core/files/adjustment_result.h"
#include "core/files/atomic_write.h"
#include "core/files/camera_file.h"
#include "core/files/orientation_table.h"
#include "core/format_text.h"
#include "core/geometry/ground_surface.h"
#include "core/imaging/raster.h"
#include "core/median.h"
#include "exterior/orient_freed.h"
#include "exterior/orient_photo.h"
#include "exterior/predict.h"
#include "patchdb/patch_database.h"
#include "tools/approximations.h"
#include "tools/block_camera.h"
#include "tools/block_files.h"
#include "tools/exterior_inputs.h"
#include "tools/exterior_learning.h"
#include "tools/film_pixel.h"
#include "tools/footprint.h"
#include "tools/height_check.h"
#include "tools/interior_run.h"
#include "tools/made_from.h"
#include "tools/patch_sheet.h"
#include "tools/scan_interior.h"
#include "tools/shared_options.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

// What all photos of a run share; read before the first photo starts.
struct Setting {
  const ExteriorRunOptions& options;
  CameraFile camera;    // with curvature and refraction in its lens
  double earth_k1 = 0;  // of it, what this run added to the camera file's lens
  MarkShapes marks;     // a film camera's; empty for a digital one
  OrientationTable approximations;
  Crs crs;
  GroundSurface surface;
};

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
  if (region.Empty() && options.approximations.empty())
    throw InputError(
        "nothing says where any of the photos was taken from: their files have no position (EXIF); "
        "give a table of approximations");
  if (region.Empty())
    throw InputError(options.approximations +
                     ": none of the given photos is in this table; its "
                     "'filename' column holds file names without folder and extension");
  return region;
}

Crs StoredCrs(const ExteriorRunOptions& options) {
  return PatchDatabase::Open(options.patchdb, PatchDatabase::Mode::kRead).GroundCrs();
}

Crs BlockCrs(const ExteriorRunOptions& options, const OrientationTable& table) {
  const Crs stored = StoredCrs(options);
  const Crs crs = options.crs.value_or(table.crs.value_or(stored));
  if (!crs.SameAs(stored))
    throw InputError(options.patchdb + ": its CRS is " + stored.Name() + ", the block's is " +
                     crs.Name() + "; use a patch database in the block's CRS");
  if (table.crs && !table.crs->SameAs(crs))
    throw InputError(options.approximations + ": its .prj says " + table.crs->Name() +
                     ", the block's CRS is " + crs.Name() + "; convert the table to the block's");
  return crs;
}

// No photo is taken from higher above the ground.
constexpr double kHighestFlight_m = 30e3;

// The middle one of the run's photos. Heights that cannot be true have no say: what is done about
// the earth is the same for all photos.
double FlyingHeight(const OrientationTable& table, const ExteriorRunOptions& options,
                    double ground_m) {
  std::vector<double> heights;
  for (const std::string& path : options.photos)
    if (const OrientationRow* row = table.Find(PhotoName(path))) {
      const double above_m = row->pose.position_m.z() - ground_m;
      if (above_m > 0 && above_m < kHighestFlight_m) heights.push_back(row->pose.position_m.z());
    }
  return heights.empty() ? ground_m : UpperMedian(std::move(heights));
}

Setting Prepare(const ExteriorRunOptions& options) {
  if (!options.earth_k1) RefuseBlockCamera(options.camera, options.earth);
  CameraFile camera = ReadCameraFile(options.camera);
  if (camera.camera.kind == CameraKind::kFilm && !options.interior)
    throw UsageError(options.camera +
                     " is a film camera: name the folder with the results of 'orient interior' "
                     "with --interior");
  OrientationTable table =
      options.table ? *options.table
                    : ReadApproximations(options.approximations,
                                         options.crs ? *options.crs : StoredCrs(options));
  const Crs crs = BlockCrs(options, table);
  GroundSurface surface =
      GroundSurface::FromFile(options.dem, crs, Region(table, camera.camera, options));
  MarkShapes marks;
  if (camera.camera.kind == CameraKind::kFilm) marks = LoadMarkShapes(camera);
  const double ground_m = surface.MeanHeight();
  const double own_k1 = camera.camera.earth_k1;
  camera.camera =
      options.earth_k1
          ? WithEarth(camera.camera, *options.earth_k1)
          : OverEarth(camera.camera, options.earth, FlyingHeight(table, options, ground_m),
                      ground_m,
                      FilmPixel_mm(camera.camera, options.photos).value_or(kFilmPixel_mm));
  const double added_k1 = options.earth_k1.value_or(camera.camera.earth_k1 - own_k1);
  return {options, std::move(camera), added_k1, std::move(marks), std::move(table),
          crs,     std::move(surface)};
}

ExteriorResult Failed(const std::string& photo, const std::string& why) {
  ExteriorResult result;
  result.photo = photo;
  result.status = Status::kFailed;
  result.messages.push_back(why);
  return result;
}

Matrix6d PriorCovariance(const OrientationRow& row, const ExteriorRunOptions& options) {
  return SigmaOfApproximation(row, options.position_sigma_m, options.attitude_sigma_rad,
                              options.kappa_sigma_rad)
      .cwiseAbs2()
      .asDiagonal();
}

std::string Metres(double value) {
  char text[64];
  std::snprintf(text, sizeof text, "%.9g", std::round(value));
  return text;
}

// Empty where the photo's ground has heights, otherwise the reason why not.
std::string WithoutHeights(const Setting& setting, const Pose& pose) {
  const Ray nadir{pose.position_m, -Eigen::Vector3d::UnitZ()};
  const auto axis =
      GroundRayFromPhoto(setting.camera.camera, pose, setting.camera.camera.principal_point_mm);
  if (axis && setting.surface.Intersect(*axis)) return "";
  if (setting.surface.Intersect(nadir)) return "";
  const auto ground = setting.surface.HeightAt(pose.position_m.x(), pose.position_m.y());
  if (ground && *ground >= pose.position_m.z())
    return "its approximate position lies below the ground: z " + Metres(pose.position_m.z()) +
           ", the ground there " + Metres(*ground) + "; correct it" +
           (setting.options.approximations.empty() ? "" : " in " + setting.options.approximations);
  return "the DEM " + setting.options.dem +
         " does not cover the photo: it has no height at its "
         "centre, x " +
         Metres(pose.position_m.x()) + ", y " + Metres(pose.position_m.y()) +
         "; give a DEM that reaches there, or correct the approximation";
}

// What is told about a photo beyond its orientation: for maps, reports and people.
void Illustrate(const Setting& setting, const ScanInterior& interior, const PhotoImage& image,
                const std::vector<Patch>& patches, ExteriorResult* result) {
  result->width = image.Width();
  result->height = image.Height();
  if (!result->pose) return;
  const auto position =
      std::find_if(interior.positions.begin(), interior.positions.end(),
                   [&](const FilmPosition& p) { return p.orientation == result->orientation; });
  PhotoView view{setting.camera.camera, position->photo_from_pixel, *result->pose,
                 position->film_correction};
  if (const auto& freed = result->principal_distance)
    view.camera.principal_distance_mm = freed->value_mm;
  result->footprint_m = Footprint(view, setting.surface);
  const fs::path pictures = setting.options.pictures.value_or(setting.options.out);
  WritePatchSheet((pictures / (result->photo + ".patches.png")).string(), view, image, patches,
                  *result);
}

std::vector<Patch> PatchesUnder(const Setting& setting, const PhotoToOrient& photo,
                                const PosePrior& prior, double sigmas) {
  const Bounds footprint =
      UncertainFootprint(setting.camera.camera, prior, setting.surface.MinHeight(),
                         setting.surface.MaxHeight(), sigmas);
  std::vector<Patch> patches =
      PatchDatabase::Open(setting.options.patchdb, PatchDatabase::Mode::kRead)
          .FindPatchesIn(footprint);
  if (setting.options.further_patches) {
    const std::vector<Patch> further = setting.options.further_patches(photo.name, footprint);
    patches.insert(patches.end(), further.begin(), further.end());
  }
  return patches;
}

ExteriorResult WithoutPatches(const Setting& setting, const PhotoToOrient& photo) {
  return Failed(photo.name, setting.options.patchdb +
                                " has no control patch under the photo's footprint; harvest "
                                "patches there, or correct the approximation");
}

bool AccuracyIsStated(const Setting& setting, const OrientationRow& row) {
  const ExteriorRunOptions& options = setting.options;
  return options.accuracy_is_stated &&
         (row.sigma || options.position_sigma_m || options.attitude_sigma_rad);
}

ExteriorResult OrientAsStated(const Setting& setting, const PhotoToOrient& photo,
                              const PhotoImage& image, std::vector<Patch>* patches) {
  *patches = PatchesUnder(setting, photo, photo.prior, 3);
  if (patches->empty()) return WithoutPatches(setting, photo);
  return OrientPhoto(photo, image, *patches);
}

// What could not be oriented within the approximation's accuracy, or has none: the whole photo at
// every kappa, with the patches of a wider region. `before`: what was found without.
ExteriorResult OrientWidely(const Setting& setting, const PhotoToOrient& photo,
                            const PhotoImage& image, const ExteriorResult& before, bool vague,
                            std::vector<Patch>* patches) {
  constexpr double kSigmas = 2;
  *patches =
      PatchesUnder(setting, photo, Widened(photo.prior, setting.surface.MeanHeight()), kSigmas);
  if (patches->empty()) return vague ? WithoutPatches(setting, photo) : before;
  OrientPhotoOptions options;
  options.wide = true;
  ExteriorResult result = OrientPhoto(photo, image, *patches, options);
  if (vague || result.pose) return result;
  // One sentence: what was tried in vain after what.
  result = before;
  result.messages.back() += "; nor is the photo, searched as a whole, like them at any kappa";
  return result;
}

// A DEM's heights that are wrong by less than this many pixels on the ground are not worth a word.
constexpr double kHeightTolerancePx = 4;

double GroundPixel(const Setting& setting, const PhotoView& view) {
  return view.PixelSize() / view.camera.principal_distance_mm *
         std::abs(view.pose.position_m.z() - setting.surface.MeanHeight());
}

ExteriorResult WithoutApproximation(const ExteriorRunOptions& options, const std::string& name) {
  if (options.approximations.empty())
    return Failed(name,
                  "no approximation: its file says no position (EXIF), and no strip of the block "
                  "file has it; give a table of approximations, or name it in its strip");
  return Failed(name, "no approximation: " + options.approximations + " has no row '" + name +
                          "'; add one or leave the photo out");
}

ExteriorResult OrientOne(const Setting& setting, const std::string& path) {
  const std::string name = PhotoName(path);
  const OrientationRow* row = setting.approximations.Find(name);
  if (row == nullptr) return WithoutApproximation(setting.options, name);
  const Raster raster = Raster::Open(path);
  const bool digital = setting.camera.camera.kind == CameraKind::kDigital;
  const ScanInterior interior =
      digital ? DigitalGeometry(setting.camera.camera, raster)
              : FilmGeometry(setting.camera, setting.marks, raster,
                             InteriorResultPath(*setting.options.interior, name));
  if (!interior.failure.empty()) return Failed(name, interior.failure);
  const PosePrior prior{row->pose, PriorCovariance(*row, setting.options)};
  const bool vague = IsVague(setting.camera.camera, prior, setting.surface.MeanHeight());
  const std::string without_heights = WithoutHeights(setting, row->pose);
  if (!vague && !without_heights.empty()) return Failed(name, without_heights);

  const PhotoImage image(raster, interior.negative);
  const PhotoToOrient photo{name,
                            setting.camera.camera,
                            interior.positions,
                            prior,
                            AccuracyIsStated(setting, *row),
                            CoveredAreas(setting.camera, setting.marks),
                            &setting.surface};
  std::vector<Patch> patches;
  ExteriorResult result =
      vague ? Failed(name, "") : OrientAsStated(setting, photo, image, &patches);
  OrientPhotoOptions as_oriented;
  as_oriented.wide = !result.pose;
  if (!result.pose) result = OrientWidely(setting, photo, image, result, vague, &patches);
  if (setting.options.principal_distance_sigma_mm)
    result = OrientFreed(photo, image, patches, as_oriented, result,
                         *setting.options.principal_distance_sigma_mm);
  CheckHeights(setting.surface, patches,
               kHeightTolerancePx *
                   GroundPixel(setting, {photo.camera, photo.positions.front().photo_from_pixel,
                                         prior.pose}),
               &result);
  if (interior.weak && result.status == Status::kOk) result.status = Status::kWeak;
  result.messages.insert(result.messages.end(), interior.messages.begin(), interior.messages.end());
  Illustrate(setting, interior, image, patches, &result);
  return result;
}

OrientationTable TableOf(const std::vector<ExteriorResult>& results, const Crs& crs) {
  OrientationTable table;
  table.crs = crs;
  for (const ExteriorResult& result : results)
    if (result.pose)
      table.rows.push_back(
          {result.photo, *result.pose, Vector6d(result.covariance->diagonal().cwiseSqrt())});
  return table;
}

ExteriorResult OrientOrFail(const Setting& setting, const std::string& path) {
  try {
    return OrientOne(setting, path);
  } catch (const InputError& error) {
    return Failed(PhotoName(path), error.what());
  } catch (const std::bad_alloc&) {
    return Failed(PhotoName(path), "out of memory; use fewer --jobs");
  } catch (const std::exception& error) {
    return Failed(PhotoName(path),
                  std::string("internal error, please report it: ") + error.what());
  }
}

// No approximation is known worse than this, in metres.
constexpr double kLargestSigma_m = 1e6;

}  // namespace

std::optional<std::string> ExteriorRunOptions::Check() const {
  if (photos.empty()) return "no photo given";
  if (position_sigma_m && !(*position_sigma_m > 0 && *position_sigma_m <= kLargestSigma_m))
    return "position-sigma-m must be positive and at most 1000000";
  if (attitude_sigma_rad && !(*attitude_sigma_rad > 0 && *attitude_sigma_rad < 3.2))
    return "attitude-sigma-deg must lie between 0 and 180";
  if (kappa_sigma_rad && !(*kappa_sigma_rad > 0 && *kappa_sigma_rad < 3.2))
    return "kappa-sigma-deg must lie between 0 and 180";
  if (principal_distance_sigma_mm && !(*principal_distance_sigma_mm > 0))
    return "principal-distance-sigma-mm must be positive";
  if (jobs < 0) return "jobs must not be negative";
  return std::nullopt;
}

namespace {

ExteriorInputs InputsOf(const ExteriorRunOptions& options) {
  const auto number = [](const std::optional<double>& value) {
    return value ? FormatText("%.9g", *value) : std::string("-");
  };
  return {DigestOfCamera(ReadCameraFile(options.camera)), DigestOfRaster(options.dem),
          "earth " + Name(options.earth) + ", principal distance sigma " +
              number(options.principal_distance_sigma_mm) + " mm",
          0};
}

// A block keeps its stages' results true by itself.
bool IsOfABlock(const ExteriorRunOptions& options) {
  return options.next_photos || options.table || options.earth_k1;
}

// A run that goes on is as that whose results it keeps.
Setting PrepareAlone(ExteriorRunOptions* options) {
  ExteriorInputs inputs = InputsOf(*options);
  if (const auto then = options->resume ? ReadExteriorInputs(options->out) : std::nullopt) {
    RequireSameInputs(options->out, *then, inputs);
    options->earth_k1 = then->added_earth_k1;
  }
  Setting setting = Prepare(*options);
  MakeOutputDirectory(options->out);
  inputs.added_earth_k1 = setting.earth_k1;
  WriteExteriorInputs(options->out, inputs);
  return setting;
}

// What a photo's result depends on beside what all of the run share.
std::string DigestOfPhoto(const Setting& setting, const std::string& path) {
  const ExteriorRunOptions& options = setting.options;
  const std::string name = PhotoName(path);
  std::string text = DigestOfFile(path) + TextOf(setting.approximations.Find(name));
  for (const auto& sigma : {options.position_sigma_m, options.attitude_sigma_rad})
    text += sigma ? FormatText(" %.9g", *sigma) : " -";
  if (options.kappa_sigma_rad) text += FormatText(" kappa %.9g", *options.kappa_sigma_rad);
  if (options.interior) text += DigestOfFile(InteriorResultPath(*options.interior, name));
  return Digest(text);
}

// A result that is there to be kept. Empty where there is none or it was made from something else:
// the photo is done again.
std::optional<ExteriorResult> KeptResult(const ExteriorRunOptions& options, const std::string& path,
                                         const std::string& made_from) {
  const std::string known = ExteriorResultPath(options.out, PhotoName(path));
  if (!options.resume || !fs::exists(known)) return std::nullopt;
  ExteriorResult result = ReadExteriorResult(known);
  const bool nobody_says = result.made_from.empty() || made_from.empty();
  if (!nobody_says && result.made_from != made_from) return std::nullopt;
  return result;
}

}  // namespace

double EarthK1OfRun(const ExteriorRunOptions& options) { return Prepare(options).earth_k1; }

std::vector<ExteriorResult> RunExterior(const ExteriorRunOptions& given,
                                        const std::function<void(const ExteriorResult&)>& done) {
  if (const auto wrong = given.Check()) throw UsageError(*wrong);
  ExteriorRunOptions options = given;
  Setting setting = IsOfABlock(given) ? Prepare(options) : PrepareAlone(&options);
  MakeOutputDirectory(options.out);
  // What a block's run left here is true of other poses.
  fs::remove(AdjustmentResultPath(options.out));
  for (const char* file : {kQuicklookFile, kSeamsFile, kCalibratedCameraFile, kPoseCovarianceFile})
    fs::remove(fs::path(options.out) / file);
  // What a run that ends early leaves must not lie beside an earlier one's poses.
  const fs::path table = fs::path(options.out) / "orientation.csv";
  std::error_code ignored;
  if (!fs::equivalent(table, options.approximations, ignored)) fs::remove(table);
  fs::remove(BlockCameraPath(options.out));
  Learning learning(options);
  std::vector<ExteriorResult> results(options.photos.size());
  std::vector<char> fresh(options.photos.size(), 0);  // not bool: written from several threads
  std::mutex mutex;
  const auto orient_one = [&](std::size_t i) {
    // A block keeps account of its photos itself.
    const std::string made_from =
        IsOfABlock(given) ? "" : DigestOfPhoto(setting, options.photos[i]);
    const auto kept = KeptResult(options, options.photos[i], made_from);
    results[i] = kept ? *kept : OrientOrFail(setting, options.photos[i]);
    if (!kept) results[i].made_from = made_from;
    const std::lock_guard<std::mutex> lock(mutex);
    fresh[i] = kept ? 0 : 1;
    if (!kept) WriteExteriorResult(options.out, results[i]);
    if (done) done(results[i]);
  };
  tbb::task_arena arena(options.jobs > 0 ? options.jobs : tbb::task_arena::automatic);
  auto next = [&, begun = false]() mutable {
    if (options.next_photos) return options.next_photos(results, &setting.approximations);
    std::vector<std::size_t> all(begun ? 0 : options.photos.size());
    std::iota(all.begin(), all.end(), std::size_t{0});
    begun = true;
    return all;
  };
  for (std::vector<std::size_t> wave = next(); !wave.empty(); wave = next())
    arena.execute([&] { tbb::parallel_for_each(wave, orient_one); });
  learning.Tell(fresh, setting.camera.camera.kind, &results);
  WriteOrientationTable(table.string(), TableOf(results, setting.crs));
  // Photos with a principal distance of their own have no camera in common.
  if (!options.principal_distance_sigma_mm) WriteBlockCamera(options.out, setting.camera);
  return results;
}

}  // namespace orient
