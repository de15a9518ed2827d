// The parts of records outside of windows in which operation is steady, from
// which the noise is estimated. Internal to mle/maintain.
//
// The records outside of windows are taken for noise. Where the plant was shut
// down, or run by hand far from its operating point, the model says nothing and
// its residual r_i = y_i − Σ_j x_ij is not noise, yet larger than all the rest:
// correlation that it has would widen every interval and hide what has aged.
// So, where the mean square of r_i (of a level: of its increments) of any
// output over 60 samples, whitened under an offset and drift, is above 400
// times its median, five settling times on both sides are left out too, and
// what is between two such places that are no more than twenty apart: the plant
// leaves its usual operation in one and comes back in the other. What remains
// are records of their own. A step of an unmeasured disturbance as large as 35
// standard deviations of white noise stays.

#ifndef MLE_MAINTAIN_STEADY_RECORDS_H_
#define MLE_MAINTAIN_STEADY_RECORDS_H_

#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "mle/data/record.h"
#include "mle/model/process_model.h"

namespace mle {

struct SteadyRecords {
  std::vector<Record> usual;
  // Times of the first and the last sample of what is left out.
  std::vector<std::pair<double, double>> left_out;
};

// Nothing is left out where there are fewer than ten blocks in all, which say
// little of what is usual. InvalidArgument for a model that cannot be
// simulated. Operations: samples times elements.
absl::StatusOr<SteadyRecords> FindSteadyRecords(const ProcessModel& model,
                                                std::vector<Record> rest);

}  // namespace mle

#endif  // MLE_MAINTAIN_STEADY_RECORDS_H_
