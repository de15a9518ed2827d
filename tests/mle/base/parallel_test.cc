#include "mle/base/parallel.h"

#include <atomic>
#include <chrono>
#include <cstddef>
#include <mutex>
#include <set>
#include <thread>
#include <vector>

#include "gtest/gtest.h"
#include "oneapi/tbb/global_control.h"

namespace mle {
namespace {

// The threads that worked at an outer loop of 4 and inner loops of 50.
std::set<std::thread::id> ThreadsOf(int outer, int inner,
                                    std::vector<std::atomic<int>>& calls) {
  std::mutex mutex;
  std::set<std::thread::id> threads;
  ParallelFor(4, outer, [&](int i) {
    ParallelFor(50, inner, [&](int j) {
      ++calls[50 * i + j];
      std::this_thread::yield();
      const std::lock_guard<std::mutex> lock(mutex);
      threads.insert(std::this_thread::get_id());
    });
  });
  return threads;
}

TEST(ParallelForTest, CallsWithinCallsShareTheirThreads) {
  for (const int inner : {0, 1, 2, 16}) {
    for (const int outer : {1, 2}) {
      std::vector<std::atomic<int>> calls(200);
      const std::set<std::thread::id> threads = ThreadsOf(outer, inner, calls);
      EXPECT_LE(threads.size(), static_cast<std::size_t>(outer));
      for (const std::atomic<int>& count : calls) EXPECT_EQ(count, 1);
    }
  }
}

TEST(ParallelForTest, OneThreadWithinABodyIsTheBodysOwn) {
  std::atomic<int> elsewhere = 0;
  ParallelFor(8, 2, [&](int) {
    const std::thread::id own = std::this_thread::get_id();
    std::vector<int> order;
    ParallelFor(20, 1, [&](int j) {
      if (std::this_thread::get_id() != own) ++elsewhere;
      order.push_back(j);
    });
    for (int j = 0; j < 20; ++j) {
      if (order[j] != j) ++elsewhere;
    }
  });
  EXPECT_EQ(elsewhere, 0);
}

// Who waits for pieces of its own takes none of the loop around it meanwhile:
// bodies would lie upon each other on one stack. Threads are as many as on a
// large machine, for two of them are never seen to do it.
TEST(ParallelForTest, ABodyIsNotEnteredWhileOneWaits) {
  constexpr int kThreads = 8;
  const tbb::global_control threads(
      tbb::global_control::max_allowed_parallelism, kThreads);
  std::atomic<int> nested = 0;
  ParallelFor(400, kThreads, [&](int i) {
    thread_local bool busy = false;
    if (busy) ++nested;
    busy = true;
    ParallelFor(1 + i % 7, kThreads, [](int j) {
      std::this_thread::sleep_for(std::chrono::microseconds(20 * (1 + j)));
    });
    busy = false;
  });
  EXPECT_EQ(nested, 0);
}

}  // namespace
}  // namespace mle
