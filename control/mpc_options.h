// Options of a predictive controller: horizons, weights, limits, observer.

#ifndef CONTROL_MPC_OPTIONS_H_
#define CONTROL_MPC_OPTIONS_H_

#include <optional>
#include <vector>

#include "Eigen/Core"
#include "absl/status/status.h"
#include "mle/model/state_space.h"

namespace mle::control {

// Vectors may be empty: no limit; so is an infinite entry. Entries of inputs
// with the role of disturbances are not used. Limits of inputs and moves hold
// exactly and at all control instants of the plan. Limits of outputs are soft:
//
//   y_min − s_i ≤ ŷ_{l+i} ≤ y_max + s_i, i = 1 … H_p, at the cost c s_i²
//
// for each output and instant, so that an unavoidable violation, as within a
// dead time, does not relax the other limits.
struct MpcLimits {
  Eigen::VectorXd min_input;   // m, ≤ max_input
  Eigen::VectorXd max_input;   // m
  Eigen::VectorXd max_move;    // m, ≥ 0: |Δu| from one instant to the next
  Eigen::VectorXd min_output;  // p, ≤ max_output
  Eigen::VectorXd max_output;  // p
  Eigen::VectorXd output_limit_cost;  // p, c > 0, where an output has a limit

  absl::Status Validate(int num_outputs, int num_inputs) const;
};

struct MpcOptions {
  double control_period = 1.0;  // Δt_c > 0, in the model's time unit
  int prediction_horizon = 30;  // H_p ≥ H_c, in control periods
  int control_horizon = 5;      // H_c ≥ 1, in control periods
  // How long each planned value of the inputs is held, in control periods, each
  // ≥ 1 and H_p or less together; the last is held to the end. Empty: H_c
  // times 1, the paper's. Where given, control_horizon is not used.
  std::vector<int> block_lengths;
  // Symmetric and positive semi-definite; p × p and m × m, where the rows and
  // columns of disturbances are not used. The Hessian they give must be
  // positive definite.
  Eigen::MatrixXd output_weight;  // Q_y
  Eigen::MatrixXd move_weight;    // Q_u
  MpcLimits limits;
  // ρ ∈ [0, ∞] of the DisturbanceObserver: one for all outputs, or, where
  // given, one for each (p).
  double disturbance_variance_ratio = 0.1;
  Eigen::VectorXd disturbance_variance_ratios;
  // In place of them: of all outputs, sampled every Δt_c; no output integrates.
  std::optional<DisturbanceForm> disturbance_model;

  absl::Status Validate(int num_outputs, int num_inputs) const;

  // Instants 1 … H_p at which the inputs move.
  std::vector<int> MoveInstants() const;
  // ρ of each output.
  Eigen::VectorXd VarianceRatios(int num_outputs) const;
};

}  // namespace mle::control

#endif  // CONTROL_MPC_OPTIONS_H_
