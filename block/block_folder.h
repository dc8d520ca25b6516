// The output folder of a block while a run works in it.
#pragma once

#include <optional>
#include <string>

#include "core/base/folder_lock.h"

namespace orient::block {

class BlockFolder {
 public:
  // Makes the folder, locks it, clears away what killed runs left half-written, and marks it as
  // unfinished. Without `resume` the results of all stages are discarded. Throws InputError if it
  // cannot be created or another program is using it.
  BlockFolder(std::string directory, bool resume);

  // For one of several runs that each do a part: they share the folder, and nothing is discarded.
  explicit BlockFolder(std::string directory);

  const std::string& Directory() const { return directory_; }
  // Where a stage keeps its results ("exterior", "ties").
  std::string StageDirectory(const std::string& stage) const;
  // The run is complete, and all its files are written.
  void Finish() const;

 private:
  void MarkUnfinished() const;

  std::string directory_;
  FolderLock lock_;
};

std::string StageDirectory(const std::string& block_directory, const std::string& stage);

// Whether a run into this folder was interrupted before its end.
bool IsUnfinished(const std::string& block_directory);
// A sentence for those who use results of such a run; none otherwise.
std::optional<std::string> UnfinishedNote(const std::string& block_directory);

}  // namespace orient::block
