// Errors of a model that predicts a record.
//
// Horizon h predicts sample k from the outputs up to k − h and the inputs up to
// k − 1; 1 is one step ahead, 0 free simulation, whose mean error is taken off,
// of integrating outputs the line nearest to the errors: neither the level at
// the begin nor what balances the output is known.
// The error is measured less predicted output: p × samples, NaN where there is
// no measurement or not yet a prediction.

#ifndef MLE_MAINTAIN_PREDICTION_H_
#define MLE_MAINTAIN_PREDICTION_H_

#include <functional>
#include <vector>

#include "Eigen/Core"
#include "absl/status/statusor.h"
#include "mle/data/record.h"
#include "mle/maintain/estimation.h"
#include "mle/model/arx_model.h"
#include "mle/model/process_model.h"

namespace mle {

// The response of a model to the inputs of a record (p × samples), settled at
// the first inputs.
struct InputResponse {
  std::function<absl::StatusOr<Eigen::MatrixXd>(const Record& record)> response;
  // Samples after which the inputs before a record are forgotten: the largest
  // dead time and time constant, or the order.
  int forgetting = 0;
  std::vector<bool> integrating = {};  // p: outputs; empty: none
};

// InvalidArgument where the model cannot be simulated.
absl::StatusOr<InputResponse> ResponseOf(const ProcessModel& model,
                                         double sample_time);
// In free run: y_{k+1} = R x_k on its own outputs.
InputResponse ResponseOf(const ArxModel& model);

// For each output (p) the ratio q/r, from 1e-8 to 1e6, of a random walk to
// white noise under which what the model leaves of `windows` is most likely
// (innovations_filter.h).
absl::StatusOr<Eigen::VectorXd> FitLevelRatios(
    const InputResponse& model, const std::vector<Record>& windows);

// The response x plus a level that is followed in white noise by a Kalman
// filter, diffuse at first (`ratios`: p, its q/r; 0 takes the mean of all
// errors so far): ŷ_k = x_k + ŵ_{k−h|k−h}. The level of an integrating output
// has a constant slope, unknown at first. The samples that the model needs to
// forget, its lead among them, but at most a quarter of what follows the lead,
// are not predicted.
Predictor PredictWithLevel(const InputResponse& model,
                           const Eigen::VectorXd& ratios);

// The same with the ratios of these windows.
absl::StatusOr<Predictor> PredictAsIn(const std::vector<Record>& windows,
                                      const InputResponse& model);

}  // namespace mle

#endif  // MLE_MAINTAIN_PREDICTION_H_
