#include "tools/commands/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <utility>

#include "tools/console/progress_watcher.h"
#include "tools/console/run_output.h"

namespace orient {
namespace {

constexpr std::chrono::seconds kSilence(2);
constexpr std::chrono::milliseconds kTerminalInterval(200);
constexpr std::chrono::seconds kLogInterval(30);

}  // namespace

std::string ProgressText(const std::string& what, int done, int total, double elapsed_s,
                         double since_step_s) {
  constexpr double kLong_s = 60;
  std::string text = fmt::format("{}  {} of {}", what, done, total);
  if (total > 0) text += fmt::format(", {} %", 100LL * done / total);
  if (done > 0 && done < total)
    text += fmt::format(", {} left", DurationText(elapsed_s * (total - done) / done));
  if (since_step_s >= kLong_s && done < total)
    text += fmt::format(", the next one takes {} already", DurationText(since_step_s));
  return text;
}

ProgressLine::ProgressLine(std::string what, int total)
    : what_(std::move(what)),
      total_(total),
      is_terminal_(isatty(STDERR_FILENO) == 1),
      watch_([this](const std::stop_token& stop) { Watch(stop); }) {}

void ProgressLine::Watch(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  while (!finished_.wait_for(lock, stop, kLogInterval, [] { return false; }) &&
         !stop.stop_requested())
    if (const auto now = Clock::now(); now - last_shown_ >= kLogInterval) Show(now);
}

ProgressLine::~ProgressLine() { Finish(); }

void ProgressLine::Advance(int steps) {
  const std::lock_guard lock(mutex_);
  done_ += steps;
  TellProgress(what_, done_, total_);
  const Clock::time_point now = Clock::now();
  last_step_ = now;
  const auto interval = is_terminal_ ? Clock::duration(kTerminalInterval) : kLogInterval;
  if (now - start_ >= kSilence && now - last_shown_ >= interval) Show(now);
}

void ProgressLine::Show(Clock::time_point now) {
  const auto seconds = [now](Clock::time_point from) {
    return std::chrono::duration<double>(now - from).count();
  };
  const std::string text = ProgressText(what_, done_, total_, seconds(start_), seconds(last_step_));
  last_shown_ = now;
  if (now - last_logged_ >= kLogInterval) {
    LogProgress(text, what_, done_, total_);
    last_logged_ = now;
  }
  if (RunIsQuiet() || ProgressIsWatched()) return;
  if (is_terminal_)
    std::fprintf(stderr, "%s%s", kEraseLine, text.c_str());
  else
    std::fprintf(stderr, "%s\n", text.c_str());
  std::fflush(stderr);
  shown_ = true;
}

void ProgressLine::Finish() {
  watch_.request_stop();
  const std::lock_guard lock(mutex_);
  if (shown_ && is_terminal_) std::fputs(kEraseLine, stderr);
  shown_ = false;
  if (std::exchange(finished_once_, true)) return;
  const std::chrono::duration<double> passed = Clock::now() - start_;
  LogProgress(fmt::format("{}  {} of {} in {}", what_, done_, total_, DurationText(passed.count())),
              what_, done_, total_);
}

}  // namespace orient
