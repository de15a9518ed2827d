#include "apps/correct/solver_flags.h"

#include <map>
#include <string>

#include "absl/strings/str_cat.h"
#include "gflags/gflags.h"

DEFINE_string(solver, "homotopy",
              "Solver of ΔR: homotopy (exact, for all λ), coordinate_descent, "
              "or ceres (smoothed L1, at the λ chosen on the exact path).");
DEFINE_string(robust, "none",
              "Loss of the residuals: none (squares), huber or cauchy, for "
              "records with bursts and outliers that are not detected. For ΔR "
              "at the λ chosen with squares.");

namespace mle::correct {

absl::Status SetSolver(EstimationOptions& options) {
  if (FLAGS_solver == "coordinate_descent") {
    options.correction.solver.solver = LassoSolver::kCoordinateDescent;
  } else if (FLAGS_solver == "ceres") {
    options.solve_by_ceres = true;
  } else if (FLAGS_solver != "homotopy") {
    return absl::InvalidArgumentError(
        absl::StrCat("--solver=", FLAGS_solver,
                     ": known are homotopy, coordinate_descent and ceres"));
  }
  const std::map<std::string, RobustLoss> losses = {
      {"none", RobustLoss::kNone},
      {"huber", RobustLoss::kHuber},
      {"cauchy", RobustLoss::kCauchy}};
  const auto loss = losses.find(FLAGS_robust);
  if (loss == losses.end()) {
    return absl::InvalidArgumentError(absl::StrCat(
        "--robust=", FLAGS_robust, ": known are none, huber and cauchy"));
  }
  options.structured.robust_loss = loss->second;
  return absl::OkStatus();
}

}  // namespace mle::correct
