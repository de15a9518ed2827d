// Processes where there is but one.

#include <cstdlib>
#include <string>

#include "apps/study/processes.h"
#include "apps/study/processes_mpi.h"

namespace mle::study {
namespace {

class Alone : public Processes {
 public:
  int rank() const override { return 0; }
  int count() const override { return 1; }
  int on_this_machine() const override { return 1; }
  std::optional<std::string> Broadcast(
      const std::optional<std::string>& text) override {
    return text;
  }
  void Assign(int, const Assignment&) override {}
  void Dismiss(int, bool) override {}
  std::vector<Report> Receive() override { return {}; }
  void Send(const Report&) override {}
  Order TakeOrder() override { return {Order::Kind::kNoMore, {}}; }
};

// What mpirun of Open MPI, MPICH and Intel MPI, and srun --mpi leave in the
// environment, where there is more than one process.
bool StartedByMpirun() {
  for (const char* variable :
       {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "PMIX_RANK"}) {
    const char* const value = std::getenv(variable);
    if (value == nullptr) continue;
    if (std::string(variable) == "PMIX_RANK" || std::atoi(value) > 1) {
      return true;
    }
  }
  return false;
}

}  // namespace

bool Processes::HaveMpi() { return kHaveMpi; }

absl::StatusOr<std::unique_ptr<Processes>> Processes::Start(int* argc,
                                                            char*** argv) {
  if (!StartedByMpirun()) return std::make_unique<Alone>();
  if (!HaveMpi()) {
    return absl::InvalidArgumentError(
        "mpirun started several processes, but this mle_study was built "
        "without MPI: run it by itself, or build it where MPI is found "
        "(libopenmpi-dev on Debian)");
  }
  return StartMpi(argc, argv);
}

}  // namespace mle::study
