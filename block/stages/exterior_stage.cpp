#include "block/stages/exterior_stage.h"

#include <filesystem>
#include <map>
#include <mutex>
#include <numeric>

#include "block/inputs/block_camera.h"
#include "block/inputs/block_files.h"
#include "block/inputs/exposure_date.h"
#include "block/stages/exterior_inputs.h"
#include "block/stages/exterior_job.h"
#include "block/stages/exterior_learning.h"
#include "block/stages/jobs.h"
#include "core/base/error.h"
#include "core/base/folder_lock.h"
#include "core/base/output_directory.h"
#include "core/files/adjustment_result.h"
#include "core/files/camera_file.h"
#include "core/files/orientation_table.h"

namespace orient::block {
namespace {
namespace fs = std::filesystem;

// Lets a stand-alone run continue in a folder of its own results like the run that made them.
void GoOnAlone(ExteriorRunOptions* options) {
  options->inputs = InputsOfRun(*options);
  options->keep_unstated = true;
  if (!options->resume) return;
  const ResultStore results = ExteriorStore(options->out);
  const std::vector<std::string> photos = OwnResultsFirst(results, options->photos);
  RequireSameInputs(results, photos, options->inputs);
  if (!options->earth_k1) options->earth_k1 = EarthK1Of(results, photos);
}

// Where each photo asks its neighbours for patches.
class AskedAreas {
 public:
  void Note(const std::string& photo, const Bounds& area) {
    const std::lock_guard<std::mutex> lock(mutex_);
    Bounds& all = areas_.try_emplace(photo, Bounds::OfNothing()).first->second;
    all.Include(area.min_x, area.min_y);
    all.Include(area.max_x, area.max_y);
  }
  std::optional<Bounds> Of(const std::string& photo) {
    const std::lock_guard<std::mutex> lock(mutex_);
    const auto found = areas_.find(photo);
    return found == areas_.end() ? std::nullopt : std::optional(found->second);
  }

