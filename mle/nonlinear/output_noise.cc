#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <utility>
#include <vector>

#include "Eigen/QR"
#include "mle/nonlinear/distributions.h"
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
constexpr double kMaxLogRatioDeviation = 3.0;

// At one noise shape, maximised over r.
struct Profile {
  NoiseShape shape;
  double value = std::numeric_limits<double>::infinity();  // −2 ln likelihood
  double squares = 0.0;  // of the whitened residuals
  double degrees = 0.0;  // of freedom that they have
  int rank = 0;          // of what is fitted to first order
  double factor = 1.0;   // of OutputErrorProblem::variance_factor()
  double variance() const { return factor * squares / std::max(degrees, 1.0); }
};

// The likelihood (or restricted likelihood) of a noise shape.
class ShapeLikelihood {
 public:
  ShapeLikelihood(const OutputErrorProblem& problem, const OutputPoint& point,
                  const std::vector<bool>& free, NoiseShape start,
                  bool restricted, const std::vector<MatrixXd>& more = {})
      : ShapeLikelihood(problem, problem.Linearise(point, start, true), free,
                        restricted, more) {}

  ShapeLikelihood(const OutputErrorProblem& problem,
                  std::vector<SegmentColumns> columns,
                  const std::vector<bool>& free, bool restricted,
                  const std::vector<MatrixXd>& more = {})
      : problem_(problem),
        columns_(std::move(columns)),
        restricted_(restricted) {
    std::vector<int> kept;
    for (std::size_t j = 0; j < free.size(); ++j) {
      for (int i = 0; free[j] && i < 3; ++i) {
        kept.push_back(3 * static_cast<int>(j) + i);
      }
    }
    for (std::size_t s = 0; s < columns_.size(); ++s) {
      MatrixXd jacobian = columns_[s].jacobian(Eigen::all, kept);
      const Eigen::Index width = jacobian.cols();
      if (!more.empty()) {
        jacobian.conservativeResize(Eigen::NoChange, width + more[s].cols());
        jacobian.rightCols(more[s].cols()) = more[s];
      }
      columns_[s].jacobian = std::move(jacobian);
    }
  }

  Profile At(NoiseShape shape) const {
    const WhitenedColumns whitened = problem_.Whiten(columns_, shape);
    Profile profile;
    profile.shape = shape;
    profile.factor = problem_.variance_factor();
    profile.squares = whitened.residuals.squaredNorm();
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
      profile.rank = static_cast<int>(rank);
      for (Eigen::Index i = 0; i < rank; ++i) {
        log_jacobian += std::log(std::abs(qr.matrixQR()(i, i)));
      }
      log_jacobian -= 2.0 * inverse_norms.array().log().sum();
      // By rank: a solve by pivots would take rounding for a direction.
      Eigen::CompleteOrthogonalDecomposition<MatrixXd> decomposition;
      decomposition.setThreshold(1e-12);
      decomposition.compute(jacobian.transpose() * jacobian);
      profile.squares -= std::min(profile.squares,
                                  gradient.dot(decomposition.solve(gradient)));
    }
    // Exact data leave rounding, which has no likelihood.
    profile.squares =
        std::max({profile.squares, 1e-26 * problem_.total_squares(), 1e-300});
    const double n = problem_.num_innovations(shape);
    profile.degrees = n - whitened.num_amplitudes - static_cast<double>(rank);
    profile.value = whitened.log_determinant;
    if (restricted_) {
      profile.value += profile.degrees * std::log(profile.variance()) +
                       whitened.log_amplitudes + log_jacobian;
    } else {
      profile.value += n * std::log(profile.squares / n);
    }
    return profile;
  }
  Profile AtLog(double log_ratio) const {
    return At({.ratio = std::exp(log_ratio)});
  }

 private:
  const OutputErrorProblem& problem_;
  std::vector<SegmentColumns> columns_;
  bool restricted_;
};

// Golden-section search between two values of ln ρ.
Profile SearchBetween(const ShapeLikelihood& likelihood, double low,
                      double high) {
  const double golden = 0.5 * (std::sqrt(5.0) - 1.0);
  double left = high - golden * (high - low);
  double right = low + golden * (high - low);
  Profile at_left = likelihood.AtLog(left);
  Profile at_right = likelihood.AtLog(right);
  while (high - low > kTolerance) {
    if (at_left.value < at_right.value) {
      high = right;
      right = left;
      at_right = at_left;
      left = high - golden * (high - low);
      at_left = likelihood.AtLog(left);
    } else {
      low = left;
      left = right;
      at_left = at_right;
      right = low + golden * (high - low);
      at_right = likelihood.AtLog(right);
    }
  }
  return at_left.value < at_right.value ? at_left : at_right;
}

// With offsets, over all ρ.
Profile FindBest(const ShapeLikelihood& likelihood, bool estimate_drift) {
  Profile best = likelihood.At(NoiseShape());
  if (!estimate_drift) return best;
  double best_log = kMinLogRatio;
  for (double log_ratio = kMinLogRatio; log_ratio <= kMaxLogRatio;
       log_ratio += kGridStep) {
    const Profile profile = likelihood.AtLog(log_ratio);
    if (profile.value < best.value) {
      best = profile;
      best_log = log_ratio;
    }
  }
  const Profile inner =
      SearchBetween(likelihood, best_log - kGridStep, best_log + kGridStep);
  return inner.value < best.value ? inner : best;
}

