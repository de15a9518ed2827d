#include "mle/nonlinear/elimination.h"

#include <cmath>
#include <utility>

namespace mle {
namespace {

constexpr double kLeastShare = 1e-12;

}  // namespace

Elimination EliminateFirst(Eigen::Index count, Eigen::MatrixXd products) {
  Elimination result;
  const Eigen::ArrayXd squares = products.diagonal().head(count);
  // Columns of zeros have nothing to take out.
  const Eigen::ArrayXd inverse =
      (squares > 0.0).select(squares.cwiseInverse(), 0.0);
  Eigen::VectorXd column(products.rows());
  for (Eigen::Index i = 0; i < count; ++i) {
    Eigen::Index pivot = 0;
    const double share =
        (products.diagonal().head(count).array() * inverse).maxCoeff(&pivot);
    if (!(share > kLeastShare)) break;
    const double value = products(pivot, pivot);
    column = products.col(pivot);
    products.noalias() -= (column / value) * column.transpose();
    products.col(pivot).setZero();
    products.row(pivot).setZero();
    result.log_determinant += std::log(value);
    ++result.rank;
  }
  const Eigen::Index rest = products.rows() - count;
  result.rest = products.bottomRightCorner(rest, rest);
  return result;
}

}  // namespace mle
