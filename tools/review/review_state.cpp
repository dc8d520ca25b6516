#include "tools/review/review_state.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <vector>

#include "block/inputs/digest.h"
#include "core/files/inputs.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

std::string FilesIn(const std::string& directory) {
  std::vector<std::string> files;
  std::error_code error, ignored;
  for (fs::directory_iterator entry(directory, error), end; !error && entry != end;
       entry.increment(error)) {
    const std::string ending = entry->path().extension().string();
    if (ending != ".json" && ending != ".csv" && ending != ".prj") continue;
    const auto changed = fs::last_write_time(entry->path(), ignored).time_since_epoch().count();
    files.push_back(fmt::format("{} {} {}\n", entry->path().filename().string(),
                                fs::file_size(entry->path(), ignored), changed));
  }
  std::sort(files.begin(), files.end());
  std::string all;
  for (const std::string& file : files) all += file;
  return all;
}

void AddDigest(const Inputs& made_from, const std::string& photo,
               std::map<std::string, std::string>* digests) {
  if (made_from.empty()) return;
  const auto found = made_from.find("measurements");
  (*digests)[photo] = found == made_from.end() ? std::string() : found->second;
}

// A block's final results do not state what they were made from; its exterior stage's do.
Inputs ExteriorInputs(const std::string& directory, const PhotoRecord& photo) {
  const fs::path stage = fs::path(directory) / "stages" / "exterior";
  if (const auto inputs = ReadMadeFrom(ExteriorResultPath(stage.string(), photo.name)))
    return *inputs;
  return photo.exterior ? photo.exterior->made_from : Inputs();
}

std::shared_ptr<const ReviewState> ReadState(const std::string& directory) {
  auto state = std::make_shared<ReviewState>();
  state->block = ReadBlockRecord(directory);
  state->verdict = Judge(state->block);
  for (const PhotoRecord& photo : state->block.photos) {
    if (photo.interior) AddDigest(photo.interior->made_from, photo.name, &state->interior_digests);
    AddDigest(ExteriorInputs(directory, photo), photo.name, &state->exterior_digests);
  }
  return state;
}

bool Differs(const std::map<std::string, std::string>& digests, const std::string& photo,
             const std::string& text) {
  const auto then = digests.find(photo);
  return then != digests.end() && then->second != (text.empty() ? text : block::Digest(text));
}

}  // namespace

const PhotoRecord* ReviewState::Photo(const std::string& name) const {
  const auto found = std::find_if(block.photos.begin(), block.photos.end(),
                                  [&](const PhotoRecord& photo) { return photo.name == name; });
  return found == block.photos.end() ? nullptr : &*found;
}

std::shared_ptr<const ReviewState> ReviewStates::Now() {
  const std::lock_guard lock(mutex_);
  std::string files = FilesIn(directory_);
  if (state_ == nullptr || files != files_) {
    state_ = ReadState(directory_);
    files_ = std::move(files);
  }
  return state_;
}

bool IsPending(const ReviewState& state, const Measurements& measurements,
               const std::string& photo) {
  return Differs(state.interior_digests, photo, TextOfMarks(measurements, photo)) ||
         Differs(state.exterior_digests, photo, TextOfPoints(measurements, photo));
}

}  // namespace orient
