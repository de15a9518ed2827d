#include "mle/nonlinear/box_least_squares.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "Eigen/Cholesky"

namespace mle {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Exchanges of all that is wrong that may fail to lessen it, before single
// ones, which end for certain.
constexpr int kBlockTrials = 5;
constexpr int kMaxExchanges = 1000;
// An unknown is wrong if off by more than this, in units of its own scale.
constexpr double kPivotTolerance = 1e-12;

constexpr double kFirstDamping = 1e-4;
constexpr double kLeastStepDamping = 1e-10;
constexpr double kMostStepDamping = 1e12;
// After a step that is refused, at least: less damping hardly shortens it.
constexpr double kRefusedDamping = 1.0;
// Shares of the decrease that the model promises: steps above the first are
// taken; damping falls after steps above the second, and rises after steps
// below the third.
constexpr double kLeastShareOfPromise = 1e-4;
constexpr double kGoodShare = 0.75;
constexpr double kPoorShare = 0.25;

enum class Place { kLower, kFree, kUpper };

// Where each unknown belongs that is not where it should be.
struct Exchange {
  Index unknown = 0;
  Place to = Place::kFree;
};

class Pivoting {
 public:
  Pivoting(const MatrixXd& H, const VectorXd& g, const VectorXd& lower,
           const VectorXd& upper)
      : H_(H), g_(g), lower_(lower), upper_(upper), places_(g.size()) {
    for (Index i = 0; i < g.size(); ++i) {
      places_[i] = upper(i) > lower(i) ? Place::kFree : Place::kLower;
    }
  }

  VectorXd Run() {
    Index fewest = std::numeric_limits<Index>::max();
    int trials = kBlockTrials;
    for (int exchange = 0; exchange < kMaxExchanges; ++exchange) {
      Solve();
      const std::vector<Exchange> wrong = Wrong();
      const auto count = static_cast<Index>(wrong.size());
      if (count == 0) break;
      if (count < fewest) {
        fewest = count;
        trials = kBlockTrials;
      } else {
        --trials;
      }
      if (trials > 0) {
        for (const Exchange& one : wrong) places_[one.unknown] = one.to;
      } else {
        places_[wrong.back().unknown] = wrong.back().to;
      }
    }
    return d_.cwiseMax(lower_).cwiseMin(upper_);
  }

 private:
  void Solve() {
    std::vector<Index> free;
    std::vector<Index> bound;
    d_.resize(g_.size());
    for (Index i = 0; i < g_.size(); ++i) {
      if (places_[i] == Place::kFree) {
        free.push_back(i);
        continue;
      }
      bound.push_back(i);
      d_(i) = places_[i] == Place::kLower ? lower_(i) : upper_(i);
    }
    if (free.empty()) return;
    VectorXd right = -g_(free);
    if (!bound.empty()) right -= H_(free, bound) * d_(bound);
    const VectorXd solution = MatrixXd(H_(free, free)).llt().solve(right);
    d_(free) = solution;
  }

  std::vector<Exchange> Wrong() const {
    const VectorXd slope = H_ * d_ + g_;
    std::vector<Exchange> wrong;
    for (Index i = 0; i < g_.size(); ++i) {
      const double width = upper_(i) - lower_(i);
      if (!(width > 0.0)) continue;
      const double by = kPivotTolerance * std::min(width, std::abs(d_(i)));
      const double small = kPivotTolerance * std::abs(g_(i));
      if (places_[i] == Place::kFree) {
        if (d_(i) < lower_(i) - by) wrong.push_back({i, Place::kLower});
        if (d_(i) > upper_(i) + by) wrong.push_back({i, Place::kUpper});
      } else if (places_[i] == Place::kLower ? slope(i) < -small
                                             : slope(i) > small) {
        wrong.push_back({i, Place::kFree});
      }
    }
    return wrong;
  }

  const MatrixXd& H_;
  const VectorXd& g_;
  const VectorXd& lower_;
  const VectorXd& upper_;
  std::vector<Place> places_;
  VectorXd d_;
};

MatrixXd Damped(MatrixXd H, double damping) {
  // An unknown without effect stays where it is.
  const VectorXd scales =
      (H.diagonal().array() > 0.0).select(H.diagonal(), 1.0);
  H.diagonal() += damping * scales;
  return H;
}

}  // namespace

VectorXd MinimiseQuadratic(const MatrixXd& H, const VectorXd& g,
                           const VectorXd& lower, const VectorXd& upper) {
  return Pivoting(H, g, lower, upper).Run();
}

BoxLeastSquaresSummary MinimiseWithinBox(
    const std::function<QuadraticModel(const VectorXd&)>& evaluate,
    const VectorXd& lower, const VectorXd& upper,
    const BoxLeastSquaresOptions& options, VectorXd& x) {
  x = x.cwiseMax(lower).cwiseMin(upper);
  QuadraticModel at = evaluate(x);
  BoxLeastSquaresSummary summary;
  summary.cost = at.cost;
  if (!std::isfinite(at.cost)) return summary;
  double damping = kFirstDamping;
  while (summary.iterations < options.max_iterations) {
    ++summary.iterations;
    const VectorXd step = MinimiseQuadratic(Damped(at.hessian, damping),
                                            at.gradient, lower - x, upper - x);
    const double promised =
        -at.gradient.dot(step) - 0.5 * step.dot(at.hessian * step);
    const VectorXd moved = (x + step).cwiseMax(lower).cwiseMin(upper);
    if (!(promised > options.tolerance * at.cost)) {
      if (promised > 0.0) x = moved;
      at.cost -= std::max(promised, 0.0);
      summary.converged = true;
      break;
    }
    QuadraticModel next = evaluate(moved);
    const double share = (at.cost - next.cost) / promised;
    if (share > kLeastShareOfPromise) {
      x = moved;
      at = std::move(next);
      if (share > kGoodShare) {
        damping = std::max(0.1 * damping, kLeastStepDamping);
      }
      if (share < kPoorShare) damping *= 4.0;
    } else {
      damping = std::max(10.0 * damping, kRefusedDamping);
      // Rounding: no step is better.
      if (damping > kMostStepDamping) {
        summary.converged = true;
        break;
      }
    }
  }
  summary.cost = at.cost;
  return summary;
}

}  // namespace mle
