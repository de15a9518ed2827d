// The threads of one process: units go in, rows come out, in any order.

#ifndef APPS_STUDY_WORKER_POOL_H_
#define APPS_STUDY_WORKER_POOL_H_

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "absl/time/time.h"
#include "apps/experiment/grid.h"
#include "apps/study/campaign.h"

namespace mle::study {

// Runs of one unit that are to be done.
struct Assignment {
  std::vector<std::int64_t> runs;
};

// What came out since the last look: lines of the journal, and how many
// assignments have ended.
struct Harvest {
  struct Line {
    std::int64_t run = 0;
    std::string text;
  };
  std::vector<Line> lines;
  int ended = 0;
};

class WorkerPool {
 public:
  // `campaign` and `grid` must outlive the pool.
  WorkerPool(const experiment::Campaign& campaign, const experiment::Grid& grid,
             int threads);
  // Waits for the runs that are under way.
  ~WorkerPool();
  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  int threads() const { return threads_; }
  // Assignments that have not ended, whether or not that was harvested.
  int outstanding() const;

  void Submit(Assignment assignment);
  // Waits until something came out, at most so long.
  Harvest Collect(absl::Duration at_most);
  // No further run is started; assignments end with the run under way.
  void Stop() { stop_ = true; }

 private:
  // Until the pool is closed and nothing waits.
  void Work();

  const experiment::Campaign& campaign_;
  const experiment::Grid& grid_;
  const int threads_;
  std::atomic<bool> stop_{false};
  mutable std::mutex mutex_;  // of what follows
  std::condition_variable given_;
  std::condition_variable came_out_;
  std::deque<Assignment> waiting_;
  Harvest harvest_;
  int outstanding_ = 0;
  bool closed_ = false;
  std::vector<std::thread> workers_;
};

}  // namespace mle::study

#endif  // APPS_STUDY_WORKER_POOL_H_
