// What FindPlan() does in turn. Internal to mle/plan.

#ifndef MLE_PLAN_PLAN_PROBLEM_H_
#define MLE_PLAN_PLAN_PROBLEM_H_

#include <vector>

#include "Eigen/Core"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "mle/plan/plan.h"

namespace mle {

// InvalidArgument as of FindPlan().
absl::Status CheckProblem(const PlanProblem& problem,
                          const PlanOptions& options);

// The extremes of the answers of several plants to set points (p × N), over
// outputs and inputs: (p + m) × N.
struct PlanBand {
  Eigen::MatrixXd low;
  Eigen::MatrixXd high;
  // p + m: the plants that go farthest.
  std::vector<int> lowest;
  std::vector<int> highest;
  int left_out = 0;
};

// Plants that the loop does not hold are left out. FailedPrecondition where
// these are all.
absl::StatusOr<PlanBand> BandOf(const PlanProblem& problem,
                                const std::vector<ProcessModel>& plants,
                                const Eigen::MatrixXd& set_points, int threads);

}  // namespace mle

#endif  // MLE_PLAN_PLAN_PROBLEM_H_
