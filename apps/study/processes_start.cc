// Processes as the command is started: alone or by mpirun. What links with this
// links with MPI.

#include <cstdlib>
#include <string>

#include "apps/study/processes.h"
#include "apps/study/processes_mpi.h"

namespace mle::study {
namespace {

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
  if (!StartedByMpirun()) return OneProcess();
  if (!HaveMpi()) {
    return absl::InvalidArgumentError(
        "mpirun started several processes, but this mle_study was built "
        "without MPI: run it by itself, or build it where MPI is found "
        "(libopenmpi-dev on Debian)");
  }
  return StartMpi(argc, argv);
}

}  // namespace mle::study
