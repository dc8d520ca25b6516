#include "block/stages/interior_stage.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <set>

#include "block/inputs/block_files.h"
#include "block/inputs/camera_library.h"
#include "block/inputs/digest.h"
#include "block/inputs/mark_shapes.h"
#include "block/inputs/measurement_inputs.h"
#include "block/pictures/scan_overview.h"
#include "block/roll/roll_orientation.h"
#include "block/stages/interior_outputs.h"
#include "block/stages/jobs.h"
#include "core/base/environment_error.h"
#include "core/base/error.h"
#include "core/base/folder_lock.h"
#include "core/base/output_directory.h"
#include "core/files/orientation_table.h"
#include "interior/camera_choice.h"
#include "interior/marks/mark_picture.h"

namespace orient::block {
namespace {
namespace fs = std::filesystem;

// How far around a mark its picture reaches.
double PictureReach(const interior::MarkShapes& shapes) {
  double radius = 0;
  for (const auto& [name, shape] : shapes) radius = std::max(radius, MarkRadius(shape));
  return 1.6 * radius;
}

interior::Picture Draw(const CameraFile& camera, const interior::MarkShapes& shapes,
                       const Raster& scan, const InteriorResult& result) {
  std::vector<Eigen::Vector2d> positions;
  for (const Fiducial& f : camera.fiducials) positions.push_back(f.position_mm);
  // 0.1 mm only if the pixel size is unknown: then there is no transform either.
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
    std::erase_if(cameras.all, [](const LibraryCamera& camera) {
      return camera.format_only || camera.file.fiducials.empty();
    });
    return cameras;
  }
  LibraryCamera camera;
  camera.file = ReadCameraFile(options.camera);
  camera.shapes = LoadMarkShapes(camera.file);
  cameras.all.push_back(std::move(camera));
  cameras.named = true;
  return cameras;
}

// The camera of the run, or the one that a person named for this photo.
std::optional<size_t> NamedCamera(const RunCameras& cameras, const Decision* decided) {
  if (cameras.named) return 0;
  if (!decided) return std::nullopt;
  const auto found = std::find_if(cameras.all.begin(), cameras.all.end(),
                                  [&](const auto& c) { return c.name == decided->value; });
  return found - cameras.all.begin();
}

interior::CameraChoice Orient(const Raster& scan, const RunCameras& cameras,
                              std::optional<size_t> named,
                              const interior::InteriorOptions& options) {
  if (named) {
    const LibraryCamera& camera = cameras.all[*named];
    return {interior::OrientInterior(scan, camera.file, camera.shapes, options), named};
  }
  std::vector<interior::KnownCamera> known;
  for (const LibraryCamera& camera : cameras.all)
    known.push_back({camera.name, &camera.file, &camera.shapes});
  return interior::OrientWithUnknownCamera(scan, known, options);
}

// The camera of all photos: the one that was named, or one that fits them all. Null if there is
// none.
const LibraryCamera* CameraOfRoll(const RunCameras& cameras,
                                  const std::vector<InteriorResult>& results) {
  if (cameras.named) return &cameras.all.front();
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
  return found == cameras.all.end() ? nullptr : &*found;
}

// Whether a person's decision names this camera, by its library name or the path of its file.
bool NamesCamera(const std::string& decided, const std::string& camera) {
  return decided == camera || decided == fs::path(camera).stem().string();
}

ResultStore StoreOf(const InteriorRunOptions& options) { return {options.out, ".interior.json"}; }

// Throws InputError if the result is damaged, or is that of a scan that could not be read: a sound
// scan in its place may have the same length and be alike in the pieces that are compared.
InteriorResult ReadKept(const InteriorRunOptions& options, const std::string& photo) {
  const std::string path = StoreOf(options).PathOf(photo);
  InteriorResult result = ReadInteriorResult(path);
  if (Has(result.findings, Reason::kScanUnusable))
    throw InputError(path + ": the scan could not be read");
  return result;
}

// One per photo; they differ in the scan only. A scan that cannot be read now counts as unchanged
// if there is a result to be kept.
std::vector<Inputs> InputsOf(const InteriorRunOptions& options, const RunCameras& cameras) {
  Inputs all;
  for (const LibraryCamera& camera : cameras.all) all[camera.name] = DigestOfCamera(camera.file);
  std::vector<Inputs> inputs(
      options.photos.size(),
      {{"camera", DigestOf(all)}, {"options", DigestOfOptions(options.scan)}, {"scan", ""}});
  for (size_t i = 0; i < inputs.size(); ++i) {
    inputs[i]["scan"] = DigestOfFile(options.photos[i]);
    AddMeasurements(TextOfMarks(options.measurements, PhotoName(options.photos[i])), &inputs[i]);
    if (!options.resume || !inputs[i]["scan"].empty()) continue;
    const auto then = StoreOf(options).MadeFrom(PhotoName(options.photos[i]));
    if (then && WhatChanged(*then, inputs[i]) == std::vector<std::string>{"scan"})
      inputs[i] = *then;
  }
  return inputs;
}

// The photos with results to be kept. Throws UsageError if one was made from other inputs and is
// not to be computed again; a person's new statements always cause that.
std::set<std::string> KeptResults(const InteriorRunOptions& options,
                                  const std::vector<Inputs>& inputs) {
  std::set<std::string> kept;
  const ResultStore store = StoreOf(options);
  for (size_t i = 0; options.resume && i < inputs.size(); ++i) {
    const std::string name = PhotoName(options.photos[i]);
    const KnownResult known = store.Check(name, inputs[i]);
    if (known.state == ResultState::kCurrent || known.state == ResultState::kUnstated)
      kept.insert(name);
    const bool said = known.changed == std::vector<std::string>{"measurements"};
    if (known.state == ResultState::kChanged && !said && !options.redo_changed)
      throw UsageError(store.PathOf(name) + " was made from other inputs (" +
                       TextOfInputs(known.changed) +
                       "); choose another folder, or --overwrite to do all photos again");
  }
  return kept;
}

// Writes pictures of the marks and, if the photo is not ok, the scan. A failure is only reported.
void WritePictures(const InteriorRunOptions& options, const std::optional<Raster>& scan,
                   const std::optional<interior::Picture>& marks, InteriorResult* result) {
  const auto path = [&](const char* ending) {
    return (fs::path(options.out) / (result->photo + ending)).string();
  };
  std::error_code ignored;
  for (const char* ending : {".marks.png", kMarksOverview})
    fs::remove(path(ending), ignored);  // of an earlier run
  try {
    if (marks) WritePng(path(".marks.png"), marks->width, marks->height, 3, marks->rgb);
    if (scan && result->status != Status::kOk)
      WriteScanOverview(path(kMarksOverview), *scan, OverviewOf(*result));
  } catch (const InputError& error) {
    result->findings.push_back({.reason = Reason::kPictureNotWritten, .where = error.what()});
  }
}

// Any error caused by a scan fails this photo only; a result that cannot be written ends
// the run.
InteriorResult OrientOne(const InteriorRunOptions& options, const RunCameras& cameras,
                         const std::string& photo, const Inputs& inputs) {
  const std::string name = PhotoName(photo);
  InteriorResult result;
  std::optional<Raster> scan;
  std::optional<interior::Picture> picture;
  try {
    scan = Raster::OpenScan(photo);
    const Decision* decided = options.measurements.DecisionOn(name, DecisionKind::kCamera);
    const interior::CameraChoice choice =
        Orient(*scan, cameras, NamedCamera(cameras, decided),
               WithMarksOf(options.measurements, name, options.scan));
    result = choice.result;
    if (decided && !cameras.named) result.cameras = {decided->value};
    if (choice.camera && !result.marks.empty()) {
      const LibraryCamera& camera = cameras.all[*choice.camera];
      picture = Draw(camera.file, camera.shapes, *scan, result);
    }
  } catch (const InputError& error) {
    result = {};
    result.findings = {
        {.reason = Reason::kScanUnusable, .at_best = Status::kFailed, .where = error.what()}};
  } catch (const std::exception& error) {
    RethrowIfMachineFault();
    result = {};
    result.findings = {{.reason = Reason::kScanUnusable,
                        .at_best = Status::kFailed,
                        .where = photo + ": could not be processed (" + error.what() + ")"}};
  }
  result.photo = name;
  ApplyVerdict(options.measurements, &result);
  result.made_from = inputs;
  WritePictures(options, scan, picture, &result);
  WriteInteriorResult(options.out, result);
  return result;
}

// Results of earlier runs into this folder with the same camera: the tables keep their rows.
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
    } catch (const InputError&) {  // a damaged result of another run does not concern this run
    }
  }
  return earlier;
}

