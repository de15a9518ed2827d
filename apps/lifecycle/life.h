// One policy through all the years of a scenario.
//
// For each set-point change, in turn: the quiet time before it, the change, and
// then the action of the policy: nothing, a correction from the records of the
// last changes, or a step test. The resulting model is used from there on.

#ifndef APPS_LIFECYCLE_LIFE_H_
#define APPS_LIFECYCLE_LIFE_H_

#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "apps/lifecycle/operation.h"
#include "apps/lifecycle/policy.h"
#include "apps/lifecycle/scenario.h"
#include "apps/lifecycle/update.h"
#include "control/operating_cost.h"

namespace mle::lifecycle {

struct LifeOptions {
  OperationOptions operation;
  UpdateOptions update;  // its estimator is the policy's
  StepTestOptions test;
  int windows = 4;  // records of the last changes that are kept, ≥ 1
  // Older ones are forgotten, time unit, > 0.
  double window_age = std::numeric_limits<double>::infinity();
  double month = 43830.0;  // in the time unit
  // A new model is watched for a quiet stretch, and reverted if the measured
  // squared error of an output is more than this many times what it was before
  // the last change, > 1; infinite: never.
  double watch_limit = 3.0;
};

// Results of a set-point change and of the time before it.
struct ChangeRow {
  SetPointEvent event;
  control::OperationSums quiet;      // since the last row
  control::OperationSums transient;  // after the change
  // Sums of a step test after it, and of the first hours with a new model;
  // their times are 0 without one.
  control::OperationSums test;
  control::OperationSums watch;
  ModelError error;  // of the model in use at the change
  double index = std::numeric_limits<double>::quiet_NaN();  // on_demand only
  Outcome outcome = Outcome::kNone;  // of a correction or step test after it
  std::string reason;                // of a refusal
  double held_out_gain = std::numeric_limits<double>::quiet_NaN();

  bool tested() const { return test.time > 0.0; }
  // Sums of all four.
  control::OperationSums Total() const;
};

struct Life {
  std::vector<ChangeRow> rows;  // the last is the end of the years
  // If the loop diverged: the reason and the time. Rows end there.
  std::string ended;
};

// `stop` is asked at each change and within corrections; Cancelled if it says
// so. Other errors are of options and models that do not fit.
absl::StatusOr<Life> LiveThrough(const Scenario& scenario, const Policy& policy,
                                 const LifeOptions& options,
                                 const std::function<bool()>& stop);

}  // namespace mle::lifecycle

#endif  // APPS_LIFECYCLE_LIFE_H_
