#include "mle/regression/lagged_products.h"

#include "glog/logging.h"
#include "mle/regression/kernels/kernels.h"

namespace mle {

void AddLaggedProducts(
    const LaggedSeries::View& x,
    const Eigen::Ref<const Eigen::MatrixXd, 0, Eigen::OuterStride<>>& w,
    Eigen::Ref<Eigen::MatrixXd> sums) {
  CHECK_EQ(x.cols(), w.cols());
  CHECK_EQ(x.rows(), sums.rows());
  CHECK_EQ(w.rows(), sums.cols());
  VectorKernels().add_products({x.data(), x.outerStride(), x.rows(), w.data(),
                                w.outerStride(), w.rows(), x.cols()},
                               sums.data(), sums.outerStride());
}

Eigen::MatrixXd GramMatrix(const Eigen::Ref<const Eigen::MatrixXd>& X) {
  if (X.cols() == 0) return Eigen::MatrixXd();
  // The kernels read samples one after the other.
  const Eigen::MatrixXd samples = X.transpose();
  Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(X.cols(), X.cols());
  AddLaggedProducts(
      LaggedSeries::View(samples.data(), samples.rows(), samples.cols(),
                         Eigen::OuterStride<>(samples.rows())),
      samples, gram);
  // The kernels may sum the two halves in different orders.
  return gram.selfadjointView<Eigen::Lower>();
}

}  // namespace mle
