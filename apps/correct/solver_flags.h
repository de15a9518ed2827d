// How ΔR is solved, by flags: of every command that corrects records.

#ifndef APPS_CORRECT_SOLVER_FLAGS_H_
#define APPS_CORRECT_SOLVER_FLAGS_H_

#include "absl/status/status.h"
#include "mle/maintain/estimation.h"

namespace mle::correct {

// --solver and --robust. InvalidArgument names the flag and what is known.
absl::Status SetSolver(EstimationOptions& options);

}  // namespace mle::correct

#endif  // APPS_CORRECT_SOLVER_FLAGS_H_
