#include "tools/convert/write_exports.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <set>

#include "block/inputs/block_files.h"
#include "core/base/column_names.h"
#include "core/base/error.h"
#include "core/base/output_directory.h"
#include "core/exchange/asp_pinhole.h"
#include "core/exchange/colmap.h"
#include "core/exchange/frame_adjustments.h"
#include "core/exchange/metashape.h"
#include "core/exchange/metashape_markers.h"
#include "core/exchange/micmac_homologues.h"
#include "core/exchange/micmac_orientation.h"
#include "core/exchange/opensfm.h"
#include "core/files/camera_file.h"
#include "core/files/orientation_table.h"
#include "core/geometry/collinearity.h"
#include "core/terrain/earth_effects.h"
#include "tools/convert/export_record.h"
#include "tools/convert/ground_frame.h"
#include "tools/convert/program_names.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

// A verification point in all the systems that a format may need.
struct Verified {
  std::size_t photo = 0;
  Eigen::Vector3d block_m;
  Eigen::Vector2d pixel;
  Eigen::Vector2d reduced_mm;
};

// A round origin near the block's centre; heights stay unchanged.
Eigen::Vector3d RoundOrigin(const ExchangeBlock& block) {
  constexpr double kRound_m = 1000;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const ExchangePhoto& photo : block.photos) mean += photo.centre;
  mean /= static_cast<double>(block.photos.size());
  return {kRound_m * std::round(mean.x() / kRound_m), kRound_m * std::round(mean.y() / kRound_m),
          0};
}

// The ground height under a photo; any will do for formats in the block's own system: default is an
// image scale of 1 : 10 000.
double GroundHeight(const ConvertSource& source, std::size_t photo) {
  const Camera& camera = source.cameras[source.block.photos[photo].camera];
  return source.ground_height_m[photo].value_or(source.block.photos[photo].centre.z() -
                                                10 * camera.principal_distance_mm);
}

// Three by three places over each image, their ground points at three heights in turn; the pixel is
// that of Orient's own collinearity.
std::vector<Verified> VerificationPoints(const ConvertSource& source) {
  std::vector<Verified> points;
  const GroundFrame frame = GroundFrame::Shifted(Eigen::Vector3d::Zero());
  for (std::size_t i = 0; i < source.block.photos.size(); ++i) {
    const Pose pose = PoseOf(source.block.photos[i]);
    const Camera& camera = source.cameras[source.block.photos[i].camera];
    const Affine2d photo_from_pixel = DigitalPhotoFromPixel(camera);
    const Affine2d pixel_from_photo = photo_from_pixel.Inverse();
    const double mean = GroundHeight(source, i);
    const double relief = 0.02 * (pose.position_m.z() - mean);
    for (int place = 0; place < 9; ++place) {
      const int across = place % 3 - 1, along = place / 3 - 1;
      const Eigen::Vector2d part(0.4 * across, 0.4 * along);
      const auto ray = GroundRayFromPhoto(camera, pose, part.cwiseProduct(camera.frame_mm));
      if (!ray) continue;
      const auto ground = PointAtHeight(frame, FrameWay::kFileFromBlock, ray->origin_m,
                                        ray->direction, mean + (place * 2 % 3 - 1) * relief);
      const auto photo_mm = ground ? PhotoFromGround(camera, pose, *ground) : std::nullopt;
      if (!photo_mm) continue;
      const Eigen::Vector3d d = pose.GroundFromPhoto().transpose() * (*ground - pose.position_m);
      points.push_back({i, *ground, pixel_from_photo * *photo_mm,
                        -camera.principal_distance_mm * d.head<2>() / d.z()});
    }
  }
  return points;
}

std::optional<double> MeanGroundHeight(const ConvertSource& source) {
  double sum = 0;
  int count = 0;
  for (const auto& height : source.ground_height_m)
    if (height) sum += *height, ++count;
  if (count == 0) return std::nullopt;
  return sum / count;
}

// Earth curvature contained in a camera's lens but not wanted in the file's ground system.
double CurvatureIn(const GroundFrame& frame, const ConvertSource& source, const Camera& camera) {
  return frame.IsShift() ? 0 : CurvatureOf(camera, MeanGroundHeight(source).value_or(0));
}

