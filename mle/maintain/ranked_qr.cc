#include "mle/maintain/ranked_qr.h"

#include <algorithm>

namespace mle {

using Eigen::Index;
using Eigen::MatrixXd;

RankedQr::RankedQr(const MatrixXd& columns, double threshold) : qr_(columns) {
  const Index size = std::min(columns.rows(), columns.cols());
  of_triangle_.setThreshold(threshold);
  of_triangle_.compute(
      qr_.matrixQR().topRows(size).triangularView<Eigen::Upper>());
}

MatrixXd RankedQr::Basis() const {
  const Index size = of_triangle_.rows();
  MatrixXd basis = MatrixXd::Zero(qr_.rows(), rank());
  basis.topRows(size) =
      of_triangle_.householderQ() * MatrixXd::Identity(size, rank());
  basis.applyOnTheLeft(qr_.householderQ());
  return basis;
}

double RankedQr::SquaresLeft(Eigen::VectorXd of) const {
  const Index size = of_triangle_.rows();
  of.applyOnTheLeft(qr_.householderQ().adjoint());
  of.head(size).applyOnTheLeft(of_triangle_.householderQ().adjoint());
  return of.tail(of.size() - rank()).squaredNorm();
}

}  // namespace mle
