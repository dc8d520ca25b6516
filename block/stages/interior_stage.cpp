#include "block/stages/interior_stage.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <set>

#include "block/inputs/camera_library.h"
#include "block/inputs/digest.h"
#include "block/inputs/mark_shapes.h"
#include "block/stages/interior_outputs.h"
#include "block/stages/jobs.h"
#include "core/base/environment_error.h"
#include "core/base/error.h"
#include "core/base/output_directory.h"
#include "core/files/orientation_table.h"
#include "interior/camera_choice.h"
#include "interior/marks/mark_picture.h"

namespace orient::block {
namespace {
namespace fs = std::filesystem;

// What the pictures of the marks show around a mark.
double PictureReach(const interior::MarkShapes& shapes) {
  double radius = 0;
  for (const auto& [name, shape] : shapes) radius = std::max(radius, MarkRadius(shape));
  return 1.6 * radius;
}

interior::Picture Draw(const CameraFile& camera, const interior::MarkShapes& shapes,
                       const Raster& scan, const InteriorResult& result) {
  std::vector<Eigen::Vector2d> positions;
  for (const Fiducial& f : camera.fiducials) positions.push_back(f.position_mm);
  // 0.1 mm only where nothing says how large a pixel is: then there is no transform either.
  const double pixel_mm = 1e-3 * result.pixel_size_um.value_or(100.0);
  return interior::DrawMarks(scan, result, positions, pixel_mm, PictureReach(shapes));
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

interior::CameraChoice Orient(const Raster& scan, const RunCameras& cameras,
                              const interior::InteriorOptions& options) {
  if (cameras.named) {
    const LibraryCamera& camera = cameras.all.front();
    return {interior::OrientInterior(scan, camera.file, camera.shapes, options), 0};
  }
  std::vector<interior::KnownCamera> known;
  for (const LibraryCamera& camera : cameras.all)
    known.push_back({camera.name, &camera.file, &camera.shapes});
  return interior::OrientWithUnknownCamera(scan, known, options);
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

ResultStore StoreOf(const InteriorRunOptions& options) { return {options.out, ".interior.json"}; }

// One per photo; they differ in the scan only. A scan that cannot be read now is no other one than
// that of a result to be kept.
std::vector<Inputs> InputsOf(const InteriorRunOptions& options, const RunCameras& cameras) {
  Inputs all;
  for (const LibraryCamera& camera : cameras.all) all[camera.name] = DigestOfCamera(camera.file);
  std::vector<Inputs> inputs(
      options.photos.size(),
      {{"camera", DigestOf(all)}, {"options", DigestOfOptions(options.scan)}, {"scan", ""}});
  for (size_t i = 0; i < inputs.size(); ++i) {
    inputs[i]["scan"] = DigestOfFile(options.photos[i]);
    if (!options.resume || !inputs[i]["scan"].empty()) continue;
    const auto then = StoreOf(options).MadeFrom(PhotoName(options.photos[i]));
    if (then && WhatChanged(*then, inputs[i]) == std::vector<std::string>{"scan"})
      inputs[i] = *then;
  }
  return inputs;
}

// The photos whose results are there to be kept. Throws UsageError where one was made from
// something else and is not to be done again.
std::set<std::string> KeptResults(const InteriorRunOptions& options,
                                  const std::vector<Inputs>& inputs) {
  std::set<std::string> kept;
  const ResultStore store = StoreOf(options);
  for (size_t i = 0; options.resume && i < inputs.size(); ++i) {
    const std::string name = PhotoName(options.photos[i]);
    const KnownResult known = store.Check(name, inputs[i]);
    if (known.state == ResultState::kCurrent || known.state == ResultState::kUnstated)
      kept.insert(name);
    if (known.state == ResultState::kChanged && !options.redo_changed)
      throw UsageError(store.PathOf(name) + " was made from another " +
                       TextOfInputs(known.changed) +
                       "; choose another folder, or --overwrite to do all photos again");
  }
  return kept;
}

// Whatever a scan does to the program fails this photo only; a result that cannot be written ends
// the run.
InteriorResult OrientOne(const InteriorRunOptions& options, const RunCameras& cameras,
                         const std::string& photo, const Inputs& inputs) {
  const std::string name = PhotoName(photo);
  InteriorResult result;
  std::optional<interior::Picture> picture;
  try {
    const Raster scan = Raster::Open(photo);
    const interior::CameraChoice choice = Orient(scan, cameras, options.scan);
    result = choice.result;
    if (choice.camera && !result.marks.empty()) {
      const LibraryCamera& camera = cameras.all[*choice.camera];
      picture = Draw(camera.file, camera.shapes, scan, result);
    }
  } catch (const InputError& error) {
    result = {};
    result.findings = {
        {.reason = Reason::kScanUnusable, .at_best = Status::kFailed, .where = error.what()}};
  } catch (const std::exception& error) {
    RethrowOfEnvironment();
    result = {};
    result.findings = {{.reason = Reason::kScanUnusable,
                        .at_best = Status::kFailed,
                        .where = photo + ": could not be processed (" + error.what() + ")"}};
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
std::vector<InteriorResult> EarlierResults(const InteriorRunOptions& options,
                                           const std::vector<Inputs>& inputs) {
  if (inputs.empty()) return {};
  std::set<std::string> known;
  for (const std::string& photo : options.photos) known.insert(PhotoName(photo));
  std::vector<InteriorResult> earlier;
  const ResultStore store = StoreOf(options);
  for (const std::string& photo : store.Jobs()) {
    const auto then = known.contains(photo) ? std::nullopt : store.MadeFrom(photo);
    if (!then || !then->contains("camera") || then->at("camera") != inputs.front().at("camera"))
      continue;
    try {
      earlier.push_back(ReadInteriorResult(store.PathOf(photo)));
    } catch (const InputError&) {  // a damaged one of another run is not this run's business
    }
  }
  return earlier;
}

std::vector<std::string> NotesOn(const InteriorRunOptions& options, const CameraFile* camera,
                                 const std::vector<InteriorResult>& results) {
  std::vector<std::string> notes;
  if (!camera) {
    notes.emplace_back("The photos are not from one camera: no marks.csv" +
                       std::string(options.micmac ? ", no MicMac files" : "") +
                       ", no comparison with one another. Orient each camera's photos separately.");
    return notes;
  }
  const auto open = std::count_if(results.begin(), results.end(), [](const InteriorResult& r) {
    return r.photo_from_pixel && r.possible_orientations.size() > 1;
  });
  if (options.micmac && open > 0)
    notes.push_back(
        "MicMac files: " + std::to_string(open) +
        " photos have an open scan orientation, and their marks carry the names of the first "
        "possible one; give --orientation.");
  return notes;
}

}  // namespace

std::set<std::string> InteriorsThatStay(const InteriorRunOptions& options) {
  return KeptResults(options, InputsOf(options, LoadCameras(options)));
}

std::vector<InteriorResult> RunInterior(const InteriorRunOptions& options,
                                        const std::function<void()>& done,
                                        std::vector<std::string>* notes) {
  RequireOwnNames(options.photos);
  const RunCameras cameras = LoadCameras(options);
  MakeOutputDirectory(options.out);
  const std::vector<Inputs> inputs = InputsOf(options, cameras);
  KeptResults(options, inputs);  // or it refuses, before the work
  const ResultStore store = StoreOf(options);
  std::vector<InteriorResult> results(options.photos.size());
  std::vector<Job> jobs;
  for (size_t i = 0; i < results.size(); ++i)
    jobs.push_back(
        {PhotoName(options.photos[i]), inputs[i],
         [&, i] { results[i] = OrientOne(options, cameras, options.photos[i], inputs[i]); },
         [&, i] { results[i] = ReadInteriorResult(store.PathOf(PhotoName(options.photos[i]))); }});
  RunJobs(jobs, store, {options.jobs, options.resume, true, done});
  const CameraFile* camera = CameraOfRoll(cameras, results);
  WriteInteriorOutputs(options.out, camera, EarlierResults(options, inputs), &results);
  if (options.micmac && camera) WriteMicmacOutputs(options.out, *camera, options.photos, results);
  if (notes) *notes = NotesOn(options, camera, results);
  return results;
}

}  // namespace orient::block
