// Sums over rows of lagged regressors x_k (n) and responses e_k (q):
//
//   S = Σ x_k x_kᵀ,  Σ x_k e_kᵀ,  Σ x_k,  Σ e_k,  Σ e_k².
//
// They are additive over sets of rows, and all a linear regression on those
// rows needs; centring and scaling come afterwards (lasso_problem.h). First
// sums are kept by group (g of them): rows of a group share an intercept.
//
// S is built without forming X. For consecutive rows k₀ … k₁ the c × c blocks
// obey
//
//   S_{a+1,b+1} = S_{a,b} + z_{k₀−2−a} z_{k₀−2−b}ᵀ − z_{k₁−1−a} z_{k₁−1−b}ᵀ,
//
// that is, S less its own shift by one block has rank 2c per range of rows.
// Only the first block column is a sum over the data: 2cnN operations instead
// of n²N, then 4rn² for r ranges. Memory O(n² + N(c + q)).
//
// The recursion accumulates rounding of the size of all terms that entered it.
// The diagonal is therefore summed directly, so that a column that is constant
// on these rows is recognised; and so is the block column of a lag at which a
// channel is smaller by orders of magnitude than at the lags before, which
// rounding would otherwise dominate (a channel that moves in its newest samples
// only, or after a bad value of 1e8).

#ifndef MLE_REGRESSION_LAGGED_MOMENTS_H_
#define MLE_REGRESSION_LAGGED_MOMENTS_H_

#include <cstdint>
#include <vector>

#include "Eigen/Core"
#include "absl/types/span.h"
#include "mle/data/lagged_series.h"

namespace mle {

// Consecutive rows of one series and their responses.
struct RegressionRows {
  const LaggedSeries* series = nullptr;
  RowRange rows;
  // q × rows, column i belongs to sample last − i (as the series' views).
  Eigen::MatrixXd responses;
  int group = 0;
};

struct LaggedMoments {
  std::int64_t rows = 0;             // N
  Eigen::MatrixXd gram;              // n × n, Σ x xᵀ
  Eigen::MatrixXd cross;             // n × q, Σ x eᵀ
  Eigen::VectorXd response_squares;  // q, Σ e²
  // By group.
  Eigen::VectorXd group_rows;     // g, adding up to N
  Eigen::MatrixXd regressor_sum;  // n × g
  Eigen::MatrixXd response_sum;   // q × g

  // All zero.
  static LaggedMoments Zero(int num_regressors, int num_responses,
                            int num_groups = 1);

  int num_groups() const { return static_cast<int>(group_rows.size()); }
  int num_regressors() const { return static_cast<int>(gram.rows()); }
  int num_responses() const { return static_cast<int>(cross.cols()); }

  LaggedMoments& operator+=(const LaggedMoments& other);
};

// Sums over all `rows`, which share n and q and belong to groups below
// `num_groups`. Values must be finite.
LaggedMoments ComputeLaggedMoments(absl::Span<const RegressionRows> rows,
                                   int num_groups = 1);

}  // namespace mle

#endif  // MLE_REGRESSION_LAGGED_MOMENTS_H_
