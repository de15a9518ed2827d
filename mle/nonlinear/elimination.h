// Least squares by the products of its columns. Internal to the libraries.

#ifndef MLE_NONLINEAR_ELIMINATION_H_
#define MLE_NONLINEAR_ELIMINATION_H_

#include <vector>

#include "Eigen/Core"

namespace mle {

// The first columns A of (A B) taken out: with rows U, as many as the rank of
// A, of Cholesky's factor,
//
//   (A B)ᵀ(A B) = UᵀU + (0 0; 0 rest),   rest = BᵀB − BᵀA (AᵀA)⁺ AᵀB.
struct Elimination {
  std::vector<Eigen::Index> pivots;  // independent columns of A, in turn
  Eigen::MatrixXd rows;              // U: rank × columns
  Eigen::MatrixXd rest;
  double log_determinant = 0.0;  // of the products of the pivots

  int rank() const { return static_cast<int>(pivots.size()); }
  // The coefficients of column `b` (of A and B) by least squares on A, 0 but
  // for the pivots.
  Eigen::VectorXd Coefficients(Eigen::Index b) const;
};

// Eliminates A from `products` = (A B)ᵀ(A B), A the first `count` columns, by
// pivots on the diagonal, the largest share of a column's own square first; a
// column of which less than 1e-12 is left depends on those before it. What is
// left of a column of B is accurate to 1e-16 of its own square: what A explains
// may not be a million times as large as what it does not.
Elimination EliminateFirst(Eigen::Index count, const Eigen::MatrixXd& products);

}  // namespace mle

#endif  // MLE_NONLINEAR_ELIMINATION_H_
