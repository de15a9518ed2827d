// The processes of one campaign: one alone, or those that mpirun started.
//
// Process 0 deals out assignments and gathers what comes back; the others do
// what they are told. Built without MPI, or not started by mpirun, a process is
// alone and nothing of MPI is touched.
//
// All calls are made by the thread that called Start().

#ifndef APPS_STUDY_PROCESSES_H_
#define APPS_STUDY_PROCESSES_H_

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "apps/study/worker_pool.h"

namespace mle::study {

class Processes {
 public:
  // Whether the program was built with MPI.
  static bool HaveMpi();

  // Joins the other processes, if there are any. InvalidArgument where mpirun
  // started a program without MPI.
  static absl::StatusOr<std::unique_ptr<Processes>> Start(int* argc,
                                                          char*** argv);
  virtual ~Processes() = default;

  virtual int rank() const = 0;
  virtual int count() const = 0;
  // Of them on this machine.
  virtual int on_this_machine() const = 0;

  // Process 0's text to all of them; none means that it gives up.
  virtual std::optional<std::string> Broadcast(
      const std::optional<std::string>& text) = 0;

  // Process 0 to another, without waiting for it.
  virtual void Assign(int rank, const Assignment& assignment) = 0;
  // There will be no more work; `at_once`: drop what is not begun, too.
  virtual void Dismiss(int rank, bool at_once) = 0;
  // What the others have sent since, without waiting. `wanted` counts the
  // assignments that a process asks for, and `ended` those it has done.
  struct Report {
    int rank = 0;
    int wanted = 0;
    Harvest harvest;
  };
  virtual std::vector<Report> Receive() = 0;

  // The others to process 0.
  virtual void Send(const Report& report) = 0;
  // What process 0 has sent, without waiting.
  struct Order {
    enum class Kind { kNone, kWork, kNoMore, kStop } kind = Kind::kNone;
    Assignment assignment;  // of kWork
  };
  virtual Order TakeOrder() = 0;
};

// One alone, whoever started it.
std::unique_ptr<Processes> OneProcess();

}  // namespace mle::study

#endif  // APPS_STUDY_PROCESSES_H_
