// Unmeasured loads at the inputs: what acts on the plant is the input of the
// record plus
//
//   l_k = ξ_k + s_k,
//
// ξ first-order coloured noise (coloured_noise.h), s steps at given times. The
// effect on the outputs goes through the plant's own dynamics. If somebody who
// sees the load answers it by feedforward, the record's input has −a l_k in it.

#ifndef SIM_INPUT_LOAD_H_
#define SIM_INPUT_LOAD_H_

#include <cstdint>
#include <vector>

#include "Eigen/Core"
#include "absl/status/status.h"
#include "sim/signal_step.h"

namespace mle::sim {

struct InputLoad {
  int input = 0;
  double variance = 0.0;        // of ξ, ≥ 0
  double time_constant = 10.0;  // of ξ, > 0
  std::vector<SignalStep> steps = {};
  double answered = 0.0;  // a, finite, of an input that is moved

  absl::Status Validate(int num_inputs) const;
};

// m × N: l_0 … l_{N−1}. For valid loads.
Eigen::MatrixXd DrawInputLoads(const std::vector<InputLoad>& loads,
                               int num_inputs, double sample_time, int samples,
                               std::uint64_t seed, std::uint64_t stream);

}  // namespace mle::sim

#endif  // SIM_INPUT_LOAD_H_
