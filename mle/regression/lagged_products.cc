#include "mle/regression/lagged_products.h"

#include <algorithm>

#include "glog/logging.h"
#include "mle/regression/kernels/kernels.h"

namespace mle {
namespace {

// Numbers and samples of a segment; columns of products made at once.
constexpr Eigen::Index kSegment = 4096;
constexpr Eigen::Index kFewestSamples = 32;
constexpr Eigen::Index kPanel = 8;

}  // namespace

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
  const Eigen::Index n = X.cols();
  if (n == 0) return Eigen::MatrixXd();
  Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(n, n);
  // The kernels read samples one after the other; those of a segment stay in
  // the cache while all columns are gone through.
  const Eigen::Index segment = std::max(kSegment / n, kFewestSamples);
  Eigen::MatrixXd samples;
  for (Eigen::Index first = 0; first < X.rows(); first += segment) {
    const Eigen::Index count = std::min(segment, X.rows() - first);
    samples = X.middleRows(first, count).transpose();
    // The lower triangle, and what of the upper its panels hold.
    for (Eigen::Index c = 0; c < n; c += kPanel) {
      VectorKernels().add_products({.x = samples.data() + c,
                                    .x_stride = n,
                                    .rows = n - c,
                                    .w = samples.data() + c,
                                    .w_stride = n,
                                    .columns = std::min(kPanel, n - c),
                                    .count = count},
                                   &gram(c, c), n);
    }
  }
  return gram.selfadjointView<Eigen::Lower>();
}

}  // namespace mle
