// A step test: the controller is off, one input after the other is stepped, and
// the record is made for identification.
//
// Input j goes up by Δ_j, stays for `hold`, and back for `hold`, `cycles`
// times, where
//
//   Δ_j = min_i move_i / |K_ij|
//
// with the gains K of the model in use, so that no output is expected to move
// by more than `move`. Where an input would leave its limits it stays there.

#ifndef APPS_LIFECYCLE_STEP_TEST_H_
#define APPS_LIFECYCLE_STEP_TEST_H_

#include <vector>

#include "Eigen/Core"
#include "mle/model/process_model.h"

namespace mle::lifecycle {

struct StepTestOptions {
  double hold = 0.0;     // > 0
  int cycles = 1;        // ≥ 1
  Eigen::VectorXd move;  // p, > 0: the largest expected move of each output
};

struct StepTestPlan {
  double hold = 0.0;
  int cycles = 1;
  std::vector<int> inputs;  // in the order in which they are stepped
  Eigen::VectorXd steps;    // of each of them

  double duration() const {
    return 2.0 * hold * cycles * static_cast<double>(inputs.size());
  }
  // Deviation of all `num_inputs` inputs at `time` of the test.
  Eigen::VectorXd InputsAt(double time, int num_inputs) const;
};

// Of the inputs that the controller moves and that reach an output.
StepTestPlan PlanStepTest(const ProcessModel& model,
                          const StepTestOptions& options);

}  // namespace mle::lifecycle

#endif  // APPS_LIFECYCLE_STEP_TEST_H_
