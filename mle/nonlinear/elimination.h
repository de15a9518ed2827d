// Least squares by the matrix of products of its columns. Internal to
// mle/nonlinear.

#ifndef MLE_NONLINEAR_ELIMINATION_H_
#define MLE_NONLINEAR_ELIMINATION_H_

#include "Eigen/Core"

namespace mle {

struct Elimination {
  Eigen::MatrixXd rest;          // B'B − B'A (A'A)⁺ A'B
  double log_determinant = 0.0;  // of A'A, of a largest independent part
  int rank = 0;                  // of A
};

// The first `count` columns A taken out of `products` = (A B)'(A B), by pivots
// on the diagonal, the largest share of a column's own square first; a column
// of which less than 1e-12 is left depends on those before it. What is left of
// a column of B is accurate to 1e-16 of its own square: nothing of what A
// explains may be a million times as large as what it does not.
Elimination EliminateFirst(Eigen::Index count, Eigen::MatrixXd products);

}  // namespace mle

#endif  // MLE_NONLINEAR_ELIMINATION_H_
