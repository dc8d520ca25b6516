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
#include "tools/made_from.h"
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

// The camera of all photos: the one that was named, or one that fits them all. Null where there is
// none.
const CameraFile* CameraOfRoll(const RunCameras& cameras,
                               const std::vector<InteriorResult>& results) {
  if (cameras.named) return &cameras.all.front().file;
  bool any = false;
  std::set<std::string> fitting;
  for (const InteriorResult& result : results) {
    if (result.cameras.empty()) continue;
    const std::set<std::string> names(result.cameras.begin(), result.cameras.end());
    if (!any) fitting = names;
    std::erase_if(fitting, [&](const std::string& name) { return !names.contains(name); });
    any = true;
  }
  const auto found = std::find_if(cameras.all.begin(), cameras.all.end(),
                                  [&](const auto& c) { return fitting.contains(c.name); });
  return found == cameras.all.end() ? nullptr : &found->file;
}

// One a photo; they differ in the scan only.
std::vector<MadeFrom> InputsOf(const InteriorRunOptions& options, const RunCameras& cameras) {
  std::string all;
  for (const LibraryCamera& camera : cameras.all) all += DigestOfCamera(camera.file);
  std::vector<MadeFrom> inputs(options.photos.size(),
                               {Digest(all), DigestOfOptions(options.scan), ""});
  for (size_t i = 0; i < inputs.size(); ++i) inputs[i].scan = DigestOfFile(options.photos[i]);
  return inputs;
}

// A result that is there to be kept. Empty where it is absent or unreadable: the photo is done
// again. Throws UsageError where it was made from something else.
std::optional<InteriorResult> KeptResult(const std::string& path, const MadeFrom& inputs,
                                         bool redo_changed) {
  if (!fs::exists(path)) return std::nullopt;
  InteriorResult result;
  try {
    result = ReadInteriorResult(path);
  } catch (const InputError&) {
    return std::nullopt;
  }
  const std::string changed = WhatChanged(result.made_from, inputs);
  if (changed.empty()) return result;
  if (redo_changed) return std::nullopt;
  throw UsageError(path + " was made from another " + changed +
                   "; choose another folder, or --overwrite to do all photos again");
}

std::vector<std::optional<InteriorResult>> KeptResults(const InteriorRunOptions& options,
                                                       const std::vector<MadeFrom>& inputs) {
  std::vector<std::optional<InteriorResult>> kept(options.photos.size());
  for (size_t i = 0; options.resume && i < kept.size(); ++i)
    kept[i] = KeptResult(InteriorResultPath(options.out, PhotoName(options.photos[i])), inputs[i],
                         options.redo_changed);
  return kept;
}

// Whatever a scan does to the program fails this photo only; a result that cannot be written ends
// the run.
InteriorResult OrientOne(const InteriorRunOptions& options, const RunCameras& cameras,
                         const std::string& photo, const MadeFrom& inputs) {
  const std::string name = PhotoName(photo);
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
  } catch (const std::exception& error) {
    result = {};
    result.messages = {photo + ": could not be worked on (" + error.what() + ")"};
  }
  result.photo = name;
  result.made_from = inputs;
  if (picture)
    WritePng((fs::path(options.out) / (name + ".marks.png")).string(), picture->width,
             picture->height, 3, picture->rgb);
  WriteInteriorResult(options.out, result);
  return result;
}

// Of earlier runs into the same folder, with the same camera: the tables keep their rows.
std::vector<InteriorResult> EarlierResults(const std::string& directory,
                                           const std::vector<InteriorResult>& results) {
  if (results.empty() || !results.front().made_from) return {};
  std::set<std::string> known;
  for (const InteriorResult& result : results) known.insert(result.photo);
  std::vector<InteriorResult> earlier;
  for (const std::string& path : InteriorResultPaths(directory)) {
    try {
      InteriorResult result = ReadInteriorResult(path);
      if (!known.contains(result.photo) && result.made_from &&
          result.made_from->camera == results.front().made_from->camera)
        earlier.push_back(std::move(result));
    } catch (const InputError&) {  // a damaged one of another run is not this run's business
    }
  }
  return earlier;
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

std::vector<std::string> NotesOn(const InteriorRunOptions& options, const CameraFile* camera,
                                 const std::vector<InteriorResult>& results) {
  std::vector<std::string> notes;
  if (!camera) {
    notes.emplace_back("The photos are not from one camera: no marks.csv" +
                       std::string(options.micmac ? ", no MicMac files" : "") +
                       ", no comparison with one another. Orient each camera's photos alone.");
    return notes;
  }
  const auto open = std::count_if(results.begin(), results.end(), [](const InteriorResult& r) {
    return r.photo_from_pixel && r.possible_orientations.size() > 1;
  });
  if (options.micmac && open > 0)
    notes.push_back("MicMac files: " + std::to_string(open) +
                    " photos lie in an open way, and their marks carry the names of the first "
                    "possible one; give --orientation.");
  return notes;
}

}  // namespace

MarkShapes LoadMarkShapes(const CameraFile& camera) {
  std::map<std::string, Image> pictures;
  for (const auto& [name, drawing] : camera.marks)
    if (drawing.image) pictures[name] = LoadPicture(name, *drawing.image);
  return ShapesOf(camera, pictures);
}

std::set<std::string> InteriorsThatStay(const InteriorRunOptions& options) {
  std::set<std::string> stay;
  for (const auto& kept : KeptResults(options, InputsOf(options, LoadCameras(options))))
    if (kept) stay.insert(kept->photo);
  return stay;
}

std::vector<InteriorResult> RunInterior(const InteriorRunOptions& options,
                                        const std::function<void()>& done,
                                        std::vector<std::string>* notes) {
  CheckNames(options.photos);
  const RunCameras cameras = LoadCameras(options);
  MakeOutputDirectory(options.out);
  const std::vector<MadeFrom> inputs = InputsOf(options, cameras);
  const auto kept = KeptResults(options, inputs);
  std::vector<InteriorResult> results(options.photos.size());
  tbb::task_arena arena(options.jobs > 0 ? options.jobs : tbb::task_arena::automatic);
  arena.execute([&] {
    tbb::parallel_for(size_t{0}, options.photos.size(), [&](size_t i) {
      results[i] = kept[i] ? *kept[i] : OrientOne(options, cameras, options.photos[i], inputs[i]);
      if (done) done();
    });
  });
  const CameraFile* camera = CameraOfRoll(cameras, results);
  WriteInteriorOutputs(options.out, camera, EarlierResults(options.out, results), &results);
  if (options.micmac && camera) WriteMicmacOutputs(options.out, *camera, options.photos, results);
  if (notes) *notes = NotesOn(options, camera, results);
  return results;
}

}  // namespace orient