// Throws UsageError if the folder has tables that belong neither to these photos nor to `earlier`.
void RefuseOthersTables(const InteriorRunOptions& options,
                        const std::vector<InteriorResult>& earlier) {
  const ResultStore store = StoreOf(options);
  const auto exists = [](const fs::path& path) { return fs::exists(fs::symlink_status(path)); };
  const bool own =
      std::any_of(options.photos.begin(), options.photos.end(),
                  [&](const auto& photo) { return exists(store.PathOf(PhotoName(photo))); });
  if (own || !earlier.empty()) return;
  for (const char* file : {kInteriorTable, kMarkTable, "contact_sheet.png"})
    if (const fs::path path = fs::path(options.out) / file; exists(path))
      throw UsageError(path.string() +
                       " exists already, without results of these photos or this camera beside it; "
                       "choose another folder or give --overwrite");
}

// Throws UsageError where what a person said of a photo does not go with the run's camera,
// InputError for marks that the camera does not have.
void RequireKnownCameras(const InteriorRunOptions& options, const RunCameras& cameras) {
  for (const std::string& path : options.photos) {
    const std::string photo = PhotoName(path);
    const Decision* decided = options.measurements.DecisionOn(photo, DecisionKind::kCamera);
    const std::string files = options.measurements.folder;
    if (decided && cameras.named && !NamesCamera(decided->value, options.camera))
      throw UsageError(fmt::format(
          "{} assigns photo {} to camera {}, but this run is for {}; orient it in a run of its "
          "own",
          files, photo, decided->value, options.camera));
    if (decided && !cameras.named && NamedCamera(cameras, decided) == cameras.all.size())
      throw UsageError(fmt::format(
          "{} assigns photo {} to camera {}, which is not in the camera library; use one of the "
          "names that 'orient cameras' lists",
          files, photo, decided->value));
    if (!decided && !cameras.named && !options.measurements.MarksOf(photo).empty())
      throw UsageError(fmt::format(
          "marks of photo {} are clicked in {}, but its camera is to be identified; name it with "
          "--camera, or state the photo's camera in decisions.csv",
          photo, files));
    if (const auto named = NamedCamera(cameras, decided))
      RequireKnownMarks(options.measurements, photo, cameras.all[*named].file);
  }
}

