#include "mle/trial/change_window.h"

#include <algorithm>
#include <cmath>

#include "Eigen/Cholesky"
#include "Eigen/Eigenvalues"

namespace mle {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// δ: directions with less noise than this are not trusted.
constexpr double kLeastNoise = 0.05;
// Shapes that are nearly those of others decide nothing.
constexpr double kRidge = 1e-6;

}  // namespace

double Variogram::at(Index l) const {
  if (l == 0) return 0.0;
  return counts(l - 1) > 0.0 ? sums(l - 1) / counts(l - 1) : 0.0;
}

MatrixXd LossMatrix(const Variogram& noise, const std::vector<bool>& known) {
  std::vector<Index> rows;
  for (std::size_t k = 0; k < known.size(); ++k) {
    if (known[k]) rows.push_back(static_cast<Index>(k));
  }
  const auto total = static_cast<Index>(known.size());
  const auto n = static_cast<Index>(rows.size());
  MatrixXd loss = MatrixXd::Zero(total, total);
  if (n < 2) return loss;
  MatrixXd covariance(n, n);
  for (Index k = 0; k < n; ++k) {
    for (Index l = 0; l < n; ++l) {
      covariance(k, l) = -noise.at(std::abs(rows[k] - rows[l]));
    }
  }
  // P Γ P.
  const VectorXd means = covariance.rowwise().mean();
  covariance.colwise() -= means;
  covariance.rowwise() -= means.transpose();
  covariance.array() += means.mean();
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(covariance);
  VectorXd values = solver.eigenvalues().cwiseMax(0.0);
  if (!(values.sum() > 0.0)) return loss;
  values.array() += kLeastNoise * values.sum() / static_cast<double>(n - 1);
  // Of directions without a constant.
  MatrixXd inverse = solver.eigenvectors() *
                     values.cwiseInverse().asDiagonal() *
                     solver.eigenvectors().transpose();
  const VectorXd level = inverse.rowwise().mean();
  inverse.colwise() -= level;
  inverse.rowwise() -= level.transpose();
  inverse.array() += level.mean();
  loss(rows, rows) = inverse;
  return loss;
}

ExplainedLoss ExplainLoss(const MatrixXd& loss, double directions,
                          const MatrixXd& shapes, const VectorXd& residuals) {
  const MatrixXd weighted = shapes * loss;  // q × n
  MatrixXd normal = weighted * shapes.transpose();
  const double size = normal.diagonal().maxCoeff();
  ExplainedLoss result;
  if (!(size > 0.0)) return result;
  normal.diagonal().array() += kRidge * size;
  const VectorXd v = weighted * residuals;
  const double explained = v.dot(normal.ldlt().solve(v));
  const auto q = static_cast<double>(shapes.rows());
  result.explained = explained - q;
  const double left = residuals.dot(loss * residuals) - explained;
  if (directions > q) result.unusual = left / (directions - q);
  return result;
}

}  // namespace mle
