// A discrete state-space model of a p × m process with dead times of inputs and
// outputs,
//
//   x_{k+1} = A x_k + B v_k,   v_j(k) = u_j(k − a_j),
//   w_k     = C x_k + D v_k,   y_i(k) = w_i(k − c_i),
//
// with n states, and dead times a_j of the inputs and c_i of the outputs in
// whole samples. Inputs are held from sample to sample; outputs are taken just
// before the inputs change, so that D is 0 in all that is made here of process
// models (balanced_reduction.h). Deviations from the operating point are
// modelled. Levels integrate: A then has eigenvalues 1, each with a state of
// its own; the others lie inside the unit circle. Not to be confused with
// StateSpace (transfer_function.h), one element in continuous time.
//
//   MLE_ASSIGN_OR_RETURN(const NamedStateSpace named,
//                        ReadStateSpace("correction/state_space.json"));
//   named.system.ComputeStepResponse(/*samples=*/501);

#ifndef MLE_MODEL_STATE_SPACE_H_
#define MLE_MODEL_STATE_SPACE_H_

#include <optional>
#include <string>
#include <vector>

#include "Eigen/Core"
#include "absl/status/status.h"
#include "mle/model/step_response.h"

namespace mle {

class ProcessModel;

// Samples; what is longer is a mistake.
inline constexpr int kMaxStateSpaceDelay = 10'000'000;

// What disturbs the outputs beside the inputs, and the filter that follows it:
//
//   d_{k+1} = A d_k + ω_k,   y_k = (the model's output) + C d_k + v_k,
//   d̂_{k+1} = A d̂_k + K (y_k − (the model's output) − C d̂_k),
//
// Var ω = Q, Var v = diag(R). A may have eigenvalues 1: disturbances that stay.
struct DisturbanceForm {
  Eigen::MatrixXd A;  // n × n
  Eigen::MatrixXd C;  // p × n
  Eigen::MatrixXd K;  // n × p, the stationary Kalman gain
  Eigen::MatrixXd Q;  // n × n
  Eigen::VectorXd R;  // p

  // Shapes agree, n ≥ 1, entries are finite, R is not negative, and no error of
  // the filter grows: the eigenvalues of A − K C lie inside the unit circle.
  absl::Status Validate(int num_outputs) const;
};

struct DiscreteStateSpace {
  double sample_time = 0.0;        // Δt, in the process model's unit of time
  Eigen::MatrixXd A;               // n × n
  Eigen::MatrixXd B;               // n × m
  Eigen::MatrixXd C;               // p × n
  Eigen::MatrixXd D;               // p × m
  std::vector<int> input_delays;   // m, a_j ≥ 0 in samples
  std::vector<int> output_delays;  // p, c_i ≥ 0 in samples

  int order() const { return static_cast<int>(A.rows()); }  // n
  int num_outputs() const { return static_cast<int>(C.rows()); }
  int num_inputs() const { return static_cast<int>(B.cols()); }

  // Δt > 0; n, m and p at least 1; matrices that fit each other, with finite
  // entries; every eigenvalue of A inside the unit circle or 1, and as many
  // eigenvectors of 1 as there are such eigenvalues (nothing integrates twice);
  // dead times from 0 to kMaxStateSpaceDelay.
  absl::Status Validate() const;

  // A has an eigenvalue 1, to rounding.
  bool IsIntegrating() const;
  // p × m, of a valid model: C P B / Δt, the slopes of the ramps that step
  // responses end in, per unit of time. P is the projector on the states that
  // integrate. 0, to the bit, where a response settles.
  Eigen::MatrixXd Slopes() const;

  // p × m, of a valid model: what step responses settle at, C (I − A)⁻¹ B + D
  // where nothing integrates. Where Slopes() is not 0, the slope.
  Eigen::MatrixXd StaticGains() const;

  // From rest, each input stepped to 1 at k = 0: φ_k, k = 0 … samples − 1.
  StepResponse ComputeStepResponse(int samples) const;

  // y (p × N) to the inputs u (m × N), from rest.
  Eigen::MatrixXd Simulate(const Eigen::MatrixXd& inputs) const;
};

// The errors of each output (p), relative to the largest value of a step
// response: the bound of the error at any frequency, and the largest difference
// of a step response or static gain (balanced_reduction.h). Finite and ≥ 0.
struct StateSpaceAccuracy {
  std::vector<double> error_bounds;
  std::vector<double> largest_differences;
};

struct NamedStateSpace {
  std::string name;  // of the process
  std::string time_unit;
  std::vector<std::string> outputs;  // p names
  std::vector<std::string> inputs;   // m names
  DiscreteStateSpace system;
  std::optional<StateSpaceAccuracy> accuracy;
  std::vector<std::string> output_units;  // p, or empty: not known
  std::vector<std::string> input_units;   // m, or empty
  std::vector<std::string> disturbances;  // names of inputs that are such
  std::optional<DisturbanceForm> disturbance_model;  // of the outputs

  // That were left out when the model was read, as no input reaches them and
  // they are unstable or integrate twice (a disturbance model).
  int unreached_states = 0;

  // A valid model with a name for each channel; names are not empty and
  // distinct over inputs and outputs; an accuracy has p values of each kind,
  // units are one for each channel, disturbances are names of inputs; a
  // disturbance model is valid for p outputs.
  absl::Status Validate() const;

  // The channels as those of a process model, all elements zero.
  ProcessModel Channels() const;
  // Takes names, units, roles and unit of time of `channels`.
  void SetChannels(const ProcessModel& channels);
};

}  // namespace mle

#endif  // MLE_MODEL_STATE_SPACE_H_
