// One line on the error stream that says how far a long run is and how long it still takes.
#pragma once

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>

#include "core/base/progress.h"

namespace orient {

// Silent for the first two seconds. On a terminal one line is rewritten; elsewhere (a log) a line
// appears every half minute, also where nothing has advanced: then it says for how long. Safe to
// advance from several threads. The line is taken away by Finish() or at the end of life. A log
// (--log) has a line every half minute and one at the end; with --quiet nothing is shown.
class ProgressLine {
 public:
  ProgressLine(std::string what, int total);  // "interior orientation", photos
  ~ProgressLine();
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

  void Advance(int steps = 1);
  void Finish();

 private:
  using Clock = std::chrono::steady_clock;
  void Show(Clock::time_point now);
  void Watch(const std::stop_token& stop);

  std::string what_;
  int total_;
  int done_ = 0;
  bool is_terminal_;
  bool shown_ = false;
  bool finished_once_ = false;
  Clock::time_point start_ = Clock::now();
  Clock::time_point last_shown_ = start_;
  Clock::time_point last_logged_ = start_;
  Clock::time_point last_step_ = start_;
  std::mutex mutex_;
  std::condition_variable_any finished_;
  std::jthread watch_;
};

// A line for each task of a run.
class ShownProgress : public ProgressListener {
 public:
  void Begin(const std::string& task, int total) override { line_.emplace(task, total); }
  void Advance(int steps) override { line_->Advance(steps); }
  void End() override { line_.reset(); }

 private:
  std::optional<ProgressLine> line_;
};

// "interior orientation  12 of 40, 30 %, 2 min 5 s left". Without a step done no time is known.
// After a minute without one: ", the next one takes 1 min 30 s already".
std::string ProgressText(const std::string& what, int done, int total, double elapsed_s,
                         double since_step_s = 0);

}  // namespace orient
