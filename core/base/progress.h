// How far a long run is, told to whoever wants to know. Libraries tell; what is shown, and where,
// is the program's affair.
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

// One task, told from its construction to the end of its life.
class ProgressTask {
 public:
  // `listener` may be null: nobody wants to know.
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
