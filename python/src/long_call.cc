#include "python/src/long_call.h"

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

namespace mle::python {
namespace {

namespace py = pybind11;

// How often signals are looked for, and how long stopping may take.
constexpr std::chrono::milliseconds kPoll{50};
constexpr std::chrono::milliseconds kPatience{500};

// Shared by the calling thread and the one that works.
struct Call {
  std::atomic<bool> stop = false;
  std::mutex mutex;
  std::condition_variable changed;
  // The members below are guarded by the mutex.
  std::deque<RunProgress> reports;
  bool done = false;
  absl::Status status;
  std::exception_ptr thrown;  // memory that is exhausted
};

struct LeftBehind {
  std::mutex mutex;
  std::vector<std::thread> threads;
};

LeftBehind& Threads() {
  static LeftBehind& left = *new LeftBehind;
  return left;
}

// Waits for reports, at most kPoll and without the interpreter's lock, and
// takes those made up to now.
std::deque<RunProgress> NextReports(Call& call, bool& done) {
  const py::gil_scoped_release release;
  std::unique_lock<std::mutex> lock(call.mutex);
  call.changed.wait_for(lock, kPoll,
                        [&] { return call.done || !call.reports.empty(); });
  done = call.done;
  return std::exchange(call.reports, {});
}

// Until the work is done. Throws what Python raises.
void Watch(const py::object& progress, Call& call) {
  bool done = false;
  while (!done) {
    for (const RunProgress& report : NextReports(call, done)) {
      const py::object answer = progress(report.stage, report.fraction);
      if (answer.is(py::bool_(false))) call.stop = true;
    }
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
  }
}

// Asks to stop, and waits for a while.
void Abandon(Call& call, std::thread& thread) {
  const py::gil_scoped_release release;
  call.stop = true;
  std::unique_lock<std::mutex> lock(call.mutex);
  if (call.changed.wait_for(lock, kPatience, [&] { return call.done; })) {
    lock.unlock();
    thread.join();
    return;
  }
  LeftBehind& left = Threads();
  const std::lock_guard<std::mutex> left_lock(left.mutex);
  left.threads.push_back(std::move(thread));
}

}  // namespace

absl::Status RunLong(
    std::function<absl::Status(const ProgressCallback& report)> work,
    const py::object& progress) {
  const auto call = std::make_shared<Call>();
  const bool tells = !progress.is_none();
  std::thread thread([call, tells, work = std::move(work)]() mutable {
    absl::Status status;
    std::exception_ptr thrown;
    try {
      status = work([&call, tells](const RunProgress& report) {
        if (tells) {
          const std::lock_guard<std::mutex> lock(call->mutex);
          call->reports.push_back(report);
          call->changed.notify_all();
        }
        return !call->stop;
      });
    } catch (...) {
      thrown = std::current_exception();
    }
    work = nullptr;  // and what it holds
    const std::lock_guard<std::mutex> lock(call->mutex);
    call->status = std::move(status);
    call->thrown = thrown;
    call->done = true;
    call->changed.notify_all();
  });
  try {
    Watch(progress, *call);
  } catch (...) {
    Abandon(*call, thread);
    throw;
  }
  thread.join();
  if (call->thrown) std::rethrow_exception(call->thrown);
  return call->status;
}

void JoinLeftBehind() {
  const py::gil_scoped_release release;
  LeftBehind& left = Threads();
  std::vector<std::thread> threads;
  {
    const std::lock_guard<std::mutex> lock(left.mutex);
    threads.swap(left.threads);
  }
  for (std::thread& thread : threads) thread.join();
}

}  // namespace mle::python
