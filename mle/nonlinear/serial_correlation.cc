#include "mle/nonlinear/serial_correlation.h"

#include <algorithm>
#include <cmath>

#include "Eigen/Cholesky"
#include "Eigen/Eigenvalues"
#include "mle/regression/kernels/kernels.h"
#include "mle/regression/lagged_products.h"

namespace mle {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// The lags reach at most this share of the shortest segment.
constexpr double kMaxSerialLagShare = 0.25;
// Standard errors, under white noise, that a factor must differ from 1 by.
constexpr double kSignificant = 2.0;
// Relative to the largest eigenvalue of JᵀJ, its columns scaled to one.
constexpr double kEigenvalueTolerance = 1e-12;

// Σ_k x_k x_{k+l} within the segments, l = 0 … longest, of each column. Samples
// of kPhases phases, k = kPhases q + r, times all that follow are products of
// matrices, so that each number that is read is used for as many.
constexpr Eigen::Index kPhases = 8;

MatrixXd Autocovariances(const OutputErrorProblem& problem, const MatrixXd& X,
                         int longest) {
  MatrixXd sums = MatrixXd::Zero(longest + 1, X.cols());
  // Products of whole vectors: x_{kPhases q + i} x_{kPhases q + r}, summed over
  // q.
  const Eigen::Index reach = (longest / kPhases + 2) * kPhases;
  MatrixXd of_phases(reach, kPhases);
  Eigen::Index begin = 0;
  VectorXd padded;
  for (int s = 0; s < problem.num_segments(); ++s) {
    const auto rows = static_cast<Eigen::Index>(problem.times(s).size());
    const Eigen::Index count = (rows + kPhases - 1) / kPhases;
    padded.setZero(kPhases * count + reach);
    for (Eigen::Index c = 0; c < X.cols(); ++c) {
      padded.head(rows) = X.col(c).segment(begin, rows);
      of_phases.setZero();
      VectorKernels().add_products({.x = padded.data(),
                                    .x_stride = kPhases,
                                    .rows = reach,
                                    .w = padded.data(),
                                    .w_stride = kPhases,
                                    .columns = kPhases,
                                    .count = count},
                                   of_phases.data(), reach);
      for (Eigen::Index r = 0; r < kPhases; ++r) {
        sums.col(c) += of_phases.col(r).segment(r, longest + 1);
      }
    }
    begin += rows;
  }
  return sums;
}

// T, n × rank, with (J T)ᵀ(J T) = I, from J with columns scaled to one.
MatrixXd Orthonormaliser(const MatrixXd& J) {
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(GramMatrix(J));
  const VectorXd& values = eigen.eigenvalues();
  const Eigen::Index count = values.size();
  Eigen::Index first = 0;
  while (first < count &&
         values(first) <= kEigenvalueTolerance * values(count - 1)) {
    ++first;
  }
  const Eigen::Index rank = count - first;
  return eigen.eigenvectors().rightCols(rank) *
         values.tail(rank).cwiseSqrt().cwiseInverse().asDiagonal();
}

// 1 + Σ terms where that is more than white noise makes of it.
double Factor(double sum, double variance) {
  return sum > kSignificant * std::sqrt(variance) ? 1.0 + sum : 1.0;
}

}  // namespace

MatrixXd SerialInflation::Scale(const MatrixXd& covariance) const {
  const VectorXd roots = variances.cwiseSqrt();
  return roots.asDiagonal() * covariance * roots.asDiagonal();
}

SerialInflation InflationOf(const OutputErrorProblem& problem,
                            const OutputPoint& point,
                            const WhitenedColumns& whitened,
                            const std::vector<bool>& free,
                            const NoiseShape& shape, int longest) {
  const auto m = static_cast<Eigen::Index>(free.size());
  SerialInflation inflation;
  inflation.variances = VectorXd::Ones(3 * m);
  const std::vector<int> kept = problem.FreeParameters(free);
  longest = std::min(longest, static_cast<int>(kMaxSerialLagShare *
                                               problem.shortest_segment()));
  if (kept.empty() || longest < 1) return inflation;
  // X: orthonormal columns that span J, then e less what they explain.
  MatrixXd J = whitened.jacobian(Eigen::all, problem.FreeColumns(free));
  const VectorXd norms = J.colwise().norm().cwiseMax(1e-300);
  J *= norms.cwiseInverse().asDiagonal();
  // J T is orthonormal; row i of T is what parameter i takes of its columns.
  const MatrixXd T = Orthonormaliser(J);
  const auto count = T.rows();
  const Eigen::Index rank = T.cols();
  if (rank == 0) return inflation;
  MatrixXd X(J.rows(), rank + 1);
  X.leftCols(rank) = J * T;
  X.col(rank) =
      whitened.residuals -
      X.leftCols(rank) * (X.leftCols(rank).transpose() * whitened.residuals);
  double squares = X.col(rank).squaredNorm();
  auto n = static_cast<double>(problem.num_innovations(shape));
  MatrixXd resting;
  if (problem.at_rest() != nullptr) {
    const OutputErrorProblem& rest = *problem.at_rest();
    resting = rest.Whiten(rest.Linearise(point, shape, {}), shape).residuals;
    squares += resting.squaredNorm();
    n += rest.num_innovations(shape);
  }
  if (!(squares > 0.0)) return inflation;
  const VectorXd own = T.rowwise().squaredNorm();
  const MatrixXd of_columns = Autocovariances(problem, X, longest);
  // The combination of columns that each parameter takes, scaled to one.
  const MatrixXd of_parameters =
      Autocovariances(problem,
                      X.leftCols(rank) * T.transpose() *
                          own.cwiseSqrt().cwiseInverse().asDiagonal(),
                      longest);
  VectorXd correlations = of_columns.col(rank);
  if (problem.at_rest() != nullptr) {
    correlations += Autocovariances(*problem.at_rest(), resting, longest);
  }
  correlations /= squares;
  double sum = 0.0;
  double variance = 0.0;
  VectorXd sums = VectorXd::Zero(count);
  VectorXd sum_variances = VectorXd::Zero(count);
  for (int lag = 1; lag <= longest; ++lag) {
    const double weight = 2.0 * (1.0 - lag / (longest + 1.0));
    const double mean = weight * of_columns.row(lag).head(rank).sum() /
                        static_cast<double>(rank);
    sum += correlations(lag) * mean;
    variance += mean * mean / n;
    const VectorXd of = weight * of_parameters.row(lag).transpose();
    sums += correlations(lag) * of;
    sum_variances += of.cwiseAbs2() / n;
  }
  inflation.statistic = Factor(sum, variance);
  for (Eigen::Index k = 0; k < count; ++k) {
    inflation.variances(kept[k]) = Factor(sums(k), sum_variances(k));
  }
  return inflation;
}

}  // namespace mle
