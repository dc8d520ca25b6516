#include "tools/review/run_again.h"

#include <exception>

namespace orient {

RunAgain::~RunAgain() {
  if (thread_.joinable()) thread_.join();
}

bool RunAgain::Start() {
  const std::lock_guard lock(mutex_);
  if (progress_.running) return false;
  if (thread_.joinable()) thread_.join();  // it has said that it is done
  const int runs = progress_.runs + 1;
  progress_ = {};
  progress_.running = true;
  progress_.runs = runs;
  thread_ = std::jthread([this] { Work(); });
  return true;
}

RunProgress RunAgain::Progress() const {
  const std::lock_guard lock(mutex_);
  return progress_;
}

void RunAgain::Begin(const std::string& task, int total) {
  const std::lock_guard lock(mutex_);
  progress_.task = task;
  progress_.done = 0;
  progress_.total = total;
}

void RunAgain::Advance(int steps) {
  const std::lock_guard lock(mutex_);
  progress_.done += steps;
}

void RunAgain::End() {}

void RunAgain::Work() {
  std::string error;
  try {
    run_(this);
  } catch (const std::exception& failed) {  // the person is told, and the server goes on
    error = failed.what();
  }
  const std::lock_guard lock(mutex_);
  progress_.running = false;
  progress_.error = error;
}

}  // namespace orient
