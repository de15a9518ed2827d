// Residuals of predictions further ahead than one sample.
//
// Predictions y_{k+1} = R x_k run on their own outputs and start anew from
// measured ones every h samples, counted from the first row; h = 0 never does.
// Their residuals e follow from the one-step residuals, r_k = y_k − R x_k with
// all outputs measured:
//
//   e_k = r_k + Σ_l A_l e_{k−l},   l = 1 … min(s, d),
//
// A_l the p × p block of R for outputs l samples back, s the samples since the
// last start. So the d(p + m) regressors are gone through once, and the s steps
// by the outputs alone.

#ifndef MLE_CORRECTION_PREDICTION_RESIDUALS_H_
#define MLE_CORRECTION_PREDICTION_RESIDUALS_H_

#include <vector>

#include "Eigen/Core"
#include "absl/types/span.h"
#include "mle/correction/folds.h"
#include "mle/correction/regression_data.h"
#include "mle/data/lagged_series.h"

namespace mle {

// e, p × rows (latest first, as the series' views), less its mean over the
// rows. R is p × n, `horizon` ≥ 0.
Eigen::MatrixXd PredictionResiduals(const LaggedSeries& series, RowRange rows,
                                    const Eigen::MatrixXd& R, int horizon);

// Losses on one fold of many models R + ΔR, ½ mean e², where each run of rows
// that has a part in the fold is predicted from its first row on.
class AheadLosses {
 public:
  // Both must outlive the object.
  AheadLosses(const RegressionData& data, const Fold& fold, int horizon);

  // p × models, infinite where a model diverges. `changes` are ΔR (p × n).
  Eigen::MatrixXd Of(absl::Span<const Eigen::MatrixXd> changes) const;

 private:
  struct Run {
    const RegressionRows* rows = nullptr;
    std::vector<RowRange> parts;  // of the fold
    // (rows + d) × c: every channel, latest first, so that its values l samples
    // before the rows begin at l.
    Eigen::MatrixXd channels;
  };
  // r of two models, rows × 2p; the second may be nullptr.
  Eigen::MatrixXd OneStep(const Run& run, const Eigen::MatrixXd& first,
                          const Eigen::MatrixXd* second) const;
  void AddSquares(const Run& run, const Eigen::MatrixXd& R,
                  Eigen::MatrixXd residuals,
                  Eigen::Ref<Eigen::VectorXd> squares) const;

  const RegressionData& data_;
  const int horizon_;
  std::vector<Run> runs_;
  double rows_ = 0.0;  // in the fold
};

}  // namespace mle

#endif  // MLE_CORRECTION_PREDICTION_RESIDUALS_H_
