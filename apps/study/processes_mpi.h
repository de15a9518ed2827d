// The processes that mpirun started. Internal to processes.h.

#ifndef APPS_STUDY_PROCESSES_MPI_H_
#define APPS_STUDY_PROCESSES_MPI_H_

#include <memory>

#include "absl/status/statusor.h"
#include "apps/study/processes.h"

namespace mle::study {

#ifdef MLE_HAVE_MPI
inline constexpr bool kHaveMpi = true;
absl::StatusOr<std::unique_ptr<Processes>> StartMpi(int* argc, char*** argv);
#else
inline constexpr bool kHaveMpi = false;
inline absl::StatusOr<std::unique_ptr<Processes>> StartMpi(int*, char***) {
  return absl::UnimplementedError("built without MPI");
}
#endif

}  // namespace mle::study

#endif  // APPS_STUDY_PROCESSES_MPI_H_
