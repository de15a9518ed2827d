#include "apps/study/worker_pool.h"

#include <chrono>
#include <utility>

#include "apps/experiment/row.h"
#include "apps/experiment/unit.h"

namespace mle::study {

using experiment::Campaign;
using experiment::Grid;
using experiment::RowText;
using experiment::RunUnit;

WorkerPool::WorkerPool(const Campaign& campaign, const Grid& grid, int threads)
    : campaign_(campaign), grid_(grid), threads_(threads) {
  for (int i = 0; i < threads; ++i) workers_.emplace_back([this] { Work(); });
}

WorkerPool::~WorkerPool() {
  Stop();
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    closed_ = true;
  }
  given_.notify_all();
  for (std::thread& worker : workers_) worker.join();
}

int WorkerPool::outstanding() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return outstanding_;
}

void WorkerPool::Submit(Assignment assignment) {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    waiting_.push_back(std::move(assignment));
    ++outstanding_;
  }
  given_.notify_one();
}

void WorkerPool::Work() {
  std::unique_lock<std::mutex> lock(mutex_);
  while (true) {
    given_.wait(lock, [this] { return closed_ || !waiting_.empty(); });
    if (waiting_.empty()) return;
    const Assignment assignment = std::move(waiting_.front());
    waiting_.pop_front();
    lock.unlock();
    RunUnit(campaign_, grid_, assignment.runs, stop_,
            [this](const experiment::Outcome& outcome) {
              std::string text =
                  RowText(campaign_, grid_, experiment::RowOf(outcome));
              const std::lock_guard<std::mutex> held(mutex_);
              harvest_.lines.push_back({outcome.run, std::move(text)});
              came_out_.notify_all();
            });
    lock.lock();
    --outstanding_;
    ++harvest_.ended;
    came_out_.notify_all();
  }
}

Harvest WorkerPool::Collect(absl::Duration at_most) {
  std::unique_lock<std::mutex> lock(mutex_);
  came_out_.wait_for(lock, absl::ToChronoMilliseconds(at_most), [this] {
    return !harvest_.lines.empty() || harvest_.ended > 0;
  });
  return std::exchange(harvest_, Harvest());
}

}  // namespace mle::study