bool IsOpen(const InteriorResult& result) {
  return result.photo_from_pixel && result.possible_orientations.size() > 1;
}

// Whether marks would be named by different scan orientations although some photos' are open.
bool MixesOrientations(const std::vector<InteriorResult>& results) {
  std::set<ScanOrientation> named;
  for (const InteriorResult& result : results)
    if (result.photo_from_pixel && !result.possible_orientations.empty())
      named.insert(result.possible_orientations.front());
  return named.size() > 1 && std::any_of(results.begin(), results.end(), IsOpen);
}

std::vector<std::string> NotesOn(const InteriorRunOptions& options, bool one_camera,
                                 const std::vector<InteriorResult>& results) {
  std::vector<std::string> notes;
  if (!one_camera) {
    notes.emplace_back("No one camera was found to fit all photos: no marks.csv" +
                       std::string(options.micmac ? ", no MicMac files" : "") +
                       ", no comparison with one another. Orient each camera's photos separately, "
                       "or name the camera (--camera; in a block file camera).");
    return notes;
  }
  const auto open = std::count_if(results.begin(), results.end(), IsOpen);
  if (open == 0) return notes;
  notes.push_back("The scan orientation of " + std::to_string(open) +
                  " photos is open: the transforms in their result files are those of the first "
                  "possible one. Exterior orientation tries them all; --orientation settles it.");
  if (options.micmac)
    notes.emplace_back(MixesOrientations(results)
                           ? "No MicMac files: photos whose scan orientation is open may be "
                             "turned differently from the others, and marks would be misnamed; "
                             "give --orientation."
                           : "MicMac files: where the scan orientation is open, marks carry the "
                             "names of the first possible one, the same for all photos.");
  return notes;
}