GroundFrame FrameOf(const ConvertSource& source, const ExportOptions& options,
                    ExchangeFormat format) {
  const bool shifted = format == ExchangeFormat::kColmap || format == ExchangeFormat::kMetashape;
  if (shifted) return GroundFrame::Shifted(options.origin.value_or(RoundOrigin(source.block)));
  if (format != ExchangeFormat::kAsp && format != ExchangeFormat::kOpensfm)
    return GroundFrame::Shifted(Eigen::Vector3d::Zero());
  if (!source.crs)
    throw InputError("the format " + Name(format) +
                     " needs the block's CRS, which no .prj names; give it with --crs");
  GroundFrame frame = GroundFrame::Geocentric(*source.crs, options.geoid_m);
  if (format == ExchangeFormat::kAsp) return frame;
  Eigen::Vector3d origin = options.origin.value_or(RoundOrigin(source.block));
  const auto at = frame.GeodeticFromBlock(origin);
  if (!at) throw InputError("PROJ finds no latitude and longitude for the block's centre");
  return GroundFrame::Topocentric(*source.crs, options.geoid_m, *at);
}

// The images' cameras as the file's ground system needs them: geocentric and topocentric ground is
// curved itself.
std::vector<Camera> CamerasIn(const GroundFrame& frame, const ConvertSource& source) {
  std::vector<Camera> cameras = source.cameras;
  for (Camera& camera : cameras) camera = WithEarth(camera, -CurvatureIn(frame, source, camera));
  return cameras;
}

// The block in the file's ground system, its verification points filled in.
ExchangeBlock Framed(const ConvertSource& source, const std::vector<Verified>& verified,
                     const GroundFrame& frame, WrittenExport* written) {
  ExchangeBlock block = source.block;
  const std::vector<Camera> cameras = CamerasIn(frame, source);
  for (std::size_t i = 0; i < cameras.size(); ++i)
    if (cameras[i].earth_k1 != source.cameras[i].earth_k1)
      block.cameras[i] = ExchangeCameraOf(cameras[i]).camera;
  block.origin = frame.Origin();
  if (const auto& at = frame.TopocentricOrigin())
    block.reference_lla =
        Eigen::Vector3d(DegFromRad(at->latitude_rad), DegFromRad(at->longitude_rad), at->height_m);
  const auto mapped = [&](const Eigen::Vector3d& point) {
    const auto at = frame.FileFromBlock(point);
    if (!at) throw InputError("PROJ cannot transform a ground point of the block");
    return *at;
  };
  for (std::size_t i = 0; i < block.photos.size(); ++i) {
    ExchangePhoto& photo = block.photos[i];
    if (!frame.IsShift() && !source.ground_height_m[i])
      throw InputError("photo " + photo.image + ": the format " + Name(written->format) +
                       " needs the height of the ground under it; give --ground-height-m");
    const auto reframed = ReframePhoto(
        frame, FrameWay::kFileFromBlock, photo,
        {source.block.cameras[photo.camera], block.cameras[photo.camera]}, GroundHeight(source, i));
    if (!reframed)
      throw InputError(fmt::format("photo {} does not see the ground at the height {} m everywhere",
                                   photo.image, ExactNumber(GroundHeight(source, i))));
    photo = reframed->photo;
    written->rms_px = std::max(written->rms_px, reframed->rms_px);
    written->largest_px = std::max(written->largest_px, reframed->largest_px);
  }
  for (ExchangePoint& point : block.points) point.ground = mapped(point.ground);
  for (const Verified& v : verified)
    block.verification.push_back({v.photo, mapped(v.block_m), v.pixel});
  return block;
}

// Most formats name images without folder and ending, MicMac without folder.
void RequireOwnNames(const ExchangeBlock& block, ExchangeFormat format) {
  if (format == ExchangeFormat::kColmap || format == ExchangeFormat::kOpensfm) return;
  const auto name_in_files = [&](const std::string& image) {
    return format == ExchangeFormat::kMicmac ? fs::path(image).filename().string()
                                             : BareImageName(image);
  };
  std::map<std::string, std::string> images;
  for (const ExchangePhoto& photo : block.photos) {
    const auto [known, is_new] = images.emplace(name_in_files(photo.image), photo.image);
    if (!is_new)
      throw InputError(
          fmt::format("the images {} and {} would have one name in files of the format "
                      "{}; rename one of them",
                      known->second, photo.image, Name(format)));
  }
}

void WriteOpk(const std::string& directory, const ConvertSource& source) {
  OrientationTable table;
  table.crs = source.crs;
  for (const ExchangePhoto& photo : source.block.photos)
    table.rows.push_back({BareImageName(photo.image), PoseOf(photo), std::nullopt});
  WriteOrientationTable((fs::path(directory) / "orientation.csv").string(), table);
}

