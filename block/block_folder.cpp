#include "block/block_folder.h"

#include <filesystem>
#include <utility>
#include <vector>

#include "block/inputs/block_files.h"
#include "core/base/atomic_write.h"
#include "core/base/output_directory.h"
#include "core/base/partial_files.h"

namespace orient::block {
namespace {
namespace fs = std::filesystem;

std::string UnfinishedPath(const std::string& out) { return StageDirectory(out, "unfinished"); }

// Only in the folders that belong to a run: the output folder and its stage folders.
void RemovePartialFilesOfKilledRuns(const std::string& out) {
  RemovePartialFiles(out);
  RemovePartialFiles(StageDirectory(out, ""));
  // Unreadable folders and entries removed meanwhile must not end the traversal with an exception.
  std::vector<std::string> folders;
  std::error_code error, ignored;
  for (fs::recursive_directory_iterator
           entry(StageDirectory(out, ""), fs::directory_options::skip_permission_denied, error),
       end;
       !error && entry != end; entry.increment(error))
    if (entry->is_directory(ignored)) folders.push_back(entry->path().string());
  for (const std::string& folder : folders) RemovePartialFiles(folder);
}

std::string Made(std::string directory) {
  MakeOutputDirectory(directory);
  return directory;
}

}  // namespace

std::string StageDirectory(const std::string& block_directory, const std::string& stage) {
  return (fs::path(block_directory) / "stages" / stage).string();
}

BlockFolder::BlockFolder(std::string directory, bool resume)
    : directory_(Made(std::move(directory))), lock_(directory_, kBlockLock) {
  RemovePartialFilesOfKilledRuns(directory_);
  if (!resume) fs::remove_all(fs::path(directory_) / "stages");
  MarkUnfinished();
}

BlockFolder::BlockFolder(std::string directory)
    : directory_(Made(std::move(directory))),
      lock_(directory_, kBlockLock, FolderLock::Mode::kShared) {
  MarkUnfinished();
}

void BlockFolder::MarkUnfinished() const {
  MakeOutputDirectory(StageDirectory(""));
  if (!IsUnfinished(directory_))
    WriteFileAtomically(UnfinishedPath(directory_), "continue the interrupted run with --resume\n");
}

std::string BlockFolder::StageDirectory(const std::string& stage) const {
  return block::StageDirectory(directory_, stage);
}

void BlockFolder::Finish() const { fs::remove(UnfinishedPath(directory_)); }

bool IsUnfinished(const std::string& block_directory) {
  std::error_code ignored;
  return fs::exists(UnfinishedPath(block_directory), ignored);
}

std::optional<std::string> UnfinishedNote(const std::string& block_directory) {
  if (!IsUnfinished(block_directory)) return std::nullopt;
  return "the last run into " + block_directory +
         " has not ended: its results may be those of an earlier one; continue it with --resume";
}

}  // namespace orient::block
