#include "mle/nonlinear/amplitude_fit.h"

#include <cmath>
#include <utility>

namespace mle {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

}  // namespace

AmplitudeFit::AmplitudeFit(MatrixXd columns)
    : norms_(columns.colwise().norm().cwiseMax(1e-300)),
      scaled_(std::move(columns)) {
  if (scaled_.cols() == 0) return;  // a QR of nothing is refused
  scaled_ *= norms_.cwiseInverse().asDiagonal();
  qr_.setThreshold(kAmplitudeTolerance);
  qr_.compute(scaled_);
}

double AmplitudeFit::LogDeterminant() const {
  double sum = 0.0;
  for (Eigen::Index i = 0; i < rank(); ++i) {
    sum += 2.0 * std::log(std::abs(qr_.matrixQR()(i, i)) *
                          norms_(qr_.colsPermutation().indices()(i)));
  }
  return sum;
}

VectorXd AmplitudeFit::Solve(const VectorXd& residuals) const {
  if (scaled_.cols() == 0) return VectorXd();
  if (rank() == scaled_.cols()) {
    return qr_.solve(residuals).cwiseQuotient(norms_);
  }
  Eigen::CompleteOrthogonalDecomposition<MatrixXd> decomposition;
  decomposition.setThreshold(kAmplitudeTolerance);
  decomposition.compute(scaled_);
  return decomposition.solve(residuals).cwiseQuotient(norms_);
}

void AmplitudeFit::TakeOut(Eigen::Ref<MatrixXd> columns) const {
  if (rank() == 0) return;
  const MatrixXd basis =
      qr_.householderQ() * MatrixXd::Identity(scaled_.rows(), rank());
  columns.noalias() -= basis * (basis.transpose() * columns);
}

}  // namespace mle
