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
// Windows' lengths at rest before a response is judged, and of all rows, where
// there is too little rest.
constexpr double kLeastAtRest = 3.0;
constexpr double kLeastOfAll = 20.0;
// Share of the rows of a response that must be known.
constexpr double kLeastKnown = 0.8;

// What shapes explain of residuals, and what they leave over what they would
// leave of noise alone.
struct ExplainedLoss {
  double explained = 0.0;
  double unusual = 1.0;
};

// `directions`: rows known less one.
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

VectorXd ZeroUnknown(const VectorXd& values) {
  return values.array().isFinite().select(values, 0.0);
}

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

OutputComparison CompareOutput(const Variogram& rest, const Variogram& always,
                               const VectorXd& in_use, const VectorXd& proposed,
                               const VectorXd& driven, const MatrixXd& shapes) {
  const Index n = in_use.size();
  const auto windows = [&](const Variogram& noise) {
    return noise.counts(n - 2) / static_cast<double>(n);
  };
  std::vector<bool> known(static_cast<std::size_t>(n));
  double count = 0.0;
  for (Index k = 0; k < n; ++k) {
    known[k] = std::isfinite(in_use(k)) && std::isfinite(proposed(k));
    count += known[k] ? 1.0 : 0.0;
  }
  OutputComparison result;
  const bool rests = windows(rest) >= kLeastAtRest;
  if (count < kLeastKnown * static_cast<double>(n) ||
      (!rests && windows(always) < kLeastOfAll)) {
    return result;
  }
  const Variogram& noise = rests ? rest : always;
  const double length = windows(noise);
  const MatrixXd loss = LossMatrix(noise, known);
  const VectorXd e0 = ZeroUnknown(in_use);
  const VectorXd e1 = ZeroUnknown(proposed);
  const ExplainedLoss of_in_use = ExplainLoss(loss, count - 1.0, shapes, e0);
  const ExplainedLoss of_proposed = ExplainLoss(loss, count - 1.0, shapes, e1);
  result.compared = true;
  result.in_use = of_in_use.explained;
  result.proposed = of_proposed.explained;
  const VectorXd weights = loss * driven;
  result.gain = 0.5 * weights.dot(e0 + e1);
  result.size = std::max(weights.dot(driven), 0.0);
  // The variance of a ratio to an estimate from as many windows; more where the
  // better of the models leaves more than noise.
  const double more =
      std::max(1.0, std::min(of_in_use.unusual, of_proposed.unusual));
  result.deviation = std::sqrt(result.size * more * length / (length - 2.0));
  // Values at the ends of their range.
  const bool is_sound = std::isfinite(result.gain) &&
                        std::isfinite(result.deviation) &&
                        std::isfinite(result.in_use + result.proposed);
  return is_sound ? result : OutputComparison();
}

}  // namespace mle
