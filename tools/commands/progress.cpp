#include "tools/progress.h"

#include <unistd.h>

#include <cmath>
#include <cstdio>

namespace orient {
namespace {

constexpr std::chrono::seconds kSilence(2);
constexpr std::chrono::milliseconds kTerminalInterval(200);
constexpr std::chrono::seconds kLogInterval(30);
constexpr const char* kEraseLine = "\r\033[K";

std::string DurationText(double seconds) {
  const long whole = std::lround(seconds);
  if (whole >= 3600)
    return std::to_string(whole / 3600) + " h " + std::to_string(whole % 3600 / 60) + " min";
  if (whole >= 60) return std::to_string(whole / 60) + " min " + std::to_string(whole % 60) + " s";
  return std::to_string(whole) + " s";
}

}  // namespace

std::string ProgressText(const std::string& what, int done, int total, double elapsed_s) {
  std::string text = what + "  " + std::to_string(done) + " of " + std::to_string(total);
  if (total > 0) text += ", " + std::to_string(100LL * done / total) + " %";
  if (done > 0 && done < total)
    text += ", " + DurationText(elapsed_s * (total - done) / done) + " left";
  return text;
}

Progress::Progress(std::string what, int total)
    : what_(std::move(what)), total_(total), is_terminal_(isatty(STDERR_FILENO) == 1) {}

Progress::~Progress() { Finish(); }

void Progress::Advance(int steps) {
  const std::lock_guard lock(mutex_);
  done_ += steps;
  const Clock::time_point now = Clock::now();
  const auto interval = is_terminal_ ? Clock::duration(kTerminalInterval) : kLogInterval;
  if (now - start_ >= kSilence && now - last_shown_ >= interval) Show(now);
}

void Progress::Show(Clock::time_point now) {
  const double elapsed_s = std::chrono::duration<double>(now - start_).count();
  const std::string text = ProgressText(what_, done_, total_, elapsed_s);
  if (is_terminal_)
    std::fprintf(stderr, "%s%s", kEraseLine, text.c_str());
  else
    std::fprintf(stderr, "%s\n", text.c_str());
  std::fflush(stderr);
  shown_ = true;
  last_shown_ = now;
}

void Progress::Finish() {
  const std::lock_guard lock(mutex_);
  if (shown_ && is_terminal_) std::fputs(kEraseLine, stderr);
  shown_ = false;
}

}  // namespace orient
