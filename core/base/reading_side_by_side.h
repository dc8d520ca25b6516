// Work on what is read, on all cores, while the reading goes on.
#pragma once

#include <tbb/task_group.h>

#include <algorithm>
#include <deque>
#include <iterator>
#include <utility>
#include <vector>

#include "core/base/side_by_side.h"

namespace orient {

// next(&item) on this thread, until it says false; work(item) of all items, on any core and some
// items at a time. The results are in the items' order. Throws what the first item throws, in its
// reading or in its work. Isolated as SideBySide is.
template <typename Item, typename Next, typename Work>
auto WorkWhileReading(const Next& next, const Work& work) {
  using Result = decltype(work(std::declval<Item>()));
  constexpr std::size_t kAtATime = 8;
  struct Batch {
    std::size_t first = 0;
    std::vector<Item> items = {};
    std::vector<Result> results = {};
  };
  std::deque<Batch> batches;  // in which each stays where it is
  FirstFailure failure;
  const auto work_on = [&](Batch& batch) {
    std::size_t i = batch.first;
    try {
      for (Item& item : batch.items)
        if (!failure.IsBefore(i++)) batch.results.push_back(work(std::move(item)));
    } catch (...) {
      failure.Keep(i - 1);
    }
  };
  tbb::task_group_context context(tbb::task_group_context::isolated);  // as SideBySide's
  tbb::this_task_arena::isolate([&] {
    tbb::task_group group(context);
    std::size_t count = 0;
    for (bool more = true; more;) {
      Batch& batch = batches.emplace_back(Batch{count});
      try {
        for (Item item; batch.items.size() < kAtATime && (more = next(&item)); ++count)
          batch.items.push_back(std::exchange(item, Item{}));
      } catch (...) {
        failure.Keep(count);
        more = false;
      }
      group.run([&work_on, &batch] { work_on(batch); });
    }
    group.wait();
  });
  failure.Rethrow();
  std::vector<Result> results;
  for (Batch& batch : batches)
    std::move(batch.results.begin(), batch.results.end(), std::back_inserter(results));
  return results;
}

}  // namespace orient
