#include "block/stages/exterior_job.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <filesystem>

#include "block/inputs/approximations.h"
#include "block/inputs/block_files.h"
#include "block/inputs/height_check.h"
#include "block/inputs/measurement_inputs.h"
#include "block/inputs/scan_interior.h"
#include "block/pictures/patch_sheet.h"
#include "block/pictures/scan_overview.h"
#include "block/stages/point_start.h"
#include "core/base/environment_error.h"
#include "core/base/error.h"
#include "core/files/orientation_table.h"
#include "core/raster/raster.h"
#include "core/terrain/footprint.h"
#include "core/terrain/view_over_ground.h"
#include "exterior/judge.h"
#include "exterior/orient_photo.h"
#include "exterior/principal_distance.h"
#include "exterior/search/point_resection.h"
#include "exterior/search/search_prior.h"
#include "exterior/steps/resect.h"
#include "patchdb/regions/control_patches.h"

namespace orient::block {
namespace {
namespace fs = std::filesystem;

ExteriorResult Failed(const std::string& photo, const Finding& why) {
  ExteriorResult result;
  result.photo = photo;
  result.status = Status::kFailed;
  result.findings = {why};
  return result;
}

Finding Because(Reason reason, std::string where) {
  return {.reason = reason, .at_best = Status::kFailed, .where = std::move(where)};
}

Matrix6d PriorCovariance(const OrientationRow& row, const ExteriorRunOptions& options) {
  constexpr double kExact = 1e-9;  // metres, radians: nothing is known better
  return SigmaOfApproximation(row, options.position_sigma_m, options.attitude_sigma_rad,
                              options.kappa_sigma_rad)
      .cwiseMax(kExact)
      .cwiseAbs2()
      .asDiagonal();
}

// Empty if the DEM has heights in the photo, otherwise the reason. Patches have heights of their
// own: a DEM with holes, even under the photo's centre, will do.
std::optional<Finding> WithoutHeights(const ExteriorSetting& setting, const Pose& pose) {
  const Eigen::Vector3d& at = pose.position_m;
  if (setting.surface.Intersect({at, -Eigen::Vector3d::UnitZ()})) return std::nullopt;
  if (!HeightsInFrame(setting.surface, setting.camera.camera, pose).empty()) return std::nullopt;
  const double ground =
      setting.surface.HeightAt(at.x(), at.y()).value_or(setting.surface.MinHeight());
  const std::string& table = setting.options.approximations;
  if (ground >= at.z())
    return Finding{Reason::kBelowGround, Status::kFailed, at.z(), ground,
                   table.empty() ? "" : " in " + table};
  return Because(Reason::kOutsideDem,
                 fmt::format("{} does not cover the photo: it has no height anywhere in the frame, "
                             "around x {:.9g}, y {:.9g}",
                             setting.options.dem, std::round(at.x()), std::round(at.y())));
}

fs::path PicturesOf(const ExteriorSetting& setting) {
  return setting.options.pictures.value_or(setting.options.out);
}

std::string SheetPath(const ExteriorSetting& setting, const std::string& photo) {
  return (PicturesOf(setting) / (photo + ".patches.png")).string();
}

std::string OverviewPath(const ExteriorSetting& setting, const std::string& photo) {
  return (PicturesOf(setting) / (photo + kPatchesOverview)).string();
}

// A picture that cannot be written must not cost the result.
template <typename Draw>
void DrawOrSayWhyNot(const Draw& draw, ExteriorResult* result) {
  try {
    draw();
  } catch (const InputError& error) {
    result->findings.push_back({.reason = Reason::kPictureNotWritten, .where = error.what()});
  }
}

// Draws why a photo is not ok by itself, as far as its scan shows it.
void DrawWhyNot(const ExteriorSetting& setting, const Raster& raster, const PointStart& start,
                ExteriorResult* result) {
  if (result->status == Status::kOk) return;
  std::vector<OverviewItem> items = OverviewOf(*result);
  for (OverviewItem& point : ClickedPoints(start)) items.push_back(std::move(point));
  DrawOrSayWhyNot([&] { WriteScanOverview(OverviewPath(setting, result->photo), raster, items); },
                  result);
}

// Adds to a result what maps, reports and people need beyond the orientation. If the photo failed,
// the patches are drawn as its approximation projects them.
void Illustrate(const ExteriorSetting& setting, const ScanInterior& interior,
                const exterior::PhotoImage& image, const std::vector<patchdb::Patch>& patches,
                const Pose& approximation, ExteriorResult* result) {
  result->width = image.Width();
  result->height = image.Height();
  const exterior::FilmPosition& position = PositionAs(interior.positions, result->orientation);
  PhotoView view{setting.camera.camera, position.photo_from_pixel,
                 result->pose.value_or(approximation), position.film_correction};
  if (const auto& estimated = result->principal_distance)
    view.camera.principal_distance_mm = estimated->value_mm;
  if (result->pose) result->footprint_m = Footprint(view, setting.surface);
  DrawOrSayWhyNot(
      [&] { WritePatchSheet(SheetPath(setting, result->photo), view, image, patches, *result); },
      result);
}

std::vector<patchdb::Patch> PatchesUnder(const ExteriorSetting& setting,
                                         const exterior::PhotoToOrient& photo,
                                         const PosePrior& prior, double sigmas) {
  const Bounds footprint = AreaOf(setting, prior, sigmas);
  const patchdb::ControlPatches database =
      setting.regions ? setting.regions->Another()
                      : patchdb::ControlPatches::Open(setting.options.patchdb);
  std::vector<patchdb::Patch> patches = database.FindPatchesIn(footprint);
  if (setting.options.further_patches) {
    const std::vector<patchdb::Patch> further =
        setting.options.further_patches(photo.name, footprint);
    patches.insert(patches.end(), further.begin(), further.end());
  }
  return patches;
}

ExteriorResult WithoutPatches(const ExteriorSetting& setting,
                              const exterior::PhotoToOrient& photo) {
  return Failed(photo.name, exterior::NoPatches(setting.options.patchdb));
}

bool AccuracyIsStated(const ExteriorSetting& setting, const OrientationRow& row) {
  const ExteriorRunOptions& options = setting.options;
  // For a photo that a person placed roughly, the accuracy is not a statement that a pose could
  // contradict.
  return !options.measurements.PositionOf(row.photo) && options.accuracy_is_stated &&
         (row.sigma || options.position_sigma_m || options.attitude_sigma_rad);
}

exterior::OrientPhotoOptions OptionsOf(const ExteriorSetting& setting) {
  exterior::OrientPhotoOptions options;
  options.target_m = setting.options.target_m;
  return options;
}

bool IsVague(const ExteriorSetting& setting, const PosePrior& prior) {
  return exterior::IsVague(setting.camera.camera, prior, setting.surface.MeanHeight());
}

ExteriorResult OrientAsStated(const ExteriorSetting& setting, const exterior::PhotoToOrient& photo,
                              const exterior::PhotoImage& image,
                              std::vector<patchdb::Patch>* patches) {
  *patches = PatchesUnder(setting, photo, photo.prior, kStatedSigmas);
  if (patches->empty()) return WithoutPatches(setting, photo);
  return exterior::OrientPhoto(photo, image, *patches, OptionsOf(setting));
}

// For a photo not oriented within its approximation's accuracy, or without one: searches all of it
// at every kappa, with the patches of a wider region. `before`: the result without this search.
ExteriorResult OrientWidely(const ExteriorSetting& setting, const exterior::PhotoToOrient& photo,
                            const exterior::PhotoImage& image, const ExteriorResult& before,
                            bool vague, std::vector<patchdb::Patch>* patches) {
  *patches = PatchesUnder(
      setting, photo, exterior::Widened(photo.prior, setting.surface.MeanHeight()), kWideSigmas);
  if (patches->empty()) return vague ? WithoutPatches(setting, photo) : before;
  exterior::OrientPhotoOptions options = OptionsOf(setting);
  options.wide = true;
  options.prior_failed = !vague;
  ExteriorResult result = exterior::OrientPhoto(photo, image, *patches, options);
  if (vague || result.pose) return result;
  // Reports the failed attempts in their order.
  Finding why = result.findings.front();
  if (why.reason == Reason::kNothingAlike)
    why = Because(Reason::kNothingAlikeAfterPrior, why.where);
  const bool twice = why.reason == before.findings.front().reason;
  result = before;
  if (!twice) result.findings.insert(result.findings.begin() + 1, why);  // the advice stays last
  return result;
}

// Searches within the prior's accuracy, unless that is vague; if nothing is found there, widely.
ExteriorResult OrientFromPrior(const ExteriorSetting& setting, const exterior::PhotoToOrient& photo,
                               const exterior::PhotoImage& image,
                               std::vector<patchdb::Patch>* patches, bool* widely) {
  const bool vague = IsVague(setting, photo.prior);
  ExteriorResult result;
  result.photo = photo.name;
  if (!vague) result = OrientAsStated(setting, photo, image, patches);
  *widely = !result.pose;
  return *widely ? OrientWidely(setting, photo, image, result, vague, patches) : result;
}

// Errors of the DEM's heights below this many pixels on the ground are not reported.
constexpr double kHeightTolerancePx = 4;

Finding WithoutApproximation(const ExteriorRunOptions& options, const std::string& name) {
  return Because(Reason::kNoApproximation,
                 options.approximations.empty()
                     ? "neither a table of approximations nor a strip of a block file lists it, "
                       "and no position was read from its file (EXIF; digital images only); give "
                       "one of these"
                     : fmt::format("{} has no row '{}'; add one or leave the photo out",
                                   options.approximations, name));
}

// If no patches are found from the points' pose, but from the approximation: these two agree, and
// the points have another datum. If only a search of the whole photo finds them, the points must
// agree. True if `photo` and `start` now begin with the approximation.
bool IsFoundWithoutPoints(const ExteriorSetting& setting, const exterior::PhotoImage& image,
                          exterior::PhotoToOrient* photo, PointStart* start, ExteriorResult* result,
                          std::vector<patchdb::Patch>* patches, bool* widely) {
  if (!start->approximation) return false;
  exterior::PhotoToOrient without = *photo;
  without.prior = *start->approximation;
  without.accuracy_is_stated = start->approximation_is_stated;
  without.positions = start->positions;
  std::vector<patchdb::Patch> around;
  ExteriorResult found = OrientFromPrior(setting, without, image, &around, widely);
  if (!found.pose) return false;
  if (PointsContradict(setting, without, *start, found)) {
    if (*widely) return false;
    start->by_points.reset();
  }
  start->by_points_began = false;
  *photo = std::move(without);
  *result = std::move(found);
  *patches = std::move(around);
  return true;
}

// Orients by patches, within the prior's accuracy or beyond. Drops the points' pose if patches and
// approximation together contradict it.
ExteriorResult OrientByPatches(const ExteriorSetting& setting, const exterior::PhotoImage& image,
                               exterior::PhotoToOrient* photo, PointStart* start,
                               std::vector<patchdb::Patch>* patches) {
  ExteriorResult result;
  result.photo = photo->name;
  exterior::OrientPhotoOptions as_oriented = OptionsOf(setting);
  if (!start->by_points) {
    result = OrientFromPrior(setting, *photo, image, patches, &as_oriented.wide);
  } else {
    if (!IsVague(setting, photo->prior)) result = OrientAsStated(setting, *photo, image, patches);
    if (!result.pose &&
        !IsFoundWithoutPoints(setting, image, photo, start, &result, patches, &as_oriented.wide))
      OrientByPoints(setting, *photo, *start, &result);
  }
  as_oriented.prior_failed = as_oriented.wide && !IsVague(setting, photo->prior);
  if (setting.options.principal_distance_sigma_mm && !Has(result.findings, Reason::kByPointsAlone))
    result = exterior::OrientWithPrincipalDistance(*photo, image, *patches, as_oriented, result,
                                                   *setting.options.principal_distance_sigma_mm);
  else
    exterior::JudgePrincipalDistance(*photo, *patches, &result);
  return result;
}

StartingPose StartingPoseOf(const PosePrior& prior) {
  return {prior.pose, prior.covariance.diagonal().cwiseSqrt()};
}

ExteriorResult FailedAtStart(const ExteriorSetting& setting, const Raster& raster,
                             const PointStart& start, const std::string& name, const Finding& why) {
  ExteriorResult failed = Failed(name, why);
  if (start.prior) failed.approximation = StartingPoseOf(*start.prior);
  DrawWhyNot(setting, raster, start, &failed);
  return failed;
}

ExteriorResult OrientOne(const ExteriorSetting& setting, const std::string& path) {
  const std::string name = PhotoName(path);
  const OrientationRow* row = setting.approximations.Find(name);
  if (row == nullptr && setting.options.measurements.ImagePointsOf(name).empty())
    return Failed(name, WithoutApproximation(setting.options, name));
  const Raster raster = Raster::OpenScan(path);
  const bool digital = setting.camera.camera.kind == CameraKind::kDigital;
  ScanInterior interior = digital
                              ? DigitalGeometry(setting.camera.camera, raster)
                              : FilmGeometry(setting.camera, setting.marks, raster,
                                             InteriorResultPath(*setting.options.interior, name));
  if (StatusOf(interior.findings) == Status::kFailed)
    return Failed(name, interior.findings.front());
  std::optional<PosePrior> approximation;
  if (row != nullptr) approximation = PosePrior{row->pose, PriorCovariance(*row, setting.options)};
  PointStart start = StartOf(setting, name, approximation,
                             row != nullptr && AccuracyIsStated(setting, *row), &interior);
  if (!start.prior)
    return FailedAtStart(setting, raster, start, name,
                         start.findings.empty() ? WithoutApproximation(setting.options, name)
                                                : start.findings.front());
  auto without_heights = WithoutHeights(setting, start.prior->pose);
  if (without_heights && start.by_points && start.approximation &&
      !WithoutHeights(setting, start.approximation->pose)) {
    DropPoints(&start, &interior);
    without_heights.reset();
  }
  const PosePrior prior = *start.prior;
  if (!IsVague(setting, prior) && without_heights)
    return FailedAtStart(setting, raster, start, name, *without_heights);

  const exterior::PhotoImage image(raster, interior.negative);
  exterior::PhotoToOrient photo{name,
                                setting.camera.camera,
                                interior.positions,
                                prior,
                                start.stated,
                                CoveredAreas(setting.camera, setting.marks),
                                &setting.surface};
  std::vector<patchdb::Patch> patches;
  ExteriorResult result = OrientByPatches(setting, image, &photo, &start, &patches);
  result.approximation = StartingPoseOf(photo.prior);
  CompareWithPoints(setting, photo, start, &result);
  const PhotoView view{photo.camera, photo.positions.front().photo_from_pixel,
                       result.pose.value_or(photo.prior.pose)};
  CheckHeights(setting.surface, patches,
               kHeightTolerancePx * view.GroundPixel(setting.surface.MeanHeight()), &result);
  for (const Finding& finding : interior.findings) exterior::Add(finding, &result);
  ApplyVerdict(setting.options.measurements, &result);
  interior.positions = photo.positions;
  Illustrate(setting, interior, image, patches, photo.prior.pose, &result);
  DrawWhyNot(setting, raster, start, &result);
  return result;
}

}  // namespace

ExteriorResult OrientFromFiles(const ExteriorSetting& setting, const std::string& path) {
  std::error_code ignored;  // an earlier run's pictures
  fs::remove(OverviewPath(setting, PhotoName(path)), ignored);
  fs::remove(SheetPath(setting, PhotoName(path)), ignored);
  try {
    return OrientOne(setting, path);
  } catch (const InputError& error) {
    return Failed(PhotoName(path), Because(Reason::kPhotoUnusable, error.what()));
  } catch (const std::exception& error) {
    RethrowIfMachineFault();
    return Failed(PhotoName(path),
                  Because(Reason::kPhotoUnusable,
                          std::string("internal error, please report it: ") + error.what()));
  }
}

}  // namespace orient::block
