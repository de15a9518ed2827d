#include "mle/nonlinear/noise_search.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "Eigen/QR"
#include "mle/nonlinear/brent_search.h"
#include "mle/nonlinear/colour_search.h"

namespace mle {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// The range of ρ, as ln ρ. Below it drift is less than a sample's noise in
// 10⁵ samples, above it white noise is none. σ has the same.
const double kMinLogRatio = std::log(1e-10);
const double kMaxLogRatio = std::log(1e6);
constexpr double kGridStep = 1.0;    // of possible ratios
constexpr double kSearchStep = 2.0;  // of the search for the best
constexpr int kSearchBits = 10;      // of ln ρ: 4e-3 at most

// Beforehand every √ρ is as likely as any other: what of it is nearest to a
// value of the grid, as a share of √ρ there; and below the smallest, of that.
const double kShareOfValue =
    std::exp(0.25 * kGridStep) - std::exp(-0.25 * kGridStep);
const double kShareBelow = std::exp(-0.25 * kGridStep);

constexpr double kRankTolerance = 1e-12;

VectorXd ShortestSolution(const MatrixXd& normal, const VectorXd& gradient) {
  Eigen::CompleteOrthogonalDecomposition<MatrixXd> decomposition;
  decomposition.setThreshold(kRankTolerance);
  decomposition.compute(normal);
  return decomposition.solve(gradient);
}

}  // namespace

double Profile::variance() const {
  return factor * squares / std::max(degrees, 1.0);
}

ShapeLikelihood::ShapeLikelihood(const OutputErrorProblem& problem,
                                 const OutputPoint& point,
                                 const std::vector<bool>& free,
                                 const NoiseShape& start, bool restricted,
                                 const std::vector<MatrixXd>& more)
    : ShapeLikelihood(problem, problem.Linearise(point, start, true), free,
                      restricted, more) {}

