#include "tools/convert/convert_source.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <set>
#include <utility>

#include "block/inputs/block_camera.h"
#include "block/inputs/block_photos.h"
#include "core/base/column_names.h"
#include "core/base/error.h"
#include "core/files/adjustment_result.h"
#include "core/files/camera_file.h"
#include "core/files/orientation_table.h"
#include "core/files/results.h"
#include "core/terrain/earth_effects.h"
#include "tools/convert/camera_given.h"
#include "tools/convert/export_points.h"
#include "tools/convert/export_record.h"
#include "tools/convert/foreign_block.h"
#include "tools/convert/ground_frame.h"
#include "tools/convert/placed_poses.h"
#include "tools/convert/program_names.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

constexpr std::array<std::pair<ExchangeFormat, const char*>, 9> kNames = {
    {{ExchangeFormat::kOpk, "opk"},
     {ExchangeFormat::kOri, "ori"},
     {ExchangeFormat::kPatb, "patb"},
     {ExchangeFormat::kBingo, "bingo"},
     {ExchangeFormat::kMicmac, "micmac"},
     {ExchangeFormat::kMetashape, "metashape"},
     {ExchangeFormat::kColmap, "colmap"},
     {ExchangeFormat::kOpensfm, "opensfm"},
     {ExchangeFormat::kAsp, "asp"}}};

// The folder's table, or the table itself.
std::string TablePath(const std::string& input) {
  return fs::is_directory(input) ? (fs::path(input) / "orientation.csv").string() : input;
}

double PixelSizeOfImages(const ConvertSourceOptions& options, const std::string& interior) {
  if (options.pixel_size_um) return 1e-3 * *options.pixel_size_um;
  if (const auto mean = MeanPixelSize(interior)) return *mean;
  throw InputError(
      fmt::format("the pixel size of the resampled images is not known: {} holds no interior "
                  "orientation; name the folder that does with --interior, or give --pixel-size-um",
                  interior));
}

std::optional<double> MeanGround(const std::optional<ExteriorResult>& exterior) {
  if (!exterior) return std::nullopt;
  double sum = 0;
  int count = 0;
  for (const PatchResult& patch : exterior->patches)
    if (patch.ground_m && patch.state == PatchState::kMatched) sum += patch.ground_m->z(), ++count;
  if (count == 0)
    for (const Eigen::Vector3d& corner : exterior->footprint_m) sum += corner.z(), ++count;
  if (count == 0) return std::nullopt;
  return sum / count;
}

// `known`: what the input itself says.
std::optional<Crs> BlockCrs(const ConvertSourceOptions& options, const std::optional<Crs>& known) {
  if (options.crs.empty()) return known;
  const Crs given = Crs::Parse(options.crs, "--crs");
  if (known && !known->SameAs(given))
    throw InputError(options.input + " says that its CRS is " + known->Name() + ", --crs says " +
                     given.Name() + "; --crs names a CRS and transforms nothing: leave it out");
  return given;
}

Crs RequireCrs(const ConvertSourceOptions& options, const std::optional<Crs>& known,
               const std::string& why) {
  if (const auto crs = BlockCrs(options, known)) return *crs;
  throw InputError(options.input + why + "; name the block's projected CRS with --crs");
}

GroundFrame FrameOf(const ForeignBlock& foreign, const ConvertSourceOptions& given,
                    const ExportRecord& record) {
  const double geoid = given.geoid_m.value_or(record.geoid_m);
  if (foreign.geocentric)
    return GroundFrame::Geocentric(RequireCrs(given, record.crs, " holds geocentric coordinates"),
                                   geoid);
  if (const auto& lla = foreign.block.reference_lla)
    return GroundFrame::Topocentric(RequireCrs(given, record.crs, " holds topocentric coordinates"),
                                    geoid, {RadFromDeg(lla->x()), RadFromDeg(lla->y()), lla->z()});
  // What is added to the file's coordinates.
  return GroundFrame::Shifted(foreign.frame_origin);
}

// The camera for which the folder's poses hold, if it is there, else that of the options.
CameraFile CameraOfPoses(const ConvertSourceOptions& options, std::vector<std::string>* messages) {
  const std::string own = block::BlockCameraPath(FolderOf(options.input));
  if (!fs::exists(own)) {
    if (options.camera.empty()) throw UsageError("name the photos' camera file with --camera");
    return ReadCameraFile(options.camera);
  }
  if (!options.camera.empty() && block::OtherBlockCamera(FolderOf(options.input), options.camera))
    messages->push_back(
        fmt::format("the poses hold with {}, which is used instead of {}", own, options.camera));
  return ReadCameraFile(own);
}

