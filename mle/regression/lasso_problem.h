// Lasso problems in terms of second moments.
//
// For each response, with X̃ and ẽ the regressors and the response after
// centring and scaling,
//
//   minimise  f(β) = ½ βᵀGβ − Cᵀβ + ½v + λ Σ_j w_j |β_j|
//           = 1/(2N) ‖ẽ − X̃ᵀβ‖² + λ Σ_j w_j |β_j|,
//   G = X̃X̃ᵀ/N,  C = X̃ẽ/N,  v = ‖ẽ‖²/N.
//
// Standardised as MATLAB's `lasso` does by default: centred, each regressor of
// unit variance (1/N), the response not scaled. A fit in original units is
// e ≈ b₀ + bᵀx with b_j = β_j / scale_j. Where the rows are in groups, each
// group is centred by its own means, that is, has an intercept b₀ of its own.

#ifndef MLE_REGRESSION_LASSO_PROBLEM_H_
#define MLE_REGRESSION_LASSO_PROBLEM_H_

#include <cstdint>
#include <vector>

#include "Eigen/Core"
#include "absl/status/status.h"
#include "mle/regression/lagged_moments.h"
#include "mle/regression/lasso_options.h"

namespace mle {

// The problems of q responses on the same regressors.
struct LassoProblem {
  std::int64_t rows = 0;        // N
  Eigen::MatrixXd gram;         // n × n, G
  Eigen::MatrixXd correlation;  // n × q, C of each response
  // q, v; 0, as is its column of C, for a response without variation.
  Eigen::VectorXd response_square;
  Eigen::VectorXd group_rows;      // g, adding up to N
  Eigen::MatrixXd regressor_mean;  // n × g; zero when raw, or without rows
  Eigen::MatrixXd response_mean;   // q × g; likewise
  Eigen::VectorXd scale;           // n; 1 when raw, 0 for a constant column
  // Columns without variation. Their rows and columns of G are zero and their
  // coefficients stay zero.
  std::vector<int> constant_regressors;

  int num_regressors() const { return static_cast<int>(gram.rows()); }
  int num_responses() const { return static_cast<int>(correlation.cols()); }

  // b of a solution β, in the regressors' own units; 0 for constant columns.
  Eigen::VectorXd Unscale(const Eigen::VectorXd& beta) const;
};

// Works in place on the moments' Gram matrix, which it takes over; they are of
// at least one row.
LassoProblem MakeLassoProblem(LaggedMoments moments, Scaling scaling);

// One response's problem with its penalty weights; refers to `gram`.
struct LassoObjective {
  const Eigen::MatrixXd* gram = nullptr;  // n × n, symmetric, both triangles
  Eigen::VectorXd correlation;            // n
  double response_square = 0.0;           // v
  // n, w_j ≥ 0: 0 = not penalised, ∞ = excluded.
  Eigen::VectorXd weights;

  LassoObjective(const LassoProblem& problem, int response,
                 const Eigen::VectorXd& penalty_weights = {});
  LassoObjective() = default;

  int size() const { return static_cast<int>(correlation.size()); }

  // Sizes agree, values finite, weights not negative and not all infinite.
  absl::Status Validate() const;

  // Smallest λ at which no penalised coefficient enters, where none is without
  // penalty: max_j |C_j| / w_j.
  double LambdaMax() const;
};

}  // namespace mle

#endif  // MLE_REGRESSION_LASSO_PROBLEM_H_
