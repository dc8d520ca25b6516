// Orienting again what a person's word concerns, beside the server, one run at a time.
#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "core/base/progress.h"

namespace orient {

// How far it is; after its end what came of it.
struct RunProgress {
  bool running = false;
  int runs = 0;             // begun so far
  std::string task;         // "interior orientation"
  int done = 0, total = 0;  // of the task, photos
  std::string error;        // why the latest run ended early; empty: it did not
};

class RunAgain : private ProgressListener {
 public:
  // Throws what a command throws.
  using Run = std::function<void(ProgressListener*)>;

  explicit RunAgain(Run run) : run_(std::move(run)) {}
  ~RunAgain() override;  // waits for the end
  RunAgain(const RunAgain&) = delete;
  RunAgain& operator=(const RunAgain&) = delete;

  // False where one is running.
  bool Start();
  RunProgress Progress() const;

 private:
  void Begin(const std::string& task, int total) override;
  void Advance(int steps) override;
  void End() override;
  void Work();

  Run run_;
  mutable std::mutex mutex_;
  RunProgress progress_;
  std::jthread thread_;
};

}  // namespace orient
