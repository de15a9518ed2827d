// The inputs that are measured but not moved: those with the role
// "disturbance".
//
// Each is a profile of steps, zero before its first, plus coloured noise
// (coloured_noise.h), held from sample to sample.

#ifndef SIM_INPUT_DISTURBANCE_H_
#define SIM_INPUT_DISTURBANCE_H_

#include <cstdint>
#include <vector>

#include "Eigen/Core"
#include "absl/status/status.h"
#include "mle/model/process_model.h"

namespace mle::sim {

// From `time` on (included), the profile of input `input` is `value`.
struct InputStep {
  int input = 0;
  double time = 0.0;
  double value = 0.0;
};

struct InputDisturbanceOptions {
  std::vector<InputStep> steps;  // in any order, of disturbances only
  // σ² ≥ 0 of the noise for each input (m; those of inputs that are moved are
  // not used), or none.
  Eigen::VectorXd variance;
  double time_constant = 10.0;  // T > 0

  absl::Status Validate(const ProcessModel& channels) const;
};

// m × N: the inputs of `channels` at each sample, zero for those that are
// moved. For valid options.
Eigen::MatrixXd DrawInputDisturbances(const InputDisturbanceOptions& options,
                                      const ProcessModel& channels,
                                      double sample_time, int samples,
                                      std::uint64_t seed, std::uint64_t stream);

}  // namespace mle::sim

#endif  // SIM_INPUT_DISTURBANCE_H_
