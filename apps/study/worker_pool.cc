#include "apps/study/worker_pool.h"

#include <chrono>
#include <utility>

#include "apps/study/row.h"
#include "apps/study/unit.h"
#include "mle/base/thread_order.h"
#include "oneapi/tbb/global_control.h"
#include "oneapi/tbb/task_arena.h"

namespace mle::study {

// The thread that made the pool does not work in it, so that it can see to
// journal, signals and other processes.
class WorkerPool::Arena {
 public:
  explicit Arena(int threads)
      : control_(tbb::global_control::max_allowed_parallelism,
                 static_cast<std::size_t>(threads) + 1),
        arena_(threads, /*reserved_for_masters=*/0) {}

  tbb::task_arena& arena() { return arena_; }

 private:
  tbb::global_control control_;
  tbb::task_arena arena_;
};

WorkerPool::WorkerPool(const Campaign& campaign, const Grid& grid, int threads)
    : campaign_(campaign),
      grid_(grid),
      threads_(threads),
      arena_(std::make_unique<Arena>(threads)) {}

WorkerPool::~WorkerPool() {
  Stop();
  std::unique_lock<std::mutex> lock(mutex_);
  changed_.wait(lock, [this] { return outstanding_ == 0; });
}

int WorkerPool::outstanding() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return outstanding_;
}

void WorkerPool::Submit(Assignment assignment) {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    ++outstanding_;
  }
  TellRelease(handed_over_);
  arena_->arena().enqueue([this, given = std::move(assignment)] {
    TellAcquire(handed_over_);
    Work(given);
  });
}

void WorkerPool::Work(const Assignment& assignment) {
  RunUnit(campaign_, grid_, assignment.runs, stop_, [this](const Row& row) {
    std::string text = RowText(campaign_, grid_, row);
    const std::lock_guard<std::mutex> lock(mutex_);
    harvest_.lines.push_back({row.run, std::move(text)});
    changed_.notify_all();
  });
  // Told under the lock: the pool may be gone right after.
  const std::lock_guard<std::mutex> lock(mutex_);
  --outstanding_;
  ++harvest_.ended;
  changed_.notify_all();
}

Harvest WorkerPool::Collect(absl::Duration at_most) {
  std::unique_lock<std::mutex> lock(mutex_);
  changed_.wait_for(lock, absl::ToChronoMilliseconds(at_most), [this] {
    return !harvest_.lines.empty() || harvest_.ended > 0;
  });
  return std::exchange(harvest_, Harvest());
}

}  // namespace mle::study
