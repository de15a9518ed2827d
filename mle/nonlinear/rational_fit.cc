#include "mle/nonlinear/rational_fit.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "Eigen/QR"
#include "absl/strings/str_cat.h"
#include "mle/base/number_range.h"
#include "mle/base/status.h"

namespace mle {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kMaxPoints = 240;  // of the response that are compared
constexpr int kRationalTimeConstants = 24;
constexpr int kRationalDelays = 9;
// The least step in ln τ, and in the range of L.
constexpr double kLeastStep = 1e-4;
constexpr int kMaxCandidateMoves = 400;
// Time constants closer than this are one pole.
constexpr double kLeastApart = 1.05;

struct Target {
  VectorXd times;
  VectorXd values;
};

struct RationalCandidate {
  double delay = 0.0;
  std::vector<double> time_constants;
  VectorXd weights;  // c
  double squares = std::numeric_limits<double>::infinity();
};

VectorXd Atom(const VectorXd& times, double delay, double time_constant) {
  return (1.0 - (-(times.array() - delay).max(0.0) / time_constant).exp())
      .matrix();
}

bool Distinct(const std::vector<double>& time_constants) {
  std::vector<double> sorted = time_constants;
  std::sort(sorted.begin(), sorted.end());
  for (std::size_t i = 1; i < sorted.size(); ++i) {
    if (sorted[i] < kLeastApart * sorted[i - 1]) return false;
  }
  return true;
}

// The best weights; the squares stay infinite for poles that are one.
void Solve(const Target& target, RationalCandidate& candidate) {
  candidate.squares = std::numeric_limits<double>::infinity();
  if (!Distinct(candidate.time_constants)) return;
  MatrixXd atoms(target.times.size(),
                 static_cast<Eigen::Index>(candidate.time_constants.size()));
  for (Eigen::Index i = 0; i < atoms.cols(); ++i) {
    atoms.col(i) =
        Atom(target.times, candidate.delay, candidate.time_constants[i]);
  }
  const Eigen::ColPivHouseholderQR<MatrixXd> qr(atoms);
  candidate.weights = qr.solve(target.values);
  candidate.squares = (target.values - atoms * candidate.weights).squaredNorm();
}

RationalCandidate AddPole(const Target& target, const RationalCandidate& base,
                          const std::vector<double>& grid) {
  RationalCandidate best = base;
  for (const double time_constant : grid) {
    RationalCandidate next = base;
    next.time_constants.push_back(time_constant);
    Solve(target, next);
    if (next.squares < best.squares) best = std::move(next);
  }
  return best;
}

// Moves of each τ within the range of the grid and of L, by steps that shrink.
void RefineCandidate(const Target& target, const std::vector<double>& grid,
                     double low, double high, RationalCandidate& best) {
  double step = 0.25;
  for (int moves = 0; step > kLeastStep && moves < kMaxCandidateMoves;
       ++moves) {
    const double before = best.squares;
    for (const double sign : {-1.0, 1.0}) {
      for (std::size_t i = 0; i <= best.time_constants.size(); ++i) {
        RationalCandidate moved = best;
        if (i < best.time_constants.size()) {
          moved.time_constants[i] =
              std::clamp(moved.time_constants[i] * std::exp(sign * step),
                         grid.front(), grid.back());
        } else {
          moved.delay =
              std::clamp(best.delay + sign * step * (high - low), low, high);
        }
        Solve(target, moved);
        if (moved.squares < best.squares) best = std::move(moved);
      }
    }
    if (!(best.squares < before * (1.0 - 1e-6))) step *= 0.5;
  }
}

// Σ c_i Π_{k≠i} (τ_k s + 1) over Π (τ_i s + 1), highest power first.
TransferFunction ToTransferFunction(const RationalCandidate& fit) {
  const auto times_pole = [](const std::vector<double>& polynomial,
                             double time_constant) {
    std::vector<double> product(polynomial.size() + 1, 0.0);
    for (std::size_t i = 0; i < polynomial.size(); ++i) {
      product[i] += time_constant * polynomial[i];
      product[i + 1] += polynomial[i];
    }
    return product;
  };
  const std::size_t n = fit.time_constants.size();
  std::vector<double> numerator(n, 0.0);
  std::vector<double> denominator = {1.0};
  for (std::size_t i = 0; i < n; ++i) {
    denominator = times_pole(denominator, fit.time_constants[i]);
    std::vector<double> part = {fit.weights(static_cast<Eigen::Index>(i))};
    for (std::size_t k = 0; k < n; ++k) {
      if (k != i) part = times_pole(part, fit.time_constants[k]);
    }
    for (std::size_t k = 0; k < n; ++k) numerator[k] += part[k];
  }
  return TransferFunction(std::move(numerator), std::move(denominator),
                          fit.delay);
}

RationalCandidate FitOrder(const Target& target,
                           const std::vector<double>& grid,
                           const RationalOptions& options, int order) {
  RationalCandidate best;
  for (int d = 0; d < kRationalDelays; ++d) {
    RationalCandidate candidate;
    candidate.delay =
        options.min_delay + (options.max_delay - options.min_delay) * d /
                                static_cast<double>(kRationalDelays - 1);
    for (int i = 0; i < order; ++i)
      candidate = AddPole(target, candidate, grid);
    if (candidate.squares < best.squares) best = std::move(candidate);
  }
  RefineCandidate(target, grid, options.min_delay, options.max_delay, best);
  return best;
}

}  // namespace