// Poses of different cameras do not hold with one.
void RequireOneCamera(const OrientationTable& table, const std::string& path) {
  if (table.cameras.size() < 2) return;
  throw InputError(fmt::format(
      "{} names {} cameras in its column camera ({}), but its photos are converted with "
      "one; make a table of each camera's photos and convert them one by one",
      path, table.cameras.size(), fmt::join(table.cameras, ", ")));
}

// Throws InputError where the result, of the file `path`, does not belong to the table's row.
void RequireOfThisRun(const ExteriorResult& exterior, const OrientationRow& row,
                      const std::string& path, const std::string& table) {
  // A table of another name beside the results holds poses of a person's own.
  const bool same_run = fs::path(table).filename() == "orientation.csv";
  const std::string problem = same_run ? block::PoseContradiction(row, exterior) : "";
  if (!problem.empty()) throw InputError(fmt::format("{}: {}", table, problem));
  if (exterior.principal_distance)
    throw InputError(
        fmt::format("{}: the photo's principal distance was estimated with its pose ({:g} mm); "
                    "put the right value into the camera file and orient without "
                    "--principal-distance-sigma-mm before converting",
                    path, exterior.principal_distance->value_mm));
}

}  // namespace

std::string FolderOf(const std::string& input) {
  if (fs::is_directory(input)) return input;
  const fs::path parent = fs::path(input).parent_path();
  return parent.empty() ? "." : parent.string();
}

std::string Name(ExchangeFormat format) {
  return std::find_if(kNames.begin(), kNames.end(),
                      [&](const auto& name) { return name.first == format; })
      ->second;
}

std::optional<ExchangeFormat> ExchangeFormatFromName(const std::string& name) {
  for (const auto& [format, known] : kNames)
    if (known == name) return format;
  return std::nullopt;
}

Camera ImageCamera(const Camera& camera, double pixel_mm, bool remove_distortion) {
  if (camera.kind == CameraKind::kDigital) return camera;
  Camera image = camera;
  image.kind = CameraKind::kDigital;
  const auto pixels = [&](double length_mm) {
    return static_cast<int>(std::ceil(length_mm / pixel_mm - 1e-9));
  };
  image.image_px = Eigen::Vector2i(pixels(camera.frame_mm.x()), pixels(camera.frame_mm.y()));
  image.frame_mm = pixel_mm * image.image_px->cast<double>();
  image.frame_centre_mm.setZero();
  image.principal_point_mm = camera.principal_point_mm - camera.frame_centre_mm;
  if (remove_distortion) {
    image.lens = std::monostate();
    image.earth_k1 = 0;
  }
  return image;
}

std::optional<double> MeanPixelSize(const std::string& interior_directory) {
  double sum = 0;
  int count = 0;
  if (!fs::is_directory(interior_directory)) return std::nullopt;
  for (const std::string& path : InteriorResultPaths(interior_directory)) {
    const InteriorResult result = ReadInteriorResult(path);
    if (!result.photo_from_pixel) continue;
    sum += std::sqrt(std::abs(result.photo_from_pixel->A.determinant()));
    ++count;
  }
  if (count == 0) return std::nullopt;
  return sum / count;
}