// What a run knows before the first photo.
struct PreparedRun {
  RunCameras cameras;
  std::vector<Inputs> inputs;  // per photo
  std::set<std::string> kept;  // photos
};

PreparedRun Prepare(const InteriorRunOptions& options) {
  RequireOwnNames(options.photos);
  PreparedRun run;
  run.cameras = LoadCameras(options);
  RequireKnownCameras(options, run.cameras);
  run.inputs = InputsOf(options, run.cameras);
  run.kept = KeptResults(options, run.inputs);
  if (!options.redo_changed) RefuseOthersTables(options, EarlierResults(options, run.inputs));
  return run;
}

}  // namespace

std::set<std::string> InteriorsThatStay(const InteriorRunOptions& options) {
  std::set<std::string> kept = Prepare(options).kept;
  std::erase_if(kept, [&](const std::string& photo) {
    try {
      ReadKept(options, photo);
      return false;
    } catch (const InputError&) {  // done again
      return true;
    }
  });
  return kept;
}

std::vector<InteriorResult> RunInterior(const InteriorRunOptions& options,
                                        const std::function<void()>& done,
                                        std::vector<std::string>* notes) {
  const PreparedRun prepared = Prepare(options);
  const RunCameras& cameras = prepared.cameras;
  const std::vector<Inputs>& inputs = prepared.inputs;
  MakeOutputDirectory(options.out);
  std::optional<FolderLock> lock;
  if (options.alone) lock.emplace(options.out, kBlockLock);
  const ResultStore store = StoreOf(options);
  std::vector<InteriorResult> results(options.photos.size());
  std::vector<Job> jobs;
  for (size_t i = 0; i < results.size(); ++i)
    jobs.push_back(
        {PhotoName(options.photos[i]), inputs[i],
         [&, i] { results[i] = OrientOne(options, cameras, options.photos[i], inputs[i]); },
         [&, i] { results[i] = ReadKept(options, PhotoName(options.photos[i])); }});
  RunJobs(jobs, store, {options.jobs, options.resume, true, done});
  if (options.results_only) return results;
  const LibraryCamera* camera = CameraOfRoll(cameras, results);
  if (camera)
    for (const size_t i :
         OrientAsRoll(camera->file, camera->shapes, options.roll_lies_alike, &results))
      WriteInteriorResult(options.out, results[i]);
  WriteInteriorOutputs(options.out, camera ? &camera->file : nullptr,
                       EarlierResults(options, inputs), &results);
  if (options.micmac && camera && !MixesOrientations(results))
    WriteMicmacOutputs(options.out, camera->file, options.photos, results);
  if (notes) *notes = NotesOn(options, camera != nullptr, results);
  return results;
}

}  // namespace orient::block