void WriteFormat(const std::string& directory, ExchangeFormat format, const ExchangeBlock& block,
                 const ConvertSource& source) {
  switch (format) {
    case ExchangeFormat::kOpk:
      return WriteOpk(directory, source);
    case ExchangeFormat::kOri:
      return WriteOri(directory, block);
    case ExchangeFormat::kPatb:
      return WritePatb(directory, block);
    case ExchangeFormat::kBingo:
      return WriteBingo(directory, block);
    case ExchangeFormat::kMicmac:
      WriteMicmacOrientation(directory, "Orient", block);
      return WriteMicmacHomologues(directory, block);
    case ExchangeFormat::kMetashape:
      WriteMetashape(directory, block);
      return WriteMetashapeMarkers(directory, block);
    case ExchangeFormat::kColmap:
      return WriteColmap(directory, block);
    case ExchangeFormat::kOpensfm:
      return WriteOpensfm(directory, block);
    case ExchangeFormat::kAsp:
      return WriteAsp(directory, block);
  }
}

// `world`: what the format itself adds to its coordinates.
std::vector<VerificationRow> Rows(const ConvertSource& source,
                                  const std::vector<Verified>& verified, const ExchangeBlock& block,
                                  const Eigen::Vector3d& world) {
  std::vector<VerificationRow> rows;
  for (std::size_t i = 0; i < verified.size(); ++i) {
    const Verified& v = verified[i];
    const ExchangePhoto& photo = block.photos[v.photo];
    rows.push_back({photo.image, v.block_m, block.verification[i].ground + world, v.pixel,
                    v.reduced_mm, source.cameras[photo.camera].principal_distance_mm,
                    block.cameras[photo.camera].pixel_mm});
  }
  return rows;
}

void WriteCamera(const std::string& directory, const Camera& camera, std::size_t index,
                 std::size_t count) {
  const std::string name = count == 1 ? "camera.toml" : fmt::format("camera_{}.toml", index + 1);
  WriteCameraFile((fs::path(directory) / name).string(), {camera, {}, {}, std::nullopt, {}});
}

// Renames the images as in the files; returns the true names of those that were renamed.
std::map<std::string, std::string> NameAsInFiles(ExchangeFormat format, ExchangeBlock* block) {
  std::map<std::string, std::string> true_names;
  const std::vector<std::string> names = NamesInFiles(*block, format);
  for (std::size_t i = 0; i < names.size(); ++i) {
    std::string& image = block->photos[i].image;
    if (names[i] != image) true_names[names[i]] = image;
    image = names[i];
  }
  return true_names;
}

// A record may come from elsewhere.
bool StaysInItsFolder(const std::string& file) {
  const fs::path path = fs::path(file).lexically_normal();
  return path.is_relative() && !path.empty() && *path.begin() != "..";
}

// With their times: a file that is replaced has another one.
std::map<std::string, fs::file_time_type> FilesBelow(const std::string& directory) {
  std::map<std::string, fs::file_time_type> files;
  std::error_code error, ignored;
  for (fs::recursive_directory_iterator entry(directory, error), end; !error && entry != end;
       entry.increment(error))
    if (!entry->is_directory(ignored))
      files[entry->path().lexically_relative(directory).generic_string()] =
          entry->last_write_time(ignored);
  return files;
}

WrittenExport WriteExport(const ConvertSource& source, const std::vector<Verified>& verified,
                          const ExportOptions& options, ExchangeFormat format) {
  RequireOwnNames(source.block, format);
  WrittenExport written{format, ExportDirectory(options, format), 0, 0};
  const GroundFrame frame = FrameOf(source, options, format);
  ExchangeBlock block = Framed(source, verified, frame, &written);
  const std::map<std::string, std::string> names = NameAsInFiles(format, &block);
  written.renamed = names.size();
  MakeOutputDirectory(written.directory);
  const auto before = FilesBelow(written.directory);
  WriteFormat(written.directory, format, block, source);
  const bool adds_origin = format == ExchangeFormat::kMetashape;
  const Eigen::Vector3d world = adds_origin ? frame.Origin() : Eigen::Vector3d::Zero();
  WriteVerification(written.directory, Rows(source, verified, block, world));
  ExportRecord record{
      Name(format), source.crs, frame.Origin(), options.geoid_m, MeanGroundHeight(source), {}};
  record.names = names;
  const std::vector<Camera> cameras = CamerasIn(frame, source);
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    WriteCamera(written.directory, cameras[i], i, cameras.size());
    const double c2 = cameras[i].principal_distance_mm * cameras[i].principal_distance_mm;
    record.earth.push_back(
        {c2 * cameras[i].earth_k1, c2 * CurvatureIn(frame, source, source.cameras[i])});
  }
  for (const auto& [file, time] : FilesBelow(written.directory))
    if (const auto then = before.find(file); then == before.end() || then->second != time)
      record.files.insert(file);
  record.files.insert("export.json");
  WriteExportRecord(written.directory, record);
  written.check = CheckExport(written.directory, format, "");
  if (!written.check.ok)
    throw InputError(written.directory + ": what was written does not project as it should (" +
                     Verdict(written.check) + "); do not use it");
  return written;
}

}  // namespace

