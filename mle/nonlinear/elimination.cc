#include "mle/nonlinear/elimination.h"

#include <cmath>

namespace mle {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kLeastPivotShare = 1e-12;

}  // namespace

VectorXd Elimination::Coefficients(Index b) const {
  VectorXd coefficients = VectorXd::Zero(rows.cols() - rest.cols());
  for (int i = rank() - 1; i >= 0; --i) {
    double value = rows(i, b);
    for (int k = i + 1; k < rank(); ++k) {
      value -= rows(i, pivots[k]) * coefficients(pivots[k]);
    }
    coefficients(pivots[i]) = value / rows(i, pivots[i]);
  }
  return coefficients;
}

// The diagonal of what is left chooses the next pivot and is updated at each
// step. A row is computed when it is chosen, from the rows before it.
Elimination EliminateFirst(Index count, const MatrixXd& products) {
  Elimination result;
  const Eigen::ArrayXd squares = products.diagonal().head(count);
  // Columns of zeros have nothing to take out.
  const Eigen::ArrayXd inverse =
      (squares > 0.0).select(squares.cwiseInverse(), 0.0);
  Eigen::ArrayXd left = squares;
  MatrixXd rows(products.cols(), count);  // transposed
  while (result.rank() < count) {
    Index pivot = 0;
    const double share = (left * inverse).maxCoeff(&pivot);
    if (!(share > kLeastPivotShare)) break;
    const double value = left(pivot);
    const Index rank = result.rank();
    auto row = rows.col(rank);
    row = products.col(pivot);
    row.noalias() -=
        rows.leftCols(rank) * rows.row(pivot).head(rank).transpose();
    row /= std::sqrt(value);
    for (const Index former : result.pivots) row(former) = 0.0;
    left -= row.head(count).array().square();
    left(pivot) = 0.0;
    result.log_determinant += std::log(value);
    result.pivots.push_back(pivot);
  }
  result.rows = rows.leftCols(result.rank()).transpose();
  const Index rest = products.rows() - count;
  const auto others = result.rows.rightCols(rest);
  result.rest = products.bottomRightCorner(rest, rest);
  result.rest.noalias() -= others.transpose() * others;
  return result;
}

}  // namespace mle
