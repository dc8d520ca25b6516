#include "block/part.h"

#include <algorithm>
#include <charconv>
#include <chrono>
#include <filesystem>

#include "block/stages/exterior_inputs.h"
#include "block/stages/exterior_stage.h"
#include "block/stages/interior_stage.h"
#include "core/base/error.h"
#include "core/files/orientation_table.h"
#include "core/files/results.h"

namespace orient::block {
namespace {
namespace fs = std::filesystem;

std::size_t CountOf(const PhotosOfPart& part, std::size_t photos) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < photos; ++i) count += part.Has(i) ? 1 : 0;
  return count;
}

template <typename Result>
PartOutcome OutcomeOf(const std::vector<Result>& results, std::size_t of_part) {
  PartOutcome outcome;
  for (const Result& result : results) {
    if (result.photo.empty()) continue;
    ++outcome.done;
    outcome.failed += result.status == Status::kFailed ? 1 : 0;
  }
  outcome.left = of_part - outcome.done;
  return outcome;
}

PartOutcome RunInteriorPart(const BlockInputs& inputs, const PhotosOfPart& part,
                            ProgressListener* listener) {
  InteriorRunOptions options = inputs.Interior();
  options.resume = true;
  options.results_only = !part.IsAll();
  std::vector<std::string> photos;
  for (std::size_t i = 0; i < options.photos.size(); ++i)
    if (part.Has(i)) photos.push_back(options.photos[i]);
  options.photos = photos;
  ProgressTask progress(listener, "interior orientation", static_cast<int>(photos.size()));
  return OutcomeOf(RunInterior(options, [&] { progress.Advance(); }), photos.size());
}

void RequireInteriors(const BlockInputs& inputs, const PhotosOfPart& part) {
  const std::vector<std::string>& photos = inputs.Block().photos;
  for (std::size_t i = 0; inputs.IsFilm() && i < photos.size(); ++i) {
    const std::string result =
        ResultPathOf(BlockStage::kInterior, inputs.OutputDirectory(), PhotoName(photos[i]));
    if (part.Has(i) && !fs::exists(result))
      throw UsageError(result +
                       " is not there: run --stage interior first, all parts of it and "
                       "then once without --part");
  }
}

// Reads other parts' results if they help to locate this part's photos.
void ReadOthers(const BlockInputs& inputs, const ResultStore& store, const PhotosOfPart& part,
                std::vector<ExteriorResult>* results) {
  const std::vector<std::string>& photos = inputs.Block().photos;
  for (std::size_t i = 0; i < photos.size(); ++i) {
    if (part.Has(i)) continue;
    const std::string name = PhotoName(photos[i]);
    if (inputs.Block().flight.Empty()) {
      (*results)[i].photo = name;
      continue;
    }
    try {
      if (fs::exists(store.PathOf(name))) (*results)[i] = ReadExteriorResult(store.PathOf(name));
    } catch (const InputError&) {  // damaged: its own part recreates it
    }
  }
}

PartOutcome RunExteriorPart(const BlockInputs& inputs, const BlockFolder& folder,
                            const PhotosOfPart& part, ProgressListener* listener) {
  RequireInteriors(inputs, part);
  const ResultStore store = ExteriorStore(folder.StageDirectory("exterior"));
  ExteriorRunOptions options = inputs.Exterior(store.Folder());
  options.resume = true;
  options.learn = false;
  options.leave_to_learn = true;
  options.next_photos = [&](const std::vector<ExteriorResult>& so_far, OrientationTable* table) {
    std::vector<ExteriorResult> known = so_far;
    ReadOthers(inputs, store, part, &known);
    std::vector<std::size_t> next = NextPhotos(inputs, known);
    std::erase_if(next, [&](std::size_t photo) { return !part.Has(photo); });
    *table = inputs.Approximations().Table();
    return next;
  };
  const std::size_t of_part = CountOf(part, options.photos.size());
  ProgressTask progress(listener, "exterior orientation", static_cast<int>(of_part));
  return OutcomeOf(RunExterior(options, [&] { progress.Advance(); }), of_part);
}

// Counts the status in a result file.
template <typename Result>
void Count(const std::string& path, Result (*read)(const std::string&), StageStatus* status) {
  try {
    const Status found = read(path).status;
    status->ok += found == Status::kOk ? 1 : 0;
    status->weak += found == Status::kWeak ? 1 : 0;
    status->failed += found == Status::kFailed ? 1 : 0;
  } catch (const InputError&) {
    ++status->unreadable;
  }
}

// Files per hour from the files' times within the hour before the newest one.
std::optional<double> PerHour(std::vector<fs::file_time_type> times) {
  constexpr std::size_t kFewest = 3;
  if (times.size() < kFewest) return std::nullopt;
  std::sort(times.rbegin(), times.rend());
  const auto since = times.front() - std::chrono::hours(1);
  const auto last = std::find_if(times.begin(), times.end(), [&](auto t) { return t < since; });
  const auto count = last - times.begin();
  const std::chrono::duration<double> span = times.front() - *(last - 1);
  if (count < static_cast<std::ptrdiff_t>(kFewest) || span.count() <= 0) return std::nullopt;
  return 3600 * static_cast<double>(count - 1) / span.count();
}

}  // namespace

std::string Name(BlockStage stage) {
  return stage == BlockStage::kInterior ? "interior" : "exterior";
}

std::string ResultPathOf(BlockStage stage, const std::string& directory, const std::string& photo) {
  return stage == BlockStage::kInterior
             ? InteriorResultPath(directory, photo)
             : ExteriorResultPath(StageDirectory(directory, "exterior"), photo);
}

std::optional<PhotosOfPart> PhotosOfPartFromText(const std::string& text) {
  PhotosOfPart part;
  const char* end = text.data() + text.size();
  const auto first = std::from_chars(text.data(), end, part.number);
  if (first.ec != std::errc() || first.ptr == end || *first.ptr != '/') return std::nullopt;
  const auto second = std::from_chars(first.ptr + 1, end, part.of);
  if (second.ec != std::errc() || second.ptr != end) return std::nullopt;
  if (part.number < 1 || part.number > part.of) return std::nullopt;
  return part;
}

PartOutcome RunPart(const BlockInputs& inputs, const BlockFolder& folder, BlockStage stage,
                    const PhotosOfPart& part, ProgressListener* listener) {
  if (stage == BlockStage::kExterior) return RunExteriorPart(inputs, folder, part, listener);
  return inputs.IsFilm() ? RunInteriorPart(inputs, part, listener) : PartOutcome();
}

std::vector<StageStatus> StatusOf(const std::vector<std::string>& photos,
                                  const std::string& directory, bool film) {
  std::vector<StageStatus> all;
  for (const BlockStage stage : kBlockStages) {
    if (stage == BlockStage::kInterior && !film) continue;
    StageStatus status;
    status.stage = stage;
    status.photos = photos.size();
    std::vector<fs::file_time_type> times;
    for (const std::string& photo : photos) {
      const std::string path = ResultPathOf(stage, directory, PhotoName(photo));
      std::error_code absent;
      const auto time = fs::last_write_time(path, absent);
      if (absent) continue;
      times.push_back(time);
      if (stage == BlockStage::kInterior)
        Count(path, &ReadInteriorResult, &status);
      else
        Count(path, &ReadExteriorResult, &status);
    }
    status.per_hour = PerHour(std::move(times));
    all.push_back(status);
  }
  return all;
}

}  // namespace orient::block
