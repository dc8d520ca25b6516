#include "tools/console/progress_watcher.h"

#include <atomic>

namespace orient {
namespace {

std::atomic<ProgressWatcher*> watching = nullptr;

}  // namespace

void WatchProgress(ProgressWatcher* watcher) { watching = watcher; }

bool ProgressIsWatched() { return watching != nullptr; }

void TellProgress(const std::string& task, int done, int total) {
  if (ProgressWatcher* watcher = watching) watcher->OnProgress(task, done, total);
}

}  // namespace orient
