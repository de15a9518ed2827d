// Work that takes time, called from Python: it runs on a thread of its own
// without the interpreter's lock, while the calling thread tells a Python
// function how far it is and looks for signals.
//
// A signal whose handler raises (Ctrl-C: KeyboardInterrupt) asks the work to
// stop. What has not stopped 0.5 s later is left to itself, to stop at its next
// report of progress, and the exception is raised: the caller waits less than a
// second. Such threads are joined before the interpreter ends (JoinLeftBehind).

#ifndef PYTHON_SRC_LONG_CALL_H_
#define PYTHON_SRC_LONG_CALL_H_

#include <functional>
#include <memory>
#include <optional>

#include "absl/status/statusor.h"
#include "mle/maintain/message.h"
#include "pybind11/pybind11.h"

namespace mle::python {

// `work` owns or shares all that it uses, and hands `report` on to what takes
// time; it must not touch Python. `progress` is None or progress(stage,
// fraction), which ends the work by returning False, or by raising. Throws what
// `progress` and handlers of signals raise.
absl::Status RunLong(
    std::function<absl::Status(const ProgressCallback& report)> work,
    const pybind11::object& progress);

// The same of work with a result.
template <typename Value>
absl::StatusOr<Value> RunLongFor(
    std::function<absl::StatusOr<Value>(const ProgressCallback& report)> work,
    const pybind11::object& progress) {
  const auto result = std::make_shared<std::optional<Value>>();
  const absl::Status status = RunLong(
      [work = std::move(work), result](const ProgressCallback& report) {
        absl::StatusOr<Value> value = work(report);
        if (value.ok()) *result = *std::move(value);
        return value.status();
      },
      progress);
  if (!status.ok()) return status;
  return **std::move(result);
}

// Waits for work that was left to itself.
void JoinLeftBehind();

}  // namespace mle::python

#endif  // PYTHON_SRC_LONG_CALL_H_
