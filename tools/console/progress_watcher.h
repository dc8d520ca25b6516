// Receives the progress of a run's tasks in place of the terminal: for a program that embeds
// Orient.
#pragma once

#include <exception>
#include <string>

namespace orient {

// What a watcher throws to end the run.
struct Stopped : std::exception {
  const char* what() const noexcept override { return "stopped"; }
};

class ProgressWatcher {
 public:
  virtual ~ProgressWatcher() = default;
  // "interior orientation", photos; from several threads, one at a time for a task. What it throws
  // ends the run: what is finished is kept, what is not stays to be done.
  virtual void OnProgress(const std::string& task, int done, int total) = 0;
};

// From now on, in place of the terminal; null: nobody. Like the run's output this is the process's.
void WatchProgress(ProgressWatcher* watcher);
bool ProgressIsWatched();
void TellProgress(const std::string& task, int done, int total);

}  // namespace orient
