#include "mle/regression/active_columns.h"

#include "mle/regression/kernels/kernels.h"

namespace mle {

void MultiplyActive(const Eigen::MatrixXd& gram, absl::Span<const int> active,
                    const double* x, const double* q, Eigen::VectorXd& gx,
                    Eigen::VectorXd& gq) {
  gx.setZero(gram.rows());
  gq.setZero(gram.rows());
  VectorKernels().multiply_columns(ActiveColumns(gram, active), x, q,
                                   gram.rows(), gx.data(), gq.data());
}

ColumnSet ActiveColumns(const Eigen::MatrixXd& gram,
                        absl::Span<const int> active) {
  return {gram.data(), gram.outerStride(), active.data(),
          static_cast<std::ptrdiff_t>(active.size())};
}

}  // namespace mle
