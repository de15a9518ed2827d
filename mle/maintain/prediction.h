// What a model misses when it predicts a record.
//
// Horizon h predicts sample k from the outputs up to k − h and the inputs up to
// k − 1; 1 is one step ahead, 0 free simulation, whose mean error is taken off.
// The error is measured less predicted output: p × samples, NaN where there is
// no measurement or not yet a prediction.

#ifndef MLE_MAINTAIN_PREDICTION_H_
#define MLE_MAINTAIN_PREDICTION_H_

#include <functional>
#include <vector>

#include "Eigen/Core"
#include "absl/status/statusor.h"
#include "mle/data/record.h"
#include "mle/model/arx_model.h"
#include "mle/model/process_model.h"
#include "mle/nonlinear/structured_correction.h"

namespace mle {

// Errors of a model on a record whose inputs are all known.
using Predictor =
    std::function<Eigen::MatrixXd(const Record& record, int horizon)>;

// The process model plus a level that is followed in white noise by a Kalman
// filter, diffuse at first (`noise`: p, its ratio q/r; 0 takes the mean of all
// errors so far): ŷ_k = x_k + ŵ_{k−h|k−h}. The first samples, as long as the
// model's largest dead time and time constant, but at most a quarter of the
// record, serve to forget the inputs before and are not predicted.
absl::StatusOr<Predictor> PredictWithProcess(
    const ProcessModel& model, const std::vector<NoiseEstimate>& noise,
    double sample_time);

// y_{k+1} = R x_k, on its own outputs within the horizon. The first d samples,
// and d samples after each that is lost, are not predicted.
Predictor PredictWithArx(const ArxModel& model);

// Outputs lost for up to this many samples in a row have what a model expects
// of them in their place (output_reconstruction.h) where a regression on lagged
// data needs them: it loses as many rows as it has lags for each that is lost.
inline constexpr int kLongestFill = 30;

// `predictor` on records so filled; what was not measured has no error.
absl::StatusOr<Predictor> PredictFilled(const ProcessModel& model,
                                        const std::vector<NoiseEstimate>& noise,
                                        double sample_time,
                                        const Predictor& predictor);

}  // namespace mle

#endif  // MLE_MAINTAIN_PREDICTION_H_
