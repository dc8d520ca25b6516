// Work on one photo's marks on all cores.
#pragma once

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <cstddef>

namespace orient {

// work(0) ... work(count - 1). Isolated: a thread that waits for the last mark must not begin
// another photo meanwhile, whose windows would be in memory as well.
template <typename Work>
void SideBySide(std::size_t count, const Work& work) {
  tbb::this_task_arena::isolate([&] { tbb::parallel_for(std::size_t{0}, count, work); });
}

}  // namespace orient
