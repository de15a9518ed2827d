#include <algorithm>
#include <cmath>
#include <vector>

#include "Eigen/Eigenvalues"
#include "mle/base/double_limits.h"
#include "mle/nonlinear/noise_search.h"
#include "mle/nonlinear/output_fit.h"
#include "mle/regression/lagged_products.h"

namespace mle {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// Satterthwaite's approximation does not reach below.
constexpr double kMinDegrees = 4.0;
// Secants reach so many standard errors to each side, at most this share of
// the time scale; errors and secants in turn.
constexpr double kSecantErrors = 3.0;
constexpr double kLongestSecant = 0.5;
constexpr int kSecantRounds = 3;
// In a logarithm of the shape, of the differences that tell how a variance
// moves with it.
constexpr double kShapeStep = 0.2;

// CᵀC of the derivatives and the residuals, whitened, without what the
// amplitudes explain.
MatrixXd WhitenedProductsOf(const OutputErrorProblem& problem,
                            const std::vector<SegmentColumns>& columns,
                            const std::vector<bool>& free,
                            const NoiseShape& shape) {
  return ShapeLikelihood(problem, columns, free, /*restricted=*/true)
      .ProductsAt(shape)
      .products;
}

}  // namespace

OutputCovariance CovarianceOf(const OutputErrorProblem& problem,
                              const MatrixXd& products,
                              const OutputPoint& point,
                              const std::vector<bool>& free, double variance) {
  const std::vector<int> kept = problem.FreeParameters(free);
  const int m = static_cast<int>(free.size());
  VectorXd units = VectorXd::Ones(3 * m);
  for (int j = 0; j < m; ++j) {
    if (free[j]) units(3 * j + 1) = point.values[j].time_scale;  // of ln T
  }
  OutputCovariance result;
  result.covariance = MatrixXd::Zero(units.size(), units.size());
  if (kept.empty()) return result;
  const std::vector<int> columns = problem.FreeColumns(free);
  const MatrixXd normal = products(columns, columns);
  const VectorXd norms =
      normal.diagonal().cwiseMax(0.0).cwiseSqrt().cwiseMax(1e-150);
  const VectorXd scales = norms.cwiseInverse();
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(
      scales.asDiagonal() * normal * scales.asDiagonal());
  const VectorXd& values = eigen.eigenvalues();
  const double largest = values.maxCoeff();
  const double limit = 1e-13 * largest;
  MatrixXd inverse = MatrixXd::Zero(kept.size(), kept.size());
  VectorXd undetermined = VectorXd::Zero(kept.size());
  for (Eigen::Index i = 0; i < values.size(); ++i) {
    const auto direction = eigen.eigenvectors().col(i);
    if (values(i) > limit) {
      ++result.rank;
      inverse += direction * direction.transpose() / values(i);
    } else {
      undetermined += direction.cwiseAbs2();
    }
  }
  result.condition = std::sqrt(largest / std::max(values.minCoeff(), 1e-300));
  for (std::size_t a = 0; a < kept.size(); ++a) {
    for (std::size_t b = 0; b < kept.size(); ++b) {
      result.covariance(kept[a], kept[b]) = variance * inverse(a, b) /
                                            (norms(a) * norms(b)) *
                                            units(kept[a]) * units(kept[b]);
    }
    if (undetermined(a) > 1e-9) {
      result.covariance(kept[a], kept[a]) = kInfinity;
    }
  }
  return result;
}

std::vector<SegmentColumns> LineariseWidely(const OutputErrorProblem& problem,
                                            const OutputPoint& point,
                                            const std::vector<bool>& free,
                                            const NoiseEstimate& noise) {
  const NoiseShape shape = ShapeOf(noise);
  std::vector<SegmentColumns> columns = problem.Linearise(point, shape, free);
  if (std::find(free.begin(), free.end(), true) == free.end()) return columns;
  // A dead time beyond all samples tells no more.
  const double longest = problem.num_samples() * problem.sample_time();
  for (int round = 0; round < kSecantRounds; ++round) {
    const OutputCovariance covariance =
        CovarianceOf(problem, WhitenedProductsOf(problem, columns, free, shape),
                     point, free, noise.variance);
    std::vector<double> steps(free.size(), 0.0);
    for (std::size_t j = 0; j < free.size(); ++j) {
      const auto delay = 3 * static_cast<Eigen::Index>(j) + 2;
      const double variance = covariance.covariance(delay, delay);
      if (free[j] && std::isfinite(variance)) {
        steps[j] =
            std::min({kSecantErrors * std::sqrt(variance),
                      kLongestSecant * point.values[j].time_scale, longest});
      }
    }
    problem.TakeSecants(point, free, steps, columns);
  }
  return columns;
}

OutputCovariance ComputeCovariance(const OutputErrorProblem& problem,
                                   const OutputPoint& point,
                                   const std::vector<bool>& free,
                                   const NoiseEstimate& noise) {
  const WhitenedColumns whitened = problem.Whiten(
      problem.Linearise(point, ShapeOf(noise), free), ShapeOf(noise));
  return CovarianceOf(problem, GramMatrix(whitened.jacobian), point, free,
                      noise.variance);
}

VectorXd ComputeDegreesOfFreedom(const OutputErrorProblem& problem,
                                 const OutputPoint& point,
                                 const std::vector<bool>& free,
                                 const NoiseEstimate& noise) {
  const double n = problem.num_innovations(ShapeOf(noise));
  VectorXd relative_variance =
      VectorXd::Constant(3 * problem.num_elements(), 2.0 / n);
  const bool any = std::find(free.begin(), free.end(), true) != free.end();
  for (int parameter = 0; any && parameter < kShapeParameters; ++parameter) {
    const double deviation = noise.log_deviations[parameter];
    if (!(deviation > 0.0)) continue;
    VectorXd logs[2];
    for (int side = 0; side < 2; ++side) {
      const NoiseShape shape = Moved(ShapeOf(noise), parameter,
                                     side == 0 ? -kShapeStep : kShapeStep);
      const MatrixXd products = WhitenedProductsOf(
          problem, problem.Linearise(point, shape, free), free, shape);
      const double variance = products.bottomRightCorner<1, 1>().value() / n;
      logs[side] = CovarianceOf(problem, products, point, free, variance)
                       .covariance.diagonal()
                       .array()
                       .max(1e-300)
                       .log();
    }
    for (Eigen::Index i = 0; i < relative_variance.size(); ++i) {
      const double slope = (logs[1](i) - logs[0](i)) / (2.0 * kShapeStep);
      if (std::isfinite(slope)) {
        relative_variance(i) += std::pow(slope * deviation, 2);
      }
    }
  }
  return (2.0 * relative_variance.cwiseInverse()).cwiseMax(kMinDegrees);
}

}  // namespace mle
