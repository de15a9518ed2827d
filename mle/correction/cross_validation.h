// Losses of lasso fits on rows they have not seen.
//
// Each fold is predicted by a fit to all the others. One step ahead its loss
//
//   V(λ) = 1/(2N_f) Σ_k (e_k − ê_k(λ))²
//
// is known exactly for every λ (validation_loss.h); further ahead it is
// computed by simulation at given λ.

#ifndef MLE_CORRECTION_CROSS_VALIDATION_H_
#define MLE_CORRECTION_CROSS_VALIDATION_H_

#include <vector>

#include "Eigen/Core"
#include "absl/status/statusor.h"
#include "mle/correction/folds.h"
#include "mle/correction/regression_data.h"
#include "mle/regression/lasso_solver.h"
#include "mle/regression/piecewise_quadratic.h"

namespace mle {

struct CrossValidationOptions {
  Scaling scaling = Scaling::kStandardise;
  Eigen::MatrixXd penalty_weights;  // p × n, or empty for ones
  // Samples predicted before measured outputs are used again: 1 one step ahead,
  // 0 never (free simulation of each run of rows).
  int horizon = 1;
  Eigen::VectorXd grid;     // of the fits, ascending
  Eigen::VectorXd lambdas;  // where losses are wanted, ascending
  LassoSolverOptions solver;
};

struct FoldLosses {
  // For every output: folds × lambdas, V of each fold.
  std::vector<Eigen::MatrixXd> values;
  // One step ahead: for every fold and output, V times the fold's weight.
  std::vector<std::vector<PiecewiseQuadratic>> exact;
  // At each λ, of all outputs: Σ_folds weight λ Σ_j |β_j|. One step ahead only.
  Eigen::VectorXd penalty;
  Eigen::VectorXd weight;         // of each fold: its rows over the mean fold's
  double max_relative_gap = 0.0;  // of all fits, at every λ of the grid

  // Adds the folds of another partition of the rows.
  void Append(FoldLosses more);
};

// The weights of one output's coefficients; empty for ones.
Eigen::VectorXd PenaltyWeights(const Eigen::MatrixXd& all, int output);

// At least two folds.
absl::StatusOr<FoldLosses> CrossValidate(const RegressionData& data,
                                         const std::vector<Fold>& folds,
                                         const CrossValidationOptions& options);

}  // namespace mle

#endif  // MLE_CORRECTION_CROSS_VALIDATION_H_
