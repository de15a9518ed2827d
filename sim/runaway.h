// Detection of a diverging loop, as opposed to a badly tuned one.

#ifndef SIM_RUNAWAY_H_
#define SIM_RUNAWAY_H_

#include "Eigen/Core"
#include "absl/status/status.h"
#include "mle/model/process_model.h"

namespace mle::sim {

// Limits at 1e6 times the size that a value may have in an experiment. That
// size is a_i for output i, carried over to the other channels by the static
// gains K:
//
//   input j:  v_j = max_i a_i / |K_ij| over K_ij ≠ 0;
//   output i: a_i ← max(a_i, max_j |K_ij| v_j),
//
// and so on for inputs that move only what others move, so that neither units
// nor set points that stand at zero raise a false alarm. A channel that nothing
// is expected to move has no limit but to be finite.
class RunawayGuard {
 public:
  // `output_sizes`: a (p) ≥ 0; all 1 where all are zero.
  RunawayGuard(const ProcessModel& channels, Eigen::VectorXd output_sizes);

  // FailedPrecondition, with the channel and the time, for a value that is not
  // finite or beyond its limit.
  absl::Status CheckOutputs(const Eigen::VectorXd& outputs, double time) const;
  absl::Status CheckInputs(const Eigen::VectorXd& inputs, double time) const;

 private:
  const ProcessModel& channels_;
  Eigen::VectorXd output_limits_;  // p
  Eigen::VectorXd input_limits_;   // m
};

}  // namespace mle::sim

#endif  // SIM_RUNAWAY_H_
