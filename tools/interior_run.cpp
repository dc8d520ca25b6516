#include "tools/interior_run.h"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <filesystem>
#include <set>

#include "core/error.h"
#include "core/files/orientation_table.h"
#include "interior/camera_choice.h"
#include "interior/mark_picture.h"
#include "tools/camera_library.h"
#include "tools/interior_outputs.h"
#include "tools/shared_options.h"
#include "tools/summary_table.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

// What the pictures of the marks show around a mark.
double PictureReach(const MarkShapes& shapes) {
  double radius = 0;
  for (const auto& [name, shape] : shapes) radius = std::max(radius, MarkRadius(shape));
  return 1.6 * radius;
}

void CheckNames(const std::vector<std::string>& photos) {
  std::set<std::string> names;
  for (const std::string& photo : photos)
    if (!names.insert(PhotoName(photo)).second)
      throw UsageError("two photos are named " + PhotoName(photo) +
                       " and would write the same result; orient them in separate runs");
}

Picture Draw(const CameraFile& camera, const MarkShapes& shapes, const Raster& scan,
             const InteriorResult& result) {
  std::vector<Eigen::Vector2d> positions;
  for (const Fiducial& f : camera.fiducials) positions.push_back(f.position_mm);
  // 0.1 mm only where nothing says how large a pixel is: then there is no transform either.
  const double pixel_mm = 1e-3 * result.pixel_size_um.value_or(100.0);
  return DrawMarks(scan, result, positions, pixel_mm, PictureReach(shapes));
}

// The cameras that a run may find: the one that was named, or those of the library.
struct RunCameras {
  std::vector<LibraryCamera> all;
  bool named = false;
};

RunCameras LoadCameras(const InteriorRunOptions& options) {
  RunCameras cameras;
  if (options.camera == kAutoCamera) {
    cameras.all = ReadCameraLibrary(CameraLibraryFolder(options.camera_library));
    std::erase_if(cameras.all, [](const LibraryCamera& camera) { return camera.format_only; });
    return cameras;
  }
  LibraryCamera camera;
  camera.file = ReadCameraFile(options.camera);
  camera.shapes = LoadMarkShapes(camera.file);
  cameras.all.push_back(std::move(camera));
  cameras.named = true;
  return cameras;
}

CameraChoice Orient(const Raster& scan, const RunCameras& cameras, const InteriorOptions& options) {
  if (cameras.named) {
    const LibraryCamera& camera = cameras.all.front();
    return {OrientInterior(scan, camera.file, camera.shapes, options), 0};
  }
  std::vector<KnownCamera> known;
  for (const LibraryCamera& camera : cameras.all)
    known.push_back({camera.name, &camera.file, &camera.shapes});
  return OrientWithUnknownCamera(scan, known, options);
}

// The camera of all photos; null where they were found to be from several, or from none.
const CameraFile* CameraOfRoll(const RunCameras& cameras,
                               const std::vector<InteriorResult>& results) {
  if (cameras.named) return &cameras.all.front().file;
  std::string name;
  for (const InteriorResult& result : results) {
    if (result.cameras.empty()) continue;
    if (!name.empty() && name != result.cameras.front()) return nullptr;
    name = result.cameras.front();
  }
  const auto found = std::find_if(cameras.all.begin(), cameras.all.end(),
                                  [&](const LibraryCamera& c) { return c.name == name; });
  return found == cameras.all.end() ? nullptr : &found->file;
}

// A damaged scan fails this photo only; a result that cannot be written ends the run.
InteriorResult OrientOne(const InteriorRunOptions& options, const RunCameras& cameras,
                         const std::string& photo) {
  const std::string name = PhotoName(photo);
  const std::string path = InteriorResultPath(options.out, name);
  if (options.resume && fs::exists(path)) return ReadInteriorResult(path);
  InteriorResult result;
  std::optional<Picture> picture;
  try {
    const Raster scan = Raster::Open(photo);
    const CameraChoice choice = Orient(scan, cameras, options.scan);
    result = choice.result;
    if (choice.camera && !result.marks.empty()) {
      const LibraryCamera& camera = cameras.all[*choice.camera];
      picture = Draw(camera.file, camera.shapes, scan, result);
    }
  } catch (const InputError& error) {
    result = {};
    result.messages = {error.what()};
  }
  result.photo = name;
  if (picture)
    WritePng((fs::path(options.out) / (name + ".marks.png")).string(), picture->width,
             picture->height, 3, picture->rgb);
  WriteInteriorResult(options.out, result);
  return result;
}

// A whole scan in place of a cut-out mark would be read, and searched for, in vain.
Image LoadPicture(const std::string& mark, const MarkImage& image) {
  constexpr double kLargest_mm = 20;
  const Raster raster = Raster::Open(image.path);
  const double side_mm = std::max(raster.Width(), raster.Height()) * image.pixel_size_mm;
  if (side_mm > kLargest_mm)
    throw InputError(image.path + ": the picture of mark " + mark + " is " + Fixed(side_mm, 1) +
                     " mm wide; cut the mark out, or correct pixel_size_mm");
  const Eigen::Vector2d& centre = image.centre_px;
  if (centre.minCoeff() < 0 || centre.x() > raster.Width() || centre.y() > raster.Height())
    throw InputError(image.path + ": the centre_px of mark " + mark + " lies outside its picture");
  return raster.ReadGrey().image;
}

}  // namespace

MarkShapes LoadMarkShapes(const CameraFile& camera) {
  std::map<std::string, Image> pictures;
  for (const auto& [name, drawing] : camera.marks)
    if (drawing.image) pictures[name] = LoadPicture(name, *drawing.image);
  return ShapesOf(camera, pictures);
}

std::vector<InteriorResult> RunInterior(const InteriorRunOptions& options,
                                        const std::function<void()>& done) {
  CheckNames(options.photos);
  const RunCameras cameras = LoadCameras(options);
  MakeOutputDirectory(options.out);
  std::vector<InteriorResult> results(options.photos.size());
  tbb::task_arena arena(options.jobs > 0 ? options.jobs : tbb::task_arena::automatic);
  arena.execute([&] {
    tbb::parallel_for(size_t{0}, options.photos.size(), [&](size_t i) {
      results[i] = OrientOne(options, cameras, options.photos[i]);
      if (done) done();
    });
  });
  if (const CameraFile* camera = CameraOfRoll(cameras, results)) {
    WriteInteriorOutputs(options.out, *camera, &results);
    if (options.micmac) WriteMicmacOutputs(options.out, *camera, options.photos, results);
  }
  return results;
}

}  // namespace orient
