// Progress of a long run, reported to a listener. Libraries report it; what is shown, and where,
// is up to the program.
#pragma once

#include <string>

namespace orient {

class ProgressListener {
 public:
  virtual ~ProgressListener() = default;
  // One task after another: Begin, any number of Advance (from several threads), End.
  virtual void Begin(const std::string& task, int total) = 0;  // "interior orientation", photos
  virtual void Advance(int steps) = 0;
  virtual void End() = 0;
};

// One task: Begin is reported on construction, End on destruction.
class ProgressTask {
 public:
  // `listener` may be null: then nothing is reported.
  ProgressTask(ProgressListener* listener, const std::string& task, int total)
      : listener_(listener) {
    if (listener_) listener_->Begin(task, total);
  }
  ~ProgressTask() {
    if (listener_) listener_->End();
  }
  ProgressTask(const ProgressTask&) = delete;
  ProgressTask& operator=(const ProgressTask&) = delete;

  void Advance(int steps = 1) {
    if (listener_) listener_->Advance(steps);
  }

 private:
  ProgressListener* listener_;
};

}  // namespace orient
