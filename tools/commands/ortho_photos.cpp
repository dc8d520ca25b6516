#include "tools/commands/ortho_photos.h"

#include <fmt/format.h>

#include <filesystem>
#include <fstream>

#include "block/inputs/block_camera.h"
#include "block/inputs/block_photos.h"
#include "block/inputs/digest.h"
#include "block/inputs/mark_shapes.h"
#include "block/inputs/photo_interior.h"
#include "block/stages/exterior_stage.h"
#include "core/base/atomic_write.h"
#include "core/base/error.h"
#include "core/files/orientation_table.h"
#include "core/raster/raster.h"
#include "tools/convert/convert_source.h"
#include "tools/report/figures/mosaic_sources.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

CameraFile CameraOf(const OrthoSource& source) {
  const std::string folder = FolderOf(source.poses), own = block::BlockCameraPath(folder);
  if (source.camera.empty() && !fs::exists(own))
    throw UsageError("name the photos' camera file with --camera: " + folder +
                     " does not hold the one with which its poses are valid");
  if (source.camera.empty()) return ReadCameraFile(own);
  if (const auto other = block::OtherBlockCamera(folder, source.camera))
    throw UsageError("the poses in " + folder + " are valid with " + *other + ", not with " +
                     source.camera + "; leave --camera out");
  return ReadCameraFile(source.camera);
}

// Common to the reading of all photos.
struct Shared {
  const OrthoSource& source;
  OrientationTable table;
  bool is_folder;
  std::string interior, dem;  // the latter's digest
  CameraFile camera;
  interior::MarkShapes marks;
};

Shared ReadShared(const OrthoSource& source) {
  const bool is_folder = fs::is_directory(source.poses);
  const std::string table = is_folder ? block::PoseTablePath(source.poses) : source.poses;
  const CameraFile camera = CameraOf(source);
  const bool film = camera.camera.kind == CameraKind::kFilm;
  return {source,
          ReadOrientationTable(table),
          is_folder,
          source.interior.empty() ? FolderOf(source.poses) : source.interior,
          block::DigestOfRaster(source.dem),
          camera,
          film ? block::LoadMarkShapes(camera) : interior::MarkShapes()};
}

// Like all of these, throws InputError stating what prevents an orthophoto of the photo.
ortho::OrientedPhoto FromResult(const Shared& shared, const std::string& scan) {
  const std::string name = PhotoName(scan);
  const std::string result = ExteriorResultPath(shared.source.poses, name);
  if (!fs::exists(result)) throw InputError("is not oriented: there is no " + result);
  const block::BlockPhotoFile photo =
      block::ReadBlockPhoto(scan, result, shared.camera, shared.marks, shared.interior);
  const Status status = photo.exterior.status;
  const std::string why = JoinedSentences(photo.exterior.findings);
  if (!photo.HasPose() || status == Status::kFailed)
    throw InputError("is not oriented: " + (why.empty() ? result + " has no pose" : why));
  if (const OrientationRow* row = shared.table.Find(name)) {
    const std::string problem = block::PoseContradiction(*row, photo.exterior);
    if (!problem.empty()) throw InputError(problem);
  }
  if (status == Status::kWeak && !shared.source.weak)
    throw InputError("is weak (--weak includes it): " + why);
  return {name, scan,          photo.ViewOfResult(shared.camera.camera), photo.exterior.covariance,
          {},   photo.negative};
}

ortho::OrientedPhoto FromTable(const Shared& shared, const std::string& scan,
                               const block::PhotoInterior& interior) {
  const std::string name = PhotoName(scan);
  const OrientationRow* row = shared.table.Find(name);
  if (row == nullptr) throw InputError("is not in " + shared.source.poses);
  ortho::OrientedPhoto oriented{
      name,
      scan,
      {shared.camera.camera, interior.photo_from_pixel, row->pose, interior.film_correction}};
  // Sigmas alone give no CE90: position and angles of a pose are correlated so much that without
  // the correlations it would come out twice as large.
  const std::string path = InteriorResultPath(shared.interior, name);
  if (shared.camera.camera.kind == CameraKind::kFilm)
    oriented.negative = ReadInteriorResult(path).polarity == Polarity::kNegative;
  return oriented;
}

