// Work on the parts of one photo (its marks, its patches) on all cores.
#pragma once

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <atomic>
#include <cstddef>
#include <exception>
#include <limits>
#include <mutex>

namespace orient {

// The exception of the first piece of work, in their order, that threw one.
class FirstFailure {
 public:
  // Pieces after one that failed need not be done, those before it do.
  bool IsBefore(std::size_t i) const { return first_.load() < i; }

  // Called in the handler of work(i)'s exception.
  void Keep(std::size_t i) {
    const std::lock_guard lock(mutex_);
    if (i >= first_.load()) return;
    first_ = i;
    exception_ = std::current_exception();
  }

  void Rethrow() const {
    if (exception_) std::rethrow_exception(exception_);
  }

 private:
  std::atomic<std::size_t> first_ = std::numeric_limits<std::size_t>::max();
  std::mutex mutex_;
  std::exception_ptr exception_;
};

// work(0) ... work(count - 1). Isolated: a thread that waits for the last one must not begin
// another photo meanwhile, or more photos than the caller asked for would be in memory at a time.
// Throws what the first of them throws, whichever thread was the quickest: a damaged file has one
// message.
template <typename Work>
void SideBySide(std::size_t count, const Work& work) {
  FirstFailure failure;
  // Its own context: work around it that is cancelled must not take pieces out of it unseen.
  tbb::task_group_context context(tbb::task_group_context::isolated);
  tbb::this_task_arena::isolate([&] {
    tbb::parallel_for(
        std::size_t{0}, count,
        [&](std::size_t i) {
          if (failure.IsBefore(i)) return;
          try {
            work(i);
          } catch (...) {
            failure.Keep(i);
          }
        },
        context);
  });
  failure.Rethrow();
}

// Runs work() with this many threads for its parallel parts; 0: one per core.
template <typename Work>
void OnThreads(int threads, const Work& work) {
  tbb::task_arena arena(threads > 0 ? threads : tbb::task_arena::automatic);
  arena.execute(work);
}

}  // namespace orient