ConvertSource ReadOrientResults(const ConvertSourceOptions& options) {
  const OrientationTable table = ReadOrientationTable(TablePath(options.input));
  if (table.rows.empty()) throw InputError(TablePath(options.input) + " holds no photo");
  RequireOneCamera(table, TablePath(options.input));
  ConvertSource source;
  const CameraFile file = CameraOfPoses(options, &source.messages);
  const bool film = file.camera.kind == CameraKind::kFilm;
  const std::string folder = FolderOf(options.input);
  const std::string interior = options.interior.value_or(folder);
  const Camera image = ImageCamera(file.camera, film ? PixelSizeOfImages(options, interior) : 0,
                                   options.remove_distortion);
  const FittedExchangeCamera fitted = ExchangeCameraOf(image);
  if (fitted.largest_difference_px > 0)
    source.messages.push_back(
        "the lens's radial table is written as k1 k2 k3: it differs by up to " +
        std::to_string(fitted.largest_difference_px) + " px; --remove-distortion avoids that");
  source.cameras.push_back(image);
  source.camera_of_poses = file;
  source.block.cameras.push_back(fitted.camera);
  source.crs = BlockCrs(options, table.crs);
  if (source.crs) {
    source.block.crs = source.crs->Wkt();
    RequireInArea(table, *source.crs, TablePath(options.input));
  }
  ExportPoints points;
  int without_interior = 0;
  for (const OrientationRow& row : table.rows) {
    ExchangePhoto photo;
    photo.image = row.photo + options.image_extension;
    SetPose(row.pose, &photo);
    const std::string path = ExteriorResultPath(folder, row.photo);
    std::optional<ExteriorResult> exterior;
    if (fs::exists(path)) exterior = ReadExteriorResult(path);
    if (exterior) RequireOfThisRun(*exterior, row, path, TablePath(options.input));
    auto height = MeanGround(exterior);
    if (!height) height = options.ground_height_m;
    const bool seen = !film || fs::exists(InteriorResultPath(interior, row.photo));
    without_interior += exterior && !seen ? 1 : 0;
    if (exterior && seen)
      points.AddPhoto(source.block.photos.size(), *exterior,
                      FilmImage(file, row.photo, interior, exterior->orientation, image,
                                options.remove_distortion));
    source.block.photos.push_back(photo);
    source.ground_height_m.push_back(height);
  }
  if (without_interior > 0)
    source.messages.push_back(
        fmt::format("control and tie points of {} of {} photos are left out: {} does not hold "
                    "their interior orientations; name the folder that does with --interior",
                    without_interior, table.rows.size(), interior));
  const std::string adjusted = AdjustmentResultPath(folder);
  if (fs::exists(adjusted))
    if (const AdjustmentResult block = ReadAdjustmentResult(adjusted); block.converged)
      points.AddTies(block);
  source.block.points = points.Take();
  return source;
}

namespace {

void RequireFinite(const ExchangePhoto& photo, const std::string& input) {
  if (!photo.centre.allFinite() || !photo.ground_from_photo.allFinite())
    throw InputError(
        fmt::format("{}: position and rotation of photo {} are not finite; the "
                    "file is damaged",
                    input, photo.image));
}

void RequirePossible(const Camera& camera, const std::string& input) {
  if (const auto problem = PrincipalDistanceProblem(camera); !problem.empty())
    throw InputError(
        fmt::format("{}: the principal distance {}; the file is damaged, or of another "
                    "camera than an aerial one",
                    input, problem));
}

void RequireDistinctPhotos(const ExchangeBlock& block, const std::string& input) {
  std::set<std::string> names;
  for (const ExchangePhoto& photo : block.photos)
    if (!names.insert(photo.image).second)
      throw InputError(fmt::format("{} has the photo {} twice; remove one", input, photo.image));
}

// For one of so many cameras. If their number differs from that written, the assignment is unknown;
// but they have one flight, hence one value.
EarthRecord EarthOf(const ExportRecord& record, std::size_t camera, std::size_t cameras) {
  if (record.earth.empty()) return {};
  return record.earth[record.earth.size() == cameras ? camera : 0];
}

// A truncated file reads like a smaller block; the verification points beside it reveal that.
void NamePhotosCutOff(const ExchangeBlock& block, const std::string& folder,
                      std::vector<std::string>* messages) {
  const std::string path = VerificationPath(folder);
  if (!fs::exists(path)) return;
  std::set<std::string> missing;
  for (const VerificationRow& row : ReadVerification(path))
    missing.insert(BareImageName(row.image));
  for (const ExchangePhoto& photo : block.photos) missing.erase(BareImageName(photo.image));
  if (missing.empty()) return;
  messages->push_back(path + " names " + std::to_string(missing.size()) +
                      " photos that the file beside it lacks, " + *missing.begin() +
                      " for one: was it truncated?");
}

// Converts both lists of the files' cameras to the block's ground system, and returns the cameras
// for the files' own.
std::vector<ExchangeCamera> BringIntoTheBlocksGround(const ConvertSourceOptions& given,
                                                     const ExportRecord& record,
                                                     std::vector<Camera>* cameras,
                                                     std::vector<ExchangeCamera>* exchanged) {
  // Differences of some percent are due to another calibration of the camera or to rounding.
  constexpr double kSame = 0.03;
  std::vector<ExchangeCamera> in_file = *exchanged;
  for (std::size_t i = 0; i < cameras->size(); ++i) {
    Camera& camera = (*cameras)[i];
    const EarthRecord earth = EarthOf(record, i, cameras->size());
    const double in_block = earth.in_lens + earth.taken_out;
    const double c2 = camera.principal_distance_mm * camera.principal_distance_mm;
    if (given.camera.empty()) camera.earth_k1 = earth.in_lens / c2;
    if (in_block == 0) continue;
    const auto holds = [&](double of_flight) {
      return std::abs(c2 * camera.earth_k1 - of_flight) <= kSame * std::abs(in_block);
    };
    if (holds(in_block))
      in_file[i] = ExchangeCameraOf(WithEarth(camera, -earth.taken_out / c2)).camera;
    else if (holds(earth.in_lens))
      camera = WithEarth(camera, earth.taken_out / c2);
    else
      throw InputError(given.camera + " does not hold what " + FolderOf(given.input) +
                       "/export.json says of the earth's curvature (earth_k1); give the " +
                       "camera.toml beside it");
    (*exchanged)[i] = ExchangeCameraOf(camera).camera;
  }
  return in_file;
}

}  // namespace