// The marks with their dark surroundings, and what lies between them and the frame's edge where
// they are next to it.
std::vector<Bounds> MarksIn(const Shared& shared) {
  constexpr double kSurroundings = 1.6;  // of the mark's radius
  const Camera& camera = shared.camera.camera;
  const Eigen::Vector2d low = camera.frame_centre_mm - 0.5 * camera.frame_mm;
  const Eigen::Vector2d high = low + camera.frame_mm;
  std::vector<Bounds> marks;
  for (const Fiducial& fiducial : shared.camera.fiducials) {
    const auto shape = shared.marks.find(fiducial.mark);
    if (shape == shared.marks.end()) continue;
    const double half = kSurroundings * interior::MarkRadius(shape->second);
    const Eigen::Vector2d& at = fiducial.position_mm;
    const auto from = [&](int i) { return at[i] - low[i] < 2 * half ? low[i] : at[i] - half; };
    const auto to = [&](int i) { return high[i] - at[i] < 2 * half ? high[i] : at[i] + half; };
    marks.push_back({from(0), from(1), to(0), to(1)});
  }
  return marks;
}

ortho::OrientedPhoto Read(const Shared& shared, const std::string& scan) {
  const Raster raster = Raster::OpenScan(scan);
  const Camera& camera = shared.camera.camera;
  if (shared.is_folder) block::RequireOrientedScan(raster, camera, shared.interior);
  ortho::OrientedPhoto photo =
      shared.is_folder
          ? FromResult(shared, scan)
          : FromTable(shared, scan, block::PhotoInteriorOf(raster, camera, shared.interior));
  photo.marks = MarksIn(shared);
  return photo;
}

std::string DigestOf(const Shared& shared, const ortho::OrientedPhoto& photo) {
  const OrientationRow* row = shared.table.Find(photo.name);
  return block::DigestOf(
      {{"scan", block::DigestOfFile(photo.scan)},
       {"camera", block::DigestOfCamera(shared.camera)},
       {"dem", shared.dem},
       {"pose", block::TextOf(row)},
       {"exterior",
        block::DigestOfContents(ExteriorResultPath(FolderOf(shared.source.poses), photo.name))},
       {"interior", block::DigestOfContents(InteriorResultPath(shared.interior, photo.name))}});
}

// Whether the metadata of the program's own files stands at the file's beginning.
bool BeginsAsOwn(const std::string& path) {
  std::string begin(1 << 16, '\0');
  std::ifstream file(path, std::ios::binary);
  file.read(begin.data(), std::ssize(begin));
  begin.resize(static_cast<std::size_t>(file.gcount()));
  return begin.find(kMadeFrom) != std::string::npos;
}

}  // namespace

OrthoPhotos ReadOrthoPhotos(const OrthoSource& source) {
  const Shared shared = ReadShared(source);
  if (!shared.table.crs)
    throw InputError(source.poses +
                     ": the table of orientations has no .prj beside it that names "
                     "its CRS; write one, or orient anew");
  OrthoPhotos found{*shared.table.crs, {}, {}, {}};
  for (const std::string& scan : source.scans) {
    try {
      found.photos.push_back(Read(shared, scan));
      found.made_from.push_back(DigestOf(shared, found.photos.back()));
    } catch (const InputError& error) {
      found.left_out.push_back(fmt::format("{}: {}", PhotoName(scan), error.what()));
    }
  }
  return found;
}

void RefuseFileOfOthers(const std::string& path,
                        const std::function<bool(const BandRaster&)>& is_own) {
  if (!fs::exists(path)) return;
  try {
    if (is_own(BandRaster::Open(path))) return;
  } catch (const InputError&) {
    if (BeginsAsOwn(path)) return;  // cut off: made anew
  }
  throw UsageError(path +
                   " was not made by orient ortho; choose another folder or give --overwrite");
}

}  // namespace orient