 private:
  std::mutex mutex_;
  std::map<std::string, Bounds> areas_;
};

// `asked` outlives the options.
void NoteWhatIsAsked(ExteriorRunOptions* options, AskedAreas* asked) {
  if (!options->further_patches) return;
  options->further_patches = [asked, lent = options->further_patches](const std::string& photo,
                                                                      const Bounds& area) {
    asked->Note(photo, area);
    return lent(photo, area);
  };
}

// Removes an earlier run's files that would not belong to this one's results.
void RemoveStale(const ExteriorRunOptions& options) {
  // Files that a block's run left here hold for other poses.
  fs::remove(AdjustmentResultPath(options.out));
  for (const char* file : {kQuicklookFile, kSeamsFile, kCalibratedCameraFile, kPoseCovarianceFile})
    fs::remove(fs::path(options.out) / file);
  // If this run ends early, its results must not lie beside the table of an earlier run's poses.
  const fs::path table = PoseTablePath(options.out);
  std::error_code ignored;
  if (!fs::equivalent(table, options.approximations, ignored)) fs::remove(table);
  fs::remove(BlockCameraPath(options.out));
}

// The results of a run's photos, in their order.
struct Oriented {
  std::vector<ExteriorResult> results;
  std::vector<char> fresh;  // computed in this run
  std::map<std::string, std::vector<std::string>> changed;
};

// Throws InputError if the result is damaged, or is that of a photo that could not be read: a sound
// file in its place may have the same length and be alike in the pieces that are compared.
ExteriorResult ReadKept(const std::string& folder, const std::string& photo) {
  const std::string path = ExteriorResultPath(folder, photo);
  ExteriorResult result = ReadExteriorResult(path);
  if (Has(result.findings, Reason::kPhotoUnusable))
    throw InputError(path + ": the photo could not be read");
  return result;
}

Job JobOf(const ExteriorSetting& setting, const std::string& path, AskedAreas* asked,
          ExteriorResult* result) {
  const Inputs inputs = InputsOfPhoto(setting.options, setting.approximations, path);
  const auto run = [=, &setting] {
    if (setting.options.leave_to_learn) LeaveToLearn(setting.options.out);
    *result = OrientFromFiles(setting, path);
    result->made_from = inputs;
    result->earth_k1 = setting.earth_k1;
    result->asked_of_neighbours = asked->Of(result->photo);
    WriteExteriorResult(setting.options.out, *result);
  };
  const auto keep = [=, &setting] { *result = ReadKept(setting.options.out, PhotoName(path)); };
  return {PhotoName(path), inputs, run, keep};
}

void RunWave(const ExteriorSetting& setting, const std::vector<std::size_t>& wave,
             AskedAreas* asked, const std::function<void()>& done, Oriented* oriented) {
  const ExteriorRunOptions& options = setting.options;
  const ResultStore store = ExteriorStore(options.out);
  std::vector<Job> jobs;
  for (const std::size_t i : wave)
    jobs.push_back(JobOf(setting, options.photos[i], asked, &oriented->results[i]));
  const auto known =
      RunJobs(jobs, store, {options.jobs, options.resume, options.keep_unstated, done});
  for (std::size_t k = 0; k < wave.size(); ++k) {
    const std::string& photo = jobs[k].name;
    const bool kept = known[k].state == ResultState::kCurrent;
    oriented->fresh[wave[k]] = kept ? 0 : 1;
    if (!known[k].changed.empty()) oriented->changed[photo] = known[k].changed;
  }
}

// Exposure dates: from the table, else the run's options, else a digital photo's file.
std::vector<std::optional<std::string>> DatesOf(const ExteriorSetting& setting) {
  std::vector<std::optional<std::string>> dates;
  for (const std::string& path : setting.options.photos) {
    const OrientationRow* row = setting.approximations.Find(PhotoName(path));
    dates.push_back(row != nullptr && row->date ? row->date : setting.options.date);
    if (!dates.back()) dates.back() = ExposureDate(path, setting.camera.camera.kind);
  }
  return dates;
}

// Throws if the run could not begin.
ExteriorRunOptions CheckedOptions(const ExteriorRunOptions& given) {
  if (const auto wrong = given.Check()) throw UsageError(*wrong);
  RequireOwnNames(given.photos);
  ExteriorRunOptions options = given;
  if (given.inputs.empty()) GoOnAlone(&options);
  return options;
}

}  // namespace

std::set<std::string> ExteriorsThatStay(const ExteriorRunOptions& given) {
  const ExteriorRunOptions options = CheckedOptions(given);
  const ExteriorSetting setting = PrepareExterior(options);
  const ResultStore store = ExteriorStore(options.out);
  std::set<std::string> kept;
  for (std::size_t i = 0; options.resume && i < options.photos.size(); ++i) {
    const std::string name = PhotoName(options.photos[i]);
    const ResultState state =
        store.Check(name, InputsOfPhoto(options, setting.approximations, options.photos[i])).state;
    if (state != ResultState::kCurrent &&
        !(options.keep_unstated && state == ResultState::kUnstated))
      continue;
    try {
      ReadKept(options.out, name);
      kept.insert(name);
    } catch (const InputError&) {  // done again
    }
  }
  return kept;
}

std::vector<ExteriorResult> RunExterior(const ExteriorRunOptions& given,
                                        const std::function<void()>& done,
                                        std::map<std::string, std::vector<std::string>>* changed) {
  ExteriorRunOptions options = CheckedOptions(given);
  AskedAreas asked;
  NoteWhatIsAsked(&options, &asked);
  ExteriorSetting setting = PrepareExterior(options);
  MakeOutputDirectory(options.out);
  std::optional<FolderLock> lock;
  if (options.alone) lock.emplace(options.out, kBlockLock);
  RemoveStale(options);
  std::optional<Learning> learning;
  if (options.learn) learning.emplace(options.patchdb, options.out, options.resume);
  const std::size_t count = options.photos.size();
  Oriented oriented{std::vector<ExteriorResult>(count), std::vector<char>(count, 0), {}};
  auto next = [&, begun = false]() mutable {
    if (options.next_photos) return options.next_photos(oriented.results, &setting.approximations);
    std::vector<std::size_t> all(begun ? 0 : count);
    std::iota(all.begin(), all.end(), std::size_t{0});
    begun = true;
    return all;
  };
  for (std::vector<std::size_t> wave = next(); !wave.empty(); wave = next())
    RunWave(setting, wave, &asked, done, &oriented);
  if (learning) learning->Tell(options.photos, DatesOf(setting), oriented.fresh, &oriented.results);
  WritePoseTable(options.out, oriented.results, setting.crs);
  // Photos with a principal distance of their own have no camera in common.
  if (!options.principal_distance_sigma_mm) WriteBlockCamera(options.out, setting.camera);
  if (changed) *changed = std::move(oriented.changed);
  return std::move(oriented.results);
}

std::string PoseTablePath(const std::string& directory) {
  return (fs::path(directory) / "orientation.csv").string();
}

void WritePoseTable(const std::string& directory, const std::vector<ExteriorResult>& results,
                    const Crs& crs) {
  OrientationTable table;
  table.crs = crs;
  for (const ExteriorResult& result : results)
    if (result.pose)
      table.rows.push_back(
          {result.photo, *result.pose, Vector6d(result.covariance->diagonal().cwiseSqrt())});
  WriteOrientationTable(PoseTablePath(directory), table);
}

}  // namespace orient::block
