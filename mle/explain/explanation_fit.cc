#include "mle/explain/explanation_fit.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "Eigen/Cholesky"

namespace mle {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kIterations = 12;
constexpr double kStep = 1e-3;       // of θ, for derivatives
constexpr double kConverged = 1e-4;  // step of θ, or relative fall of E

}  // namespace

MatrixXd JacobianOf(const ExplainedOutput& output,
                    const ExplanationValue& value_of,
                    const std::vector<Explanation>& explanations,
                    const VectorXd& at) {
  MatrixXd jacobian(at.size(), static_cast<Index>(explanations.size()));
  for (std::size_t i = 0; i < explanations.size(); ++i) {
    std::vector<Explanation> moved = explanations;
    const double upper = output.Bounds(moved[i]).second;
    const double step = moved[i].value + kStep <= upper ? kStep : -kStep;
    moved[i].value += step;
    jacobian.col(static_cast<Index>(i)) = (value_of(moved) - at) / step;
  }
  return jacobian;
}

ExplanationFit FitExplanations(const ExplainedOutput& output,
                               const ExplanationValue& value_of,
                               std::vector<Explanation> explanations) {
  for (Explanation& one : explanations) {
    const auto [lower, upper] = output.Bounds(one);
    one.value = std::clamp(one.value, lower, std::max(lower, upper));
  }
  ExplanationFit fit;
  fit.explanations = std::move(explanations);
  VectorXd at = value_of(fit.explanations);
  fit.energy = at.squaredNorm();
  if (fit.explanations.empty()) return fit;
  double damping = 1e-3;
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    const MatrixXd J = JacobianOf(output, value_of, fit.explanations, at);
    const MatrixXd H = J.transpose() * J;
    const VectorXd g = J.transpose() * at;
    if (!(H.diagonal().maxCoeff() > 0.0)) break;
    bool better = false;
    double moved = 0.0;
    double fall = 0.0;
    for (int attempt = 0; attempt < 6 && !better; ++attempt) {
      MatrixXd damped = H;
      damped.diagonal() += damping * H.diagonal();
      damped.diagonal().array() += 1e-12 * H.diagonal().maxCoeff();
      const VectorXd step = -damped.ldlt().solve(g);
      std::vector<Explanation> trial = fit.explanations;
      moved = 0.0;
      for (std::size_t i = 0; i < trial.size(); ++i) {
        const auto [lower, upper] = output.Bounds(trial[i]);
        const double before = trial[i].value;
        trial[i].value = std::clamp(
            before + std::clamp(step[static_cast<Index>(i)], -0.5, 0.5), lower,
            std::max(lower, upper));
        moved = std::max(moved, std::abs(trial[i].value - before));
      }
      if (!(moved > 0.0)) break;
      const VectorXd value = value_of(trial);
      const double energy = value.squaredNorm();
      if (energy < fit.energy) {
        fall = (fit.energy - energy) / fit.energy;
        fit.explanations = std::move(trial);
        fit.energy = energy;
        at = value;
        better = true;
        damping *= 0.1;
      } else {
        damping = std::max(10.0 * damping, 1e-3);
      }
    }
    if (!better || moved < kConverged || fall < kConverged) break;
  }
  return fit;
}

}  // namespace mle