// Of the likelihood at its maximum, in ln ρ.
double LogRatioDeviation(const ShapeLikelihood& likelihood,
                         const Profile& best) {
  const double log_ratio = std::log(best.shape.ratio);
  const double curvature =
      (likelihood.AtLog(log_ratio + kCurvatureStep).value +
       likelihood.AtLog(log_ratio - kCurvatureStep).value - 2.0 * best.value) /
      (kCurvatureStep * kCurvatureStep);
  // A flat likelihood says little, but not nothing: the range is finite.
  return std::min(std::sqrt(2.0 / std::max(curvature, 1e-3)),
                  kMaxLogRatioDeviation);
}

}  // namespace

NoiseEstimate EstimateNoise(const OutputErrorProblem& problem,
                            const OutputPoint& point,
                            const std::vector<bool>& free,
                            const NoiseEstimate& start, bool estimate_drift) {
  const ShapeLikelihood likelihood(problem, point, free, ShapeOf(start),
                                   /*restricted=*/true);
  const Profile best = start.offset ? FindBest(likelihood, estimate_drift)
                                    : likelihood.At(ShapeOf(start));
  NoiseEstimate noise;
  noise.variance = best.variance();
  noise.ratio = best.shape.ratio;
  noise.offset = best.shape.offset;
  if (noise.ratio > 0.0) {
    noise.log_ratio_deviation = LogRatioDeviation(likelihood, best);
  }
  return noise;
}

RatioLikelihood RestrictedLikelihood(const OutputErrorProblem& problem,
                                     const std::vector<bool>& free,
                                     const std::vector<SegmentColumns>& columns,
                                     NoiseShape shape) {
  const Profile profile =
      ShapeLikelihood(problem, columns, free, /*restricted=*/true).At(shape);
  return {.deviance = profile.value, .variance = profile.variance()};
}

OffsetEvidence FindOffsetEvidence(const OutputErrorProblem& problem,
                                  const OutputPoint& point,
                                  const std::vector<bool>& free,
                                  const NoiseEstimate& noise,
                                  bool estimate_drift) {
  const ShapeLikelihood likelihood(problem, point, free, ShapeOf(noise),
                                   /*restricted=*/true);
  const Profile with = likelihood.At(NoiseShape());
  const Profile without = likelihood.At({.ratio = 0.0, .offset = false});
  OffsetEvidence evidence;
  evidence.offsets = (without.squares - with.squares) / with.variance();
  if (problem.num_segments() > 0) {
    evidence.num_parameters = problem.num_segments() + (estimate_drift ? 1 : 0);
  }
  if (noise.ratio > 0.0) {
    evidence.drift = with.value - likelihood.At(ShapeOf(noise)).value;
  }
  return evidence;
}

double OffsetWeight(const std::vector<OffsetEvidence>& evidence) {
  double excess = 0.0;  // of AIC without over AIC with
  for (const OffsetEvidence& e : evidence) {
    excess += std::max(e.offsets, 0.0) + std::max(e.drift, 0.0) -
              2.0 * e.num_parameters;
  }
  return 1.0 / (1.0 + std::exp(-0.5 * excess));
}

double Deviance(const OutputErrorProblem& problem, const OutputPoint& point,
                const std::vector<bool>& free, const NoiseEstimate& start,
                bool estimate_drift) {
  const ShapeLikelihood likelihood(problem, point, free, ShapeOf(start),
                                   /*restricted=*/false);
  if (!start.offset) return likelihood.At(ShapeOf(start)).value;
  return FindBest(likelihood, estimate_drift).value;
}

namespace {

// Both at the larger of the two ratios that restricted likelihood finds.
// Likelihood that takes a ratio for each would let the alternative explain slow
// drift and then call the noise white: with weak drift every fourth test would
// raise a false alarm of one in a hundred.
Contrast AtOneRatio(const ShapeLikelihood& null,
                    const ShapeLikelihood& alternative, bool estimate_drift) {
  const NoiseShape shape = {
      .ratio = std::max(FindBest(null, estimate_drift).shape.ratio,
                        FindBest(alternative, estimate_drift).shape.ratio)};
  const Profile without = null.At(shape);
  const Profile with = alternative.At(shape);
  return {.statistic =
              std::max(without.squares - with.squares, 0.0) / with.variance(),
          .degrees = with.rank - without.rank};
}

}  // namespace

Contrast ContrastWithColumns(const OutputErrorProblem& problem,
                             const OutputPoint& point,
                             const std::vector<bool>& free, bool estimate_drift,
                             const std::vector<MatrixXd>& columns) {
  return AtOneRatio(ShapeLikelihood(problem, point, free, NoiseShape(),
                                    /*restricted=*/true),
                    ShapeLikelihood(problem, point, free, NoiseShape(),
                                    /*restricted=*/true, columns),
                    estimate_drift);
}

Contrast ContrastWithFit(const OutputErrorProblem& problem,
                         const OutputPoint& null, const OutputPoint& point,
                         const std::vector<bool>& free, bool estimate_drift) {
  return AtOneRatio(
      ShapeLikelihood(problem, null, std::vector<bool>(free.size(), false),
                      NoiseShape(), /*restricted=*/true),
      ShapeLikelihood(problem, point, free, NoiseShape(), /*restricted=*/true),
      estimate_drift);
}

}  // namespace mle
