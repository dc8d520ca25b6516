// run(): a command of the program within Python's process.
#include <pybind11/functional.h>
#include <pybind11/stl.h>

#include <chrono>
#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <optional>
#include <sstream>
#include <string>
#include <thread>
#include <tuple>
#include <utility>
#include <vector>

#include "python/native.h"
#include "tools/commands/commands.h"
#include "tools/console/progress_watcher.h"

namespace orient::python {
namespace {
namespace py = pybind11;

// How often the caller's thread looks for Ctrl-C while the command works.
constexpr std::chrono::milliseconds kLook(100);

struct Step {
  std::string task;
  int done, total;
};

// Takes the steps from the threads that work to the one that called, where Python is.
class Steps : public ProgressWatcher {
 public:
  Steps() { WatchProgress(this); }
  ~Steps() override { WatchProgress(nullptr); }
  Steps(const Steps&) = delete;
  Steps& operator=(const Steps&) = delete;

  void OnProgress(const std::string& task, int done, int total) override {
    const std::lock_guard lock(mutex_);
    if (stop_) throw Stopped();
    steps_.push_back({task, done, total});
    changed_.notify_one();
  }
  // The command ends at its next step.
  void Stop() {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  void End() {
    const std::lock_guard lock(mutex_);
    ended_ = true;
    changed_.notify_one();
  }
  // Waits a little; empty where nothing was heard.
  std::optional<Step> Next() {
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, kLook, [this] { return ended_ || !steps_.empty(); });
    if (steps_.empty()) return std::nullopt;
    Step step = std::move(steps_.front());
    steps_.pop_front();
    return step;
  }
  bool Ended() {
    const std::lock_guard lock(mutex_);
    return ended_ && steps_.empty();
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Step> steps_;
  bool stop_ = false, ended_ = false;
};

// A run's output is the process's: one run at a time.
std::mutex running;

using Progress = std::function<void(const std::string& task, int done, int total)>;

// Tells the caller what is heard. What its function throws, and Ctrl-C, end the command and come
// out here when it has ended.
void TellUntilEnded(Steps* steps, const std::optional<Progress>& progress) {
  std::exception_ptr thrown;
  while (!steps->Ended()) {
    const std::optional<Step> step = steps->Next();
    const py::gil_scoped_acquire python;
    try {
      if (PyErr_CheckSignals() != 0) throw py::error_already_set();
      if (step && progress && !thrown) (*progress)(step->task, step->done, step->total);
    } catch (py::error_already_set&) {
      if (!thrown) thrown = std::current_exception();
      steps->Stop();
    }
  }
  if (!thrown) return;
  const py::gil_scoped_acquire python;
  std::rethrow_exception(thrown);
}

// Exit code, standard output, messages.
std::tuple<int, std::string, std::string> Run(const std::vector<std::string>& arguments,
                                              const std::optional<Progress>& progress) {
  std::ostringstream out, err;
  int code = 0;
  {
    const py::gil_scoped_release others_may_run;
    const std::unique_lock lock(running, std::try_to_lock);
    if (!lock) {
      const py::gil_scoped_acquire python;
      throw std::runtime_error("another command of orient is running in this process");
    }
    Steps steps;
    std::jthread work([&] {
      code = RunProgram(MakeCommands(), arguments, out, err);
      steps.End();
    });
    TellUntilEnded(&steps, progress);
  }
  return {code, out.str(), err.str()};
}

}  // namespace

void AddRuns(py::module_& m) {
  m.def("run", &Run, py::arg("arguments"), py::arg("progress") = py::none());
}

}  // namespace orient::python
