#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <vector>

#include "Eigen/QR"
#include "mle/nonlinear/output_fit.h"

namespace mle {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// The ratio's range, as ln ρ. Below it drift is less than a sample's noise in
// 10⁵ samples, above it white noise is none.
const double kMinLogRatio = std::log(1e-10);
const double kMaxLogRatio = std::log(1e6);
constexpr double kGridStep = 1.0;
constexpr double kTolerance = 1e-3;
constexpr double kCurvatureStep = 0.3;

// −2 ln likelihood (or restricted likelihood) of a ratio, maximised over r.
class RatioLikelihood {
 public:
  RatioLikelihood(const OutputErrorProblem& problem, const OutputPoint& point,
                  const std::vector<bool>& free, double start_ratio,
                  bool restricted)
      : problem_(problem),
        columns_(problem.Linearise(point, start_ratio, true)),
        restricted_(restricted) {
    std::vector<int> kept;
    for (std::size_t j = 0; j < free.size(); ++j) {
      for (int i = 0; free[j] && i < 3; ++i) {
        kept.push_back(3 * static_cast<int>(j) + i);
      }
    }
    for (SegmentColumns& segment : columns_) {
      segment.jacobian = MatrixXd(segment.jacobian(Eigen::all, kept));
    }
  }

  // Sets r to its estimate.
  double operator()(double ratio, double& variance) const {
    const WhitenedColumns whitened = problem_.Whiten(columns_, ratio);
    double squares = whitened.residuals.squaredNorm();
    double log_jacobian = 0.0;
    Eigen::Index rank = 0;
    if (whitened.jacobian.cols() > 0) {
      // By normal equations: fast, and good enough for a first-order term.
      const VectorXd inverse_norms =
          whitened.jacobian.colwise().norm().cwiseMax(1e-300).cwiseInverse();
      const MatrixXd jacobian = whitened.jacobian * inverse_norms.asDiagonal();
      const VectorXd gradient = jacobian.transpose() * whitened.residuals;
      Eigen::ColPivHouseholderQR<MatrixXd> qr;
      qr.setThreshold(1e-12);
      qr.compute(jacobian.transpose() * jacobian);
      rank = qr.rank();
      for (Eigen::Index i = 0; i < rank; ++i) {
        log_jacobian += std::log(std::abs(qr.matrixQR()(i, i)));
      }
      log_jacobian -= 2.0 * inverse_norms.array().log().sum();
      squares -= std::min(squares, gradient.dot(qr.solve(gradient)));
    }
    // Exact data leave rounding, which has no likelihood.
    squares = std::max(squares, 1e-26 * problem_.total_squares());
    squares = std::max(squares, 1e-300);

    const double n = problem_.num_innovations();
    const double left = n - whitened.num_amplitudes - static_cast<double>(rank);
    variance = squares / std::max(left, 1.0);
    if (restricted_) {
      return left * std::log(variance) + whitened.log_determinant +
             whitened.log_amplitudes + log_jacobian;
    }
    return n * std::log(squares / n) + whitened.log_determinant;
  }

 private:
  const OutputErrorProblem& problem_;
  std::vector<SegmentColumns> columns_;
  bool restricted_;
};

struct Best {
  double ratio = 0.0;
  double variance = 0.0;
  double value = std::numeric_limits<double>::infinity();
};

// Golden-section search between two values of ln ρ.
Best SearchBetween(const RatioLikelihood& likelihood, double low, double high) {
  const double golden = 0.5 * (std::sqrt(5.0) - 1.0);
  const auto at = [&](double log_ratio) {
    Best point;
    point.ratio = std::exp(log_ratio);
    point.value = likelihood(point.ratio, point.variance);
    return point;
  };
  Best left = at(high - golden * (high - low));
  Best right = at(low + golden * (high - low));
  while (high - low > kTolerance) {
    if (left.value < right.value) {
      high = std::log(right.ratio);
      right = left;
      left = at(high - golden * (high - low));
    } else {
      low = std::log(left.ratio);
      left = right;
      right = at(low + golden * (high - low));
    }
  }
  return left.value < right.value ? left : right;
}

Best FindBest(const RatioLikelihood& likelihood, bool estimate_drift) {
  Best best;
  best.value = likelihood(0.0, best.variance);
  if (!estimate_drift) return best;
  double best_log = kMinLogRatio;
  for (double log_ratio = kMinLogRatio; log_ratio <= kMaxLogRatio;
       log_ratio += kGridStep) {
    Best point;
    point.ratio = std::exp(log_ratio);
    point.value = likelihood(point.ratio, point.variance);
    if (point.value < best.value) {
      best = point;
      best_log = log_ratio;
    }
  }
  const Best inner =
      SearchBetween(likelihood, best_log - kGridStep, best_log + kGridStep);
  return inner.value < best.value ? inner : best;
}

}  // namespace

NoiseEstimate EstimateNoise(const OutputErrorProblem& problem,
                            const OutputPoint& point,
                            const std::vector<bool>& free, double start_ratio,
                            bool estimate_drift) {
  const RatioLikelihood likelihood(problem, point, free, start_ratio,
                                   /*restricted=*/true);
  const Best best = FindBest(likelihood, estimate_drift);
  NoiseEstimate noise;
  noise.variance = best.variance;
  noise.ratio = best.ratio;
  if (best.ratio > 0.0) {
    const double log_ratio = std::log(best.ratio);
    double unused = 0.0;
    const double curvature =
        (likelihood(std::exp(log_ratio + kCurvatureStep), unused) +
         likelihood(std::exp(log_ratio - kCurvatureStep), unused) -
         2.0 * best.value) /
        (kCurvatureStep * kCurvatureStep);
    // A flat likelihood says little, but not nothing: the range is finite.
    noise.log_ratio_deviation =
        std::min(std::sqrt(2.0 / std::max(curvature, 1e-3)), 10.0);
  }
  return noise;
}

double Deviance(const OutputErrorProblem& problem, const OutputPoint& point,
                const std::vector<bool>& free, double start_ratio,
                bool estimate_drift) {
  return FindBest(RatioLikelihood(problem, point, free, start_ratio,
                                  /*restricted=*/false),
                  estimate_drift)
      .value;
}

}  // namespace mle
