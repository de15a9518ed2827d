#include "mle/regression/active_columns.h"

namespace mle {

void MultiplyActive(const Eigen::MatrixXd& gram, absl::Span<const int> active,
                    const double* x, const double* q, Eigen::VectorXd& gx,
                    Eigen::VectorXd& gq) {
  const Eigen::Index n = gram.rows();
  gx.setZero(n);
  gq.setZero(n);
  double* out_x = gx.data();
  double* out_q = gq.data();
  std::size_t i = 0;
  // Four columns at a time, so that the results are read and written less.
  for (; i + 4 <= active.size(); i += 4) {
    const double* g0 = gram.col(active[i]).data();
    const double* g1 = gram.col(active[i + 1]).data();
    const double* g2 = gram.col(active[i + 2]).data();
    const double* g3 = gram.col(active[i + 3]).data();
    const double x0 = x[i], x1 = x[i + 1], x2 = x[i + 2], x3 = x[i + 3];
    const double q0 = q[i], q1 = q[i + 1], q2 = q[i + 2], q3 = q[i + 3];
    for (Eigen::Index j = 0; j < n; ++j) {
      out_x[j] += (x0 * g0[j] + x1 * g1[j]) + (x2 * g2[j] + x3 * g3[j]);
      out_q[j] += (q0 * g0[j] + q1 * g1[j]) + (q2 * g2[j] + q3 * g3[j]);
    }
  }
  for (; i < active.size(); ++i) {
    gx += x[i] * gram.col(active[i]);
    gq += q[i] * gram.col(active[i]);
  }
}

}  // namespace mle
