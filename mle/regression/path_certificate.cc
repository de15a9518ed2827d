#include "mle/regression/path_certificate.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "mle/regression/duality_gap.h"

namespace mle {
namespace {

// A relative gap above the first may be the rounding of c, and rounding of β
// that changes c by more than the second, relative to λ, is seen in the gap: c
// is then computed from β in twice the working precision.
constexpr double kSharpen = 5e-11;
constexpr double kSeen = 1e-9;

// v − βᵀ(C + c) with β + t q; what it is relative to and known to goes to
// `result`.
double ResidualSquare(const ActiveSet& active, double step,
                      const Eigen::VectorXd& c, DualityGap& result) {
  const LassoObjective& objective = active.objective();
  PrimalRounding rounding(objective);
  double residual_square = objective.response_square;
  for (int i = 0; i < active.size(); ++i) {
    const int j = active.columns()[i];
    const double beta = active.beta(i) + step * active.slope(i);
    residual_square -= beta * (objective.correlation(j) + c(j));
    rounding.Add(j, beta);
  }
  result.response_square = objective.response_square;
  result.primal_rounding = rounding.Value();
  return residual_square;
}

// At λ = 0.
double LeastSquaresRelativeGap(const ActiveSet& active, double step,
                               const Eigen::VectorXd& gradient) {
  const LassoObjective& objective = active.objective();
  DualityGap result;
  const double residual_square = ResidualSquare(active, step, gradient, result);
  const bool all_active = active.Count(ActiveSet::State::kInactive) +
                              active.Count(ActiveSet::State::kWaiting) ==
                          0;
  result.primal = 0.5 * std::max(residual_square, 0.0);
  result.gap = all_active ? 0.5 * active.cholesky().InverseQuadraticForm(
                                      gradient(active.columns()))
                          : LeastSquaresGap(objective, gradient);
  return result.Relative();
}

}  // namespace

PathCertificate::PathCertificate(const Eigen::VectorXd& lambdas)
    : lambdas_(lambdas),
      relative_gap_(Eigen::VectorXd::Constant(
          lambdas.size(), std::numeric_limits<double>::infinity())),
      next_(lambdas.size() - 1) {}

double PathCertificate::GapFromC(const ActiveSet& active, double lambda,
                                 double step) {
  const LassoObjective& objective = active.objective();
  DualityGap result;
  double residual_square = ResidualSquare(active, step, c_, result);
  const int free = active.num_unpenalised();
  if (free > 0) {
    const std::vector<int> columns(active.columns().begin(),
                                   active.columns().begin() + free);
    const Eigen::VectorXd gradient = c_(columns);
    Eigen::VectorXd change = gradient;
    active.cholesky().SolveInPlace(change);
    const double explained = change.dot(gradient);
    residual_square -= explained;
    result.gap = 0.5 * explained;
    for (int i = 0; i < free; ++i) {
      c_ -= change(i) * objective.gram->col(columns[i]);
    }
  }
  residual_square = std::max(residual_square, 0.0);
  const double ratio =
      c_.cwiseAbs().cwiseProduct(active.inverse_weights()).maxCoeff() / lambda;
  const double alpha = 1.0 / std::max(ratio, 1.0);
  for (int i = free; i < active.size(); ++i) {
    const int j = active.columns()[i];
    const double beta = active.beta(i) + step * active.slope(i);
    const double penalty = lambda * objective.weights(j) * std::abs(beta);
    result.primal += penalty;
    result.gap += penalty - alpha * beta * c_(j);
  }
  result.primal += 0.5 * residual_square;
  result.gap += 0.5 * (1.0 - alpha) * (1.0 - alpha) * residual_square;
  result.gap = std::abs(result.gap);
  return result.Relative();
}

double PathCertificate::RelativeGap(const ActiveSet& active, double lambda,
                                    double step) {
  if (lambda > 0.0 && active.Rounding() <= kSeen * lambda) {
    c_ = active.c() - step * active.b();
    const double gap = GapFromC(active, lambda, step);
    if (gap <= kSharpen) return gap;
  }
  active.SharpC(step, c_);
  return lambda > 0.0 ? GapFromC(active, lambda, step)
                      : LeastSquaresRelativeGap(active, step, c_);
}

void PathCertificate::Start(const ActiveSet& active, double lambda_max,
                            double end) {
  Eigen::VectorXd start = Eigen::VectorXd::Zero(active.objective().size());
  start(active.columns()) = active.betas();
  for (; next_ >= 0 && Next() >= end; --next_) {
    const double lambda = Next();
    relative_gap_(next_) =
        active.size() == 0 && lambda > 0.0 && lambda >= lambda_max
            ? 0.0
            : ComputeDualityGap(active.objective(), lambda, start).Relative();
  }
}

void PathCertificate::Continue(const ActiveSet& active, double lambda,
                               double end, bool is_last) {
  for (; Next() > end || (is_last && Next() == end); --next_) {
    relative_gap_(next_) = RelativeGap(active, Next(), lambda - Next());
  }
}

void PathCertificate::Finish(const LassoObjective& objective,
                             const LassoPath& path) {
  if (path.segments().empty()) return;
  for (const double end = path.lambda_end(); Next() == end; --next_) {
    relative_gap_(next_) =
        ComputeDualityGap(objective, end, path.Coefficients(end)).Relative();
  }
}

}  // namespace mle
