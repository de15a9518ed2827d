#include "mle/nonlinear/elimination.h"

#include <cmath>

namespace mle {
namespace {

using Eigen::Index;
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

Elimination EliminateFirst(Index count, Eigen::MatrixXd products) {
  Elimination result;
  result.rows.resize(count, products.cols());
  const Eigen::ArrayXd squares = products.diagonal().head(count);
  // Columns of zeros have nothing to take out.
  const Eigen::ArrayXd inverse =
      (squares > 0.0).select(squares.cwiseInverse(), 0.0);
  while (result.rank() < count) {
    Index pivot = 0;
    const double share =
        (products.diagonal().head(count).array() * inverse).maxCoeff(&pivot);
    if (!(share > kLeastPivotShare)) break;
    const double value = products(pivot, pivot);
    auto row = result.rows.row(result.rank());
    row = products.row(pivot) / std::sqrt(value);
    products.noalias() -= row.transpose() * row;
    products.col(pivot).setZero();
    products.row(pivot).setZero();
    result.log_determinant += std::log(value);
    result.pivots.push_back(pivot);
  }
  result.rows.conservativeResize(result.rank(), Eigen::NoChange);
  const Index rest = products.rows() - count;
  result.rest = products.bottomRightCorner(rest, rest);
  return result;
}

}  // namespace mle
