// What a model misses when it predicts further ahead than one sample.

#ifndef MLE_CORRECTION_PREDICTION_RESIDUALS_H_
#define MLE_CORRECTION_PREDICTION_RESIDUALS_H_

#include "Eigen/Core"
#include "mle/data/lagged_series.h"

namespace mle {

// Measured less predicted outputs, p × rows (latest first, as the series'
// views), less their mean over the rows. The predictions y_{k+1} = R x_k run on
// their own outputs and start anew from measured ones every `horizon` samples;
// 0 never does. R is p × n.
Eigen::MatrixXd PredictionResiduals(const LaggedSeries& series, RowRange rows,
                                    const Eigen::MatrixXd& R, int horizon);

}  // namespace mle

#endif  // MLE_CORRECTION_PREDICTION_RESIDUALS_H_
