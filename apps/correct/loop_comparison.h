// The effect of a correction on control: set points followed by the controller
// with the old model and with the corrected one, on a plant that is as the
// corrected model says.

#ifndef APPS_CORRECT_LOOP_COMPARISON_H_
#define APPS_CORRECT_LOOP_COMPARISON_H_

#include <vector>

#include "absl/status/statusor.h"
#include "mle/data/record.h"

namespace mle::correct {

struct Result;

// A step of one output's set point from rest, without noise or limits.
struct LoopStep {
  int output = 0;
  Record before;  // under the model in use
  Record after;   // under the corrected model, tuned as before
  // Squared errors of all outputs in units of the set-point step, summed over
  // the samples: after / before.
  double error_ratio = 1.0;
};

struct LoopComparison {
  bool told = false;  // the tuning was given, and is not that of rules
  std::vector<LoopStep> steps;  // of each output
};

// FailedPrecondition where nothing was corrected, or a loop is not stable.
absl::StatusOr<LoopComparison> CompareLoops(const Result& result);

}  // namespace mle::correct

#endif  // APPS_CORRECT_LOOP_COMPARISON_H_