ShapeLikelihood::ShapeLikelihood(const OutputErrorProblem& problem,
                                 std::vector<SegmentColumns> columns,
                                 const std::vector<bool>& free, bool restricted,
                                 const std::vector<MatrixXd>& more)
    : problem_(problem), columns_(std::move(columns)), restricted_(restricted) {
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

Profile ShapeLikelihood::At(const NoiseShape& shape) const {
  const WhitenedColumns whitened = problem_.Whiten(columns_, shape);
  Profile profile;
  profile.shape = shape;
  profile.factor = problem_.variance_factor();
  profile.squares = whitened.residuals.squaredNorm();
  double log_jacobian = 0.0;
  Eigen::Index rank = 0;
  if (whitened.jacobian.cols() > 0) {
    // By normal equations: fast, and good enough for a first-order term.
    MatrixXd normal =
        MatrixXd::Zero(whitened.jacobian.cols(), whitened.jacobian.cols());
    normal.selfadjointView<Eigen::Lower>().rankUpdate(
        whitened.jacobian.transpose());
    const VectorXd inverse_norms =
        normal.diagonal().cwiseSqrt().cwiseMax(1e-300).cwiseInverse();
    normal = inverse_norms.asDiagonal() *
             MatrixXd(normal.selfadjointView<Eigen::Lower>()) *
             inverse_norms.asDiagonal();
    const VectorXd gradient = inverse_norms.cwiseProduct(
        whitened.jacobian.transpose() * whitened.residuals);
    Eigen::ColPivHouseholderQR<MatrixXd> qr;
    qr.setThreshold(kRankTolerance);
    qr.compute(normal);
    rank = qr.rank();
    profile.rank = static_cast<int>(rank);
    for (Eigen::Index i = 0; i < rank; ++i) {
      log_jacobian += std::log(std::abs(qr.matrixQR()(i, i)));
    }
    log_jacobian -= 2.0 * inverse_norms.array().log().sum();
    // By rank: a solve by pivots would take rounding for a direction.
    const VectorXd step = rank == normal.cols()
                              ? VectorXd(qr.solve(gradient))
                              : ShortestSolution(normal, gradient);
    profile.squares -= std::min(profile.squares, gradient.dot(step));
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

double PricedValue(const OutputErrorProblem& problem, const Profile& profile) {
  int parameters = 0;
  for (int i = 1; i < kShapeParameters; ++i) {
    parameters += HasParameter(profile.shape, i) ? 1 : 0;
  }
  return profile.value +
         parameters * std::log(problem.num_innovations(NoiseShape()));
}

double MemoryOf(double pole) { return -1.0 / std::log(pole); }

double PoleOf(double memory) { return std::exp(-1.0 / memory); }

std::vector<PossibleRatio> PossibleRatios(const OutputErrorProblem& problem) {
  const double length = static_cast<double>(problem.num_samples()) /
                        static_cast<double>(problem.num_segments());
  std::vector<PossibleRatio> ratios = {{0.0, kShareBelow / length}};
  for (double log_ratio = -2.0 * std::log(length); log_ratio <= kMaxLogRatio;
       log_ratio += kGridStep) {
    ratios.push_back(
        {std::exp(log_ratio), kShareOfValue * std::exp(0.5 * log_ratio)});
  }
  return ratios;
}

bool HasParameter(const NoiseShape& shape, int parameter) {
  if (parameter == 0) return shape.ratio > 0.0;
  return shape.coloured() && (parameter < 3 || shape.colour_damping > 0.0);
}

NoiseShape Moved(const NoiseShape& shape, int parameter, double by) {
  const double factor = std::exp(by);
  NoiseShape moved = shape;
  if (parameter == 0) moved.ratio *= factor;
  if (parameter == 1) moved.colour_ratio *= factor;
  if (parameter == 2) {
    moved.colour_pole = PoleOf(MemoryOf(shape.colour_pole) * factor);
  }
  if (parameter == 3) moved.colour_damping *= factor;
  return moved;
}

namespace {

Profile AtLogRatio(const ShapeLikelihood& likelihood, double log_ratio) {
  return likelihood.At({.ratio = std::exp(log_ratio)});
}

Profile SearchBetween(const ShapeLikelihood& likelihood, double low,
                      double high) {
  Profile best;
  SearchLeast(low, high, kSearchBits, [&](double log_ratio) {
    const Profile profile = AtLogRatio(likelihood, log_ratio);
    if (profile.value < best.value) best = profile;
    return profile.value;
  });
  return best;
}

// Over all ρ, without colour.
Profile FindBestRatio(const ShapeLikelihood& likelihood) {
  Profile best = likelihood.At(NoiseShape());
  double best_log = kMinLogRatio;
  for (double log_ratio = kMinLogRatio; log_ratio <= kMaxLogRatio;
       log_ratio += kSearchStep) {
    const Profile profile = AtLogRatio(likelihood, log_ratio);
    if (profile.value < best.value) {
      best = profile;
      best_log = log_ratio;
    }
  }
  const Profile inner =
      SearchBetween(likelihood, best_log - kSearchStep, best_log + kSearchStep);
  return inner.value < best.value ? inner : best;
}

}  // namespace

Profile FindBestShape(const ShapeLikelihood& likelihood,
                      const NoiseShape& start, bool estimate_drift,
                      bool search_colour) {
  if (!estimate_drift) return likelihood.At(NoiseShape());
  Profile best;
  if (!start.coloured() || search_colour) best = FindBestRatio(likelihood);
  if (!start.coloured() && !search_colour) return best;
  const Profile walk = best;
  double least = walk.value;
  for (const int order : {1, 2}) {
    const bool known = start.coloured() && start.colour().order() == order;
    if (!known && !search_colour) continue;
    const Profile coloured = known ? ContinueColour(likelihood, start)
                                   : FindBestColour(likelihood, order, walk);
    const double value = PricedValue(likelihood.problem(), coloured);
    if (value < least) {
      least = value;
      best = coloured;
    }
  }
  return best;
}

}  // namespace mle
