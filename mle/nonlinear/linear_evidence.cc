#include "mle/nonlinear/linear_evidence.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "Eigen/Cholesky"
#include "mle/regression/lagged_products.h"

namespace mle {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// The equations from which the coefficients of positive variance are solved.
struct Reduced {
  std::vector<int> active;
  VectorXd roots;  // D½ of them
  MatrixXd M;
  VectorXd right;        // D½ b̃
  double squares = 0.0;  // ẽᵀẽ
};

Reduced Reduce(const MatrixXd& gram, const VectorXd& products, double squares,
               const LinearPrior& prior, double noise_variance) {
  Reduced reduced;
  for (Eigen::Index i = 0; i < prior.variances.size(); ++i) {
    if (prior.variances(i) > 0.0) reduced.active.push_back(static_cast<int>(i));
  }
  reduced.squares = squares;
  VectorXd shifted = products;
  if (!prior.means.isZero(0.0)) {
    const VectorXd moved = gram * prior.means;
    reduced.squares += prior.means.dot(moved) - 2.0 * prior.means.dot(products);
    shifted -= moved;
  }
  reduced.roots = prior.variances(reduced.active).cwiseSqrt();
  reduced.M = reduced.roots.asDiagonal() *
              gram(reduced.active, reduced.active) *
              (reduced.roots / noise_variance).asDiagonal();
  reduced.M.diagonal().array() += 1.0;
  reduced.right = reduced.roots.cwiseProduct(shifted(reduced.active));
  return reduced;
}

double LogDeterminant(const Eigen::LLT<MatrixXd>& factor) {
  return 2.0 * factor.matrixLLT().diagonal().array().log().sum();
}

}  // namespace

LinearEvidence::LinearEvidence(const MatrixXd& X, const VectorXd& e,
                               double rows, double constant)
    : LinearEvidence(GramMatrix(X), X.transpose() * e, e.squaredNorm(), rows,
                     constant) {}

LinearEvidence::LinearEvidence(MatrixXd gram, VectorXd products, double squares,
                               double rows, double constant)
    : gram_(std::move(gram)),
      products_(std::move(products)),
      squares_(squares),
      rows_(rows),
      constant_(constant) {}

double LinearEvidence::Deviance(const LinearPrior& prior,
                                double noise_variance) const {
  const Reduced reduced =
      Reduce(gram_, products_, squares_, prior, noise_variance);
  const Eigen::LLT<MatrixXd> factor(reduced.M);
  const double explained =
      factor.matrixL().solve(reduced.right).squaredNorm() / noise_variance;
  return constant_ + rows_ * std::log(noise_variance) + LogDeterminant(factor) +
         (reduced.squares - explained) / noise_variance;
}

LinearPosterior LinearEvidence::Posterior(const LinearPrior& prior,
                                          double noise_variance) const {
  const Reduced reduced =
      Reduce(gram_, products_, squares_, prior, noise_variance);
  const Eigen::Index n = prior.variances.size();
  const auto size = static_cast<Eigen::Index>(reduced.active.size());
  const Eigen::LLT<MatrixXd> factor(reduced.M);
  const MatrixXd inverse = factor.solve(MatrixXd::Identity(size, size));
  LinearPosterior posterior;
  posterior.noise_variance = noise_variance;
  posterior.means = prior.means;
  posterior.covariance = MatrixXd::Zero(n, n);
  const VectorXd change =
      reduced.roots.cwiseProduct(inverse * reduced.right) / noise_variance;
  for (Eigen::Index a = 0; a < size; ++a) {
    posterior.means(reduced.active[a]) += change(a);
    for (Eigen::Index b = 0; b < size; ++b) {
      posterior.covariance(reduced.active[a], reduced.active[b]) =
          reduced.roots(a) * inverse(a, b) * reduced.roots(b);
    }
  }
  const double explained =
      reduced.right.dot(inverse * reduced.right) / noise_variance;
  posterior.deviance = constant_ + rows_ * std::log(noise_variance) +
                       LogDeterminant(factor) +
                       (reduced.squares - explained) / noise_variance;
  // ‖e − X a‖² at the means; tr(I − M⁻¹) coefficients are taken up.
  const double left = squares_ - 2.0 * posterior.means.dot(products_) +
                      posterior.means.dot(gram_ * posterior.means);
  const double taken = static_cast<double>(size) - inverse.trace();
  posterior.next_noise_variance =
      std::max(left, 1e-26 * squares_) / std::max(rows_ - taken, 1.0);
  return posterior;
}

}  // namespace mle