ConvertSource ReadForeign(ExchangeFormat format, const ConvertSourceOptions& given) {
  if (format == ExchangeFormat::kOpk) return ReadOrientResults(given);
  const ExportRecord record = ReadExportRecord(FolderOf(given.input));
  ConvertSource source;
  source.crs = BlockCrs(given, record.crs);
  ForeignBlock foreign =
      ReadForeignBlock(format, given.input, record, {source.crs, given.opensfm_offset});
  source.messages = foreign.messages;
  if (given.origin) foreign.frame_origin = *given.origin;
  if (!given.origin && foreign.origin_unknown)
    source.messages.push_back(given.input + " states no origin: its coordinates are taken for " +
                              "the block's own; if one was subtracted, give it with --origin");
  ExchangeBlock& block = foreign.block;
  RequireDistinctPhotos(block, given.input);
  NamePhotosCutOff(block, FolderOf(given.input), &source.messages);
  RestoreNames(record.names, &block);
  if (!given.camera.empty()) {
    const Camera camera = ReadCameraFile(given.camera).camera;
    if (camera.kind != CameraKind::kDigital)
      throw InputError(given.camera + " is a film camera; give the camera.toml of the images");
    const ExchangeCamera exchanged = ExchangeCameraOf(camera).camera;
    const std::string replaced = CompareWithGiven(block.cameras, exchanged, given.input);
    if (!replaced.empty()) source.messages.push_back(replaced);
    block.cameras = {exchanged};
    source.cameras = {camera};
    for (ExchangePhoto& photo : block.photos) photo.camera = 0;
  }
  for (const ExchangeCamera& camera : block.cameras) {
    if (camera.width <= 0 || camera.height <= 0)
      throw InputError(given.input + ": the format " + Name(format) +
                       " does not say the images' size; give their camera with --camera" +
                       (block.cameras.size() > 1 ? ", each camera's photos by themselves" : ""));
    if (given.camera.empty()) source.cameras.push_back(CameraOf(camera));
    RequirePossible(source.cameras.back(), given.input);
  }
  const std::vector<ExchangeCamera> in_file =
      BringIntoTheBlocksGround(given, record, &source.cameras, &block.cameras);
  const GroundFrame frame = FrameOf(foreign, given, record);
  if (source.crs) RequirePlaced(foreign, frame, *source.crs, given.input);
  const auto height = given.ground_height_m ? given.ground_height_m : record.ground_height_m;
  if (!frame.IsShift() && !height)
    throw UsageError("the mean height of the ground is needed to bring " + Name(format) +
                     " into a projected CRS; give it with --ground-height-m");
  for (ExchangePhoto& photo : block.photos) {
    const auto reframed =
        ReframePhoto(frame, FrameWay::kBlockFromFile, photo,
                     {in_file[photo.camera], block.cameras[photo.camera]}, height.value_or(0));
    if (!reframed)
      throw InputError(fmt::format("{}: photo {} does not see the ground at the height {} m",
                                   given.input, photo.image, ExactNumber(*height)));
    photo = reframed->photo;
    RequireFinite(photo, given.input);
    source.ground_height_m.push_back(height);
  }
  block.reference_lla.reset();
  block.crs = source.crs ? source.crs->Wkt() : "";
  source.block = std::move(block);
  return source;
}

}  // namespace orient
