// Products with a few columns of a large matrix.

#ifndef MLE_REGRESSION_ACTIVE_COLUMNS_H_
#define MLE_REGRESSION_ACTIVE_COLUMNS_H_

#include "Eigen/Core"
#include "absl/types/span.h"
#include "mle/regression/kernels/arguments.h"

namespace mle {

// gx = G_·A x and gq = G_·A q in one pass over the columns A of G (n × n),
// which is bound by reading them: 8n|A| bytes. x and q have |A| entries, gx and
// gq n.
void MultiplyActive(const Eigen::MatrixXd& gram, absl::Span<const int> active,
                    const double* x, const double* q, Eigen::VectorXd& gx,
                    Eigen::VectorXd& gq);

// The columns A of G, for the kernels.
ColumnSet ActiveColumns(const Eigen::MatrixXd& gram,
                        absl::Span<const int> active);

}  // namespace mle

#endif  // MLE_REGRESSION_ACTIVE_COLUMNS_H_
