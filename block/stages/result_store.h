// The results of a stage: a file per job, each saying what it was made from (core/files/inputs.h).
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/files/inputs.h"

namespace orient::block {

enum class ResultState {
  kAbsent,
  kCurrent,     // made from the current inputs
  kChanged,     // made from others
  kUnstated,    // does not state what it was made from: another program's, or a block's final one
  kUnreadable,  // damaged
};

struct KnownResult {
  ResultState state = ResultState::kAbsent;
  std::vector<std::string> changed;  // names of inputs, of kChanged alone
};

// The single place that decides whether a result exists, what it was made from and what has changed
// since. It writes no results: the jobs do (jobs.h). A result that is not current does not count.
class ResultStore {
 public:
  // `suffix` of the files' names: ".exterior.json", ".ties.json". The folder need not be there.
  ResultStore(std::string folder, std::string suffix)
      : folder_(std::move(folder)), suffix_(std::move(suffix)) {}

  const std::string& Folder() const { return folder_; }
  // <folder>/<job><suffix>
  std::string PathOf(const std::string& job) const;
  // The jobs that have a file, sorted; none where the folder cannot be listed.
  std::vector<std::string> Jobs() const;
  // Empty where the result is absent or unreadable; no inputs where it does not say.
  std::optional<Inputs> MadeFrom(const std::string& job) const;
  KnownResult Check(const std::string& job, const Inputs& now) const;
  bool IsCurrent(const std::string& job, const Inputs& now) const {
    return Check(job, now).state == ResultState::kCurrent;
  }
  // Never an error: what cannot be removed cannot be replaced either, and that is reported then.
  void Drop(const std::string& job) const;

 private:
  std::string folder_, suffix_;
};

}  // namespace orient::block
