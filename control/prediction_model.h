// The model of a predictive controller: step responses at the control
// instants, for every input,
//
//   y_{l+k} = S_k u,  k = 0 … n, for inputs that step from 0 to u at instant l;
//   S_0 = 0, and S_k = S_n + (k − n) R beyond n,
//
// with the slopes R of pairs that end in a ramp (levels); 0 for the others.
//
// It can be made from each kind of model; the ARX model R̂ of a correction is
// used directly:
//
//   MLE_ASSIGN_OR_RETURN(const PredictionModel model,
//                        PredictFromArx(corrected, {}, 1.0));
//   MLE_ASSIGN_OR_RETURN(Mpc mpc, Mpc::Create(model, options));

#ifndef CONTROL_PREDICTION_MODEL_H_
#define CONTROL_PREDICTION_MODEL_H_

#include <vector>

#include "Eigen/Core"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "mle/model/arx_model.h"
#include "mle/model/process_model.h"
#include "mle/model/step_response.h"

namespace mle::control {

struct PredictionModel {
  double control_period = 0.0;   // Δt_c > 0
  int num_outputs = 0;           // p
  std::vector<InputRole> roles;  // of the m inputs
  // S_0; …; S_n, one below the other: p(n+1) × m.
  Eigen::MatrixXd responses;
  // R: p × m, by control period. Empty: no pair ends in a ramp.
  Eigen::MatrixXd slopes = {};

  // Shapes agree, n ≥ 1, every value is finite, S_0 is zero.
  absl::Status Validate() const;

  int num_inputs() const { return static_cast<int>(roles.size()); }  // m
  int periods() const;                                               // n
  bool IsIntegrating() const {
    return slopes.size() > 0 && !slopes.isZero(0.0);
  }
  // R of these inputs: p × their number.
  Eigen::MatrixXd SlopesOf(const std::vector<int>& inputs) const;
  // Carries the responses on to instant `instants`, where n is less.
  void ReachTo(int instants);
  // The inputs of a role, in order.
  std::vector<int> InputsOf(InputRole role) const;
};

// The last tenth of a settled response stays within this part of the response's
// largest magnitude. A first-order response held where it is cut off then is
// within about 2 % of its final value.
inline constexpr double kSettlingTolerance = 0.01;

// Carried until the model has settled, or its ramps are straight, to about
// 1e-11 of its gains.
//
// InvalidArgument for an invalid model, and one that settles so slowly that its
// step responses would hold over 10⁸ values.
absl::StatusOr<PredictionModel> PredictFromProcess(const ProcessModel& model,
                                                   double control_period);

// `roles` (m) may be empty: all inputs are manipulated. Δt_c must be a whole
// multiple of Δt, and the responses must start at zero.
//
// FailedPrecondition, naming the pair, for a response that has not settled at
// its end, or that integrates and is no ramp there: it is too short, unstable,
// or integrates unknown to the response, and to go on from it would predict
// wrongly.
absl::StatusOr<PredictionModel> PredictFromStepResponse(
    const StepResponse& response, const std::vector<InputRole>& roles,
    double control_period, double settling_tolerance = kSettlingTolerance);

// As above, with a response long enough for what remains at its end to be
// negligible, but of at most `max_duration` (in the model's time unit; 0 takes
// 200 times the memory dΔt of the model).
absl::StatusOr<PredictionModel> PredictFromArx(
    const ArxModel& model, const std::vector<InputRole>& roles,
    double control_period, double max_duration = 0.0);

}  // namespace mle::control

#endif  // CONTROL_PREDICTION_MODEL_H_
