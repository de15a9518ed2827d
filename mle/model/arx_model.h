// Autoregressive model with exogenous inputs, without a preset input delay:
//
//   y_{k+1} = R [y_k; u_k; …; y_{k−d+1}; u_{k−d+1}],   R: p × d(p+m),
//
// so that coefficient (a−1)(p+m) + c of a row belongs to lag a = 1 … d of
// channel c; channels are the outputs, then the inputs. Deviations from the
// operating point are modelled; an intercept of a fit does not enter.

#ifndef MLE_MODEL_ARX_MODEL_H_
#define MLE_MODEL_ARX_MODEL_H_

#include "Eigen/Core"
#include "absl/status/status.h"
#include "mle/model/step_response.h"

namespace mle {

struct ArxModel {
  double sample_time = 0.0;  // Δt
  int order = 0;             // d
  int num_outputs = 0;       // p
  int num_inputs = 0;        // m
  Eigen::MatrixXd R;         // p × d(p+m)

  absl::Status Validate() const;

  int num_channels() const { return num_outputs + num_inputs; }
  int num_regressors() const { return order * num_channels(); }

  // From rest, each input stepped to 1 at k = 0: φ_0 = 0. Grows without bound
  // if the model is unstable, then saturates at ±1e100 instead of overflowing.
  StepResponse ComputeStepResponse(int samples) const;
};

}  // namespace mle

#endif  // MLE_MODEL_ARX_MODEL_H_