std::string ExportDirectory(const ExportOptions& options, ExchangeFormat format) {
  return (fs::path(options.out) / Name(format)).string();
}

std::vector<WrittenExport> WriteExports(const ConvertSource& source, const ExportOptions& options) {
  const std::vector<Verified> verified = VerificationPoints(source);
  std::vector<WrittenExport> all;
  std::string failed, done;
  for (const ExchangeFormat format : options.formats) {
    try {
      all.push_back(WriteExport(source, verified, options, format));
      done += (done.empty() ? "" : ", ") + Name(format);
    } catch (const InputError& error) {
      failed += (failed.empty() ? "" : "; ") + Name(format) + ": " + error.what();
    }
  }
  if (!failed.empty()) throw InputError(failed + (done.empty() ? "" : "; written: " + done));
  return all;
}

std::vector<std::string> NotesOn(const WrittenExport& written, const ConvertSource& source) {
  std::vector<std::string> notes;
  if (written.largest_px > 0)
    notes.push_back(fmt::format(
        "another ground system: scale and curvature leave rms {:.2g} px, largest {:.2g} px",
        written.rms_px, written.largest_px));
  if (written.renamed > 0)
    notes.push_back(
        fmt::format("{} photos' names hold blanks, at which the program would cut them: they are "
                    "written with _ instead; the true names stand in export.json",
                    written.renamed));
  const bool lens = std::any_of(source.cameras.begin(), source.cameras.end(), [](const auto& of) {
    return !std::holds_alternative<std::monostate>(of.lens);
  });
  const ExchangeFormat format = written.format;
  if (lens && (format == ExchangeFormat::kPatb || format == ExchangeFormat::kBingo))
    notes.emplace_back(
        "image coordinates are free of all that camera.toml has in its lens (distortion, curvature "
        "and refraction if included): leave the program's own corrections off");
  if (lens && (format == ExchangeFormat::kOpk || format == ExchangeFormat::kOri))
    notes.emplace_back("the format holds no camera: its poses hold with camera.toml beside it");
  return notes;
}

void RemoveExportsOf(const std::string& folder) {
  const fs::path exports = fs::path(folder) / block::kExportsFolder;
  std::error_code error, ignored;
  for (fs::directory_iterator entry(exports, error), end; !error && entry != end;
       entry.increment(error)) {
    std::set<std::string> files;
    try {
      files = ReadExportRecord(entry->path().string()).files;
    } catch (const InputError&) {  // nobody knows what belongs to it: all stays
    }
    for (const std::string& file : files) {
      if (!StaysInItsFolder(file)) continue;
      fs::path path = entry->path() / file;
      // With the folders that are empty then.
      while (fs::remove(path, ignored) && path != entry->path()) path = path.parent_path();
    }
  }
  fs::remove(exports, ignored);  // if it is empty
}

ExportsOfFolder WriteExportsOf(const std::string& folder, const std::string& camera,
                               const std::vector<std::string>& formats) {
  ExportOptions options;
  options.out = (fs::path(folder) / block::kExportsFolder).string();
  for (const std::string& name : formats) {
    const auto format = ExchangeFormatFromName(name);
    if (!format) throw UsageError("\"" + name + "\" is not a format that can be written");
    options.formats.push_back(*format);
  }
  ConvertSourceOptions source_options;
  source_options.input = folder;
  source_options.camera = camera;
  const ConvertSource source = ReadOrientResults(source_options);
  ExportsOfFolder exports{WriteExports(source, options), {}};
  for (const std::string& message : source.messages)
    exports.findings.push_back({.reason = Reason::kExportSource, .where = message});
  for (const WrittenExport& written : exports.written)
    for (const std::string& note : NotesOn(written, source))
      exports.findings.push_back({.reason = Reason::kExportNote,
                                  .where = fmt::format("{}: {}", Name(written.format), note)});
  return exports;
}

}  // namespace orient
