#include "core/base/reading_side_by_side.h"

#include <gtest/gtest.h>

#include <stdexcept>
#include <string>
#include <thread>

namespace orient {
namespace {

// Reads 0 ... count - 1; 'reading N' where N is to fail.
auto Reader(int count, int fails_at, int* read) {
  return [=](int* item) {
    if (*read == fails_at) throw std::runtime_error("reading " + std::to_string(fails_at));
    *item = *read;
    return (*read)++ < count;
  };
}

std::string FailureOf(int reading_fails_at, int first_work_that_fails) {
  int read = 0;
  try {
    WorkWhileReading<int>(Reader(400, reading_fails_at, &read), [&](int item) {
      // The first to fail takes longest to do so.
      volatile double sum = 0;
      for (int k = 0; item == first_work_that_fails && k < 200000; ++k) sum = sum + k;
      if (item >= first_work_that_fails) throw std::runtime_error("work " + std::to_string(item));
      return item;
    });
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "none";
}

TEST(WorkWhileReading, DoesEveryItemOnceInItsOrder) {
  for (const int count : {0, 1, 7, 8, 9, 1000}) {
    int read = 0;
    const auto reading_thread = std::this_thread::get_id();
    bool here = true;
    const auto next = [&, reader = Reader(count, -1, &read)](int* item) {
      here = here && std::this_thread::get_id() == reading_thread;
      return reader(item);
    };
    const std::vector<int> twice = WorkWhileReading<int>(next, [](int item) { return 2 * item; });
    ASSERT_EQ(twice.size(), static_cast<std::size_t>(count));
    for (int i = 0; i < count; ++i) EXPECT_EQ(twice[static_cast<std::size_t>(i)], 2 * i);
    EXPECT_TRUE(here);
  }
}

TEST(WorkWhileReading, ThrowsWhatTheFirstItemThrowsWhicheverThreadIsQuicker) {
  for (int round = 0; round < 50; ++round) {
    ASSERT_EQ(FailureOf(-1, 3), "work 3");
    ASSERT_EQ(FailureOf(5, 3), "work 3");
    ASSERT_EQ(FailureOf(300, 40), "work 40");
    ASSERT_EQ(FailureOf(13, 13), "reading 13");
    ASSERT_EQ(FailureOf(0, 1000), "reading 0");
  }
}

}  // namespace
}  // namespace orient
