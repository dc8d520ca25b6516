#include "tools/commands/progress.h"

#include <fmt/format.h>
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
  if (whole >= 3600) return fmt::format("{} h {} min", whole / 3600, whole % 3600 / 60);
  if (whole >= 60) return fmt::format("{} min {} s", whole / 60, whole % 60);
  return std::to_string(whole) + " s";
}

}  // namespace

std::string ProgressText(const std::string& what, int done, int total, double elapsed_s) {
  std::string text = fmt::format("{}  {} of {}", what, done, total);
  if (total > 0) text += fmt::format(", {} %", 100LL * done / total);
  if (done > 0 && done < total)
    text += fmt::format(", {} left", DurationText(elapsed_s * (total - done) / done));
  return text;
}

ProgressLine::ProgressLine(std::string what, int total)
    : what_(std::move(what)), total_(total), is_terminal_(isatty(STDERR_FILENO) == 1) {}

ProgressLine::~ProgressLine() { Finish(); }

void ProgressLine::Advance(int steps) {
  const std::lock_guard lock(mutex_);
  done_ += steps;
  const Clock::time_point now = Clock::now();
  const auto interval = is_terminal_ ? Clock::duration(kTerminalInterval) : kLogInterval;
  if (now - start_ >= kSilence && now - last_shown_ >= interval) Show(now);
}

void ProgressLine::Show(Clock::time_point now) {
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

void ProgressLine::Finish() {
  const std::lock_guard lock(mutex_);
  if (shown_ && is_terminal_) std::fputs(kEraseLine, stderr);
  shown_ = false;
}

}  // namespace orient