absl::Status RationalOptions::Validate() const {
  if (!(min_delay >= 0.0) || !(max_delay >= min_delay) ||
      !std::isfinite(max_delay)) {
    return absl::InvalidArgumentError(
        absl::StrCat("rational fit: dead times from ", min_delay, " to ",
                     max_delay, ", must be finite, ordered and at least 0"));
  }
  if (max_order < 1) {
    return absl::InvalidArgumentError(absl::StrCat(
        "rational fit: max_order is ", max_order, ", must be at least 1"));
  }
  if (!(tolerance > 0.0)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "rational fit: tolerance is ", tolerance, ", must be positive"));
  }
  return absl::OkStatus();
}

absl::StatusOr<RationalFit> FitRational(
    const Eigen::Ref<const VectorXd>& step_response, double sample_time,
    const RationalOptions& options) {
  MLE_RETURN_IF_ERROR(options.Validate());
  MLE_RETURN_IF_ERROR(
      ValidateSampleTime("rational fit: sample_time", sample_time));
  const Eigen::Index n = step_response.size();
  if (n < 5 || !step_response.allFinite()) {
    return absl::InvalidArgumentError(
        absl::StrCat("rational fit: the step response has ", n,
                     " samples, must have at least 5, all finite"));
  }
  if (step_response.isZero(0.0)) return RationalFit();
  const Eigen::Index stride = (n + kMaxPoints - 1) / kMaxPoints;
  const Eigen::Index points = (n + stride - 1) / stride;
  Target target = {VectorXd(points), VectorXd(points)};
  for (Eigen::Index i = 0; i < points; ++i) {
    target.times(i) = sample_time * static_cast<double>(i * stride);
    target.values(i) = step_response(i * stride);
  }
  const double horizon = sample_time * static_cast<double>(n - 1);
  const double shortest = 0.5 * sample_time;
  std::vector<double> grid;
  for (int i = 0; i < kRationalTimeConstants; ++i) {
    grid.push_back(shortest * std::pow(horizon / shortest,
                                       i / double{kRationalTimeConstants - 1}));
  }
  const double size = target.values.norm();
  RationalCandidate best;
  for (int order = 1; order <= options.max_order; ++order) {
    RationalCandidate candidate = FitOrder(target, grid, options, order);
    if (candidate.squares < best.squares) best = std::move(candidate);
    if (std::sqrt(best.squares) <= options.tolerance * size) break;
  }
  RationalFit fit;
  fit.element = ToTransferFunction(best);
  fit.relative_error = (step_response - fit.element.StepResponse(
                                            sample_time, static_cast<int>(n)))
                           .norm() /
                       step_response.norm();
  return fit;
}

}  // namespace mle
