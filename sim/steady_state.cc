#include "sim/steady_state.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "Eigen/LU"
#include "absl/status/status.h"
#include "absl/strings/str_cat.h"

namespace mle::sim {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kMaxIterations = 100;
constexpr double kTolerance = 1e-9;
constexpr double kSmallestStep = 1e-6;

VectorXd NumericDerivative(const SystemFunction& f, const VectorXd& state,
                           const VectorXd& inputs) {
  VectorXd result = VectorXd::Zero(state.size());
  f(0.0, state, inputs, result);
  return result;
}

// The step that balances truncation and rounding of a central difference.
double DifferenceStep(double value) {
  return std::cbrt(std::numeric_limits<double>::epsilon()) *
         std::max(std::abs(value), 1.0);
}

// The largest |f_i| relative to what a relative change of x by 1 would do.
double RelativeResidual(const VectorXd& f, const MatrixXd& A,
                        const VectorXd& x) {
  const VectorXd size = x.cwiseAbs().cwiseMax(1.0);
  double worst = 0.0;
  for (Index i = 0; i < f.size(); ++i) {
    const double scale =
        (A.row(i).cwiseAbs().transpose().cwiseProduct(size)).maxCoeff();
    if (f[i] == 0.0) continue;
    worst = std::max(worst, std::abs(f[i]) / scale);
  }
  return worst;
}

}  // namespace

Linearisation Linearise(const SystemFunction& derivative, const VectorXd& state,
                        const VectorXd& inputs) {
  const auto column = [&](VectorXd& varied, Index k) {
    const double at = varied[k];
    const double h = DifferenceStep(at);
    varied[k] = at + h;
    return std::pair<double, double>(at, h);
  };
  Linearisation linear{MatrixXd(state.size(), state.size()),
                       MatrixXd(state.size(), inputs.size())};
  VectorXd x = state;
  for (Index k = 0; k < x.size(); ++k) {
    const auto [at, h] = column(x, k);
    const VectorXd above = NumericDerivative(derivative, x, inputs);
    x[k] = at - h;
    linear.A.col(k) =
        (above - NumericDerivative(derivative, x, inputs)) / (2.0 * h);
    x[k] = at;
  }
  VectorXd w = inputs;
  for (Index k = 0; k < w.size(); ++k) {
    const auto [at, h] = column(w, k);
    const VectorXd above = NumericDerivative(derivative, state, w);
    w[k] = at - h;
    linear.B.col(k) =
        (above - NumericDerivative(derivative, state, w)) / (2.0 * h);
    w[k] = at;
  }
  return linear;
}

absl::StatusOr<VectorXd> SolveSteadyState(const SystemFunction& derivative,
                                          const VectorXd& inputs,
                                          VectorXd guess) {
  VectorXd x = std::move(guess);
  VectorXd f = NumericDerivative(derivative, x, inputs);
  double residual = std::numeric_limits<double>::infinity();
  for (int i = 0; i < kMaxIterations; ++i) {
    const MatrixXd A = Linearise(derivative, x, inputs).A;
    residual = RelativeResidual(f, A, x);
    const VectorXd move = A.partialPivLu().solve(f);
    if (!move.allFinite()) break;
    double step = 1.0;
    VectorXd next = x - move;
    VectorXd next_f = NumericDerivative(derivative, next, inputs);
    while (!(next_f.norm() < f.norm()) && step > kSmallestStep) {
      step *= 0.5;
      next = x - step * move;
      next_f = NumericDerivative(derivative, next, inputs);
    }
    // No better point: x is as good as rounding lets it be, or a dead end.
    if (!(next_f.norm() < f.norm())) break;
    x = next;
    f = next_f;
  }
  if (x.allFinite() && residual <= kTolerance) return x;
  return absl::FailedPreconditionError(absl::StrCat(
      "no steady state was found near the guess: the derivatives stay at ",
      residual, " of their scale, above ", kTolerance));
}

}  // namespace mle::sim
