// Products of lagged regressors, whose columns overlap, with a few series.
//
//   S ← S + X Wᵀ = S + Σ_k x_k w_kᵀ,
//
// X n × N as a view with outer stride c (lagged_series.h), W q × N, S n × q. A
// general matrix product first copies X into packed panels: n numbers for each
// of N columns, where only c are new. Here tiles of S stay in registers while k
// runs, and x_k is read where it lies; the samples of one segment of k fit into
// the first level cache and serve all tiles. 2nqN operations.

#ifndef MLE_REGRESSION_LAGGED_PRODUCTS_H_
#define MLE_REGRESSION_LAGGED_PRODUCTS_H_

#include "Eigen/Core"
#include "mle/data/lagged_series.h"

namespace mle {

// Sums run over segments of k and then over the segments, in an order that
// depends on the shapes and the processor's vectors alone.
void AddLaggedProducts(
    const LaggedSeries::View& x,
    const Eigen::Ref<const Eigen::MatrixXd, 0, Eigen::OuterStride<>>& w,
    Eigen::Ref<Eigen::MatrixXd> sums);

// XᵀX of N × n numbers by columns, by the same kernels: 2n²N operations.
Eigen::MatrixXd GramMatrix(const Eigen::Ref<const Eigen::MatrixXd>& X);

}  // namespace mle

#endif  // MLE_REGRESSION_LAGGED_PRODUCTS_H_
