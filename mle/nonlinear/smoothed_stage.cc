#include "mle/nonlinear/smoothed_stage.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "Eigen/Cholesky"
#include "ceres/ceres.h"

namespace mle {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using RowMatrix =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// Added to the diagonal of G, relative to it and for each unknown: a factor
// exists. Since the unknown is the step from where the stage begins, this holds
// the step back a little and leaves the minimiser where it is.
constexpr double kDiagonalShare = 1e-14;

// ½ ‖Lx − h‖² for the step x, LᵀL = G, Lᵀh = c − λw t: the quadratic part of
// the objective with the penalties' shares of the slope.
class QuadraticCost : public ceres::CostFunction {
 public:
  QuadraticCost(const MatrixXd& gram, const VectorXd& slope) {
    MatrixXd shifted = gram;
    shifted.diagonal() *=
        1.0 + kDiagonalShare * static_cast<double>(gram.rows());
    const Eigen::LLT<MatrixXd> factor(shifted);
    ok_ = factor.info() == Eigen::Success;
    L_ = factor.matrixU();
    h_ = factor.matrixL().solve(slope);
    set_num_residuals(static_cast<int>(slope.size()));
    *mutable_parameter_block_sizes() = {static_cast<int>(slope.size())};
  }

  bool ok() const { return ok_; }

  bool Evaluate(double const* const* x, double* residuals,
                double** jacobians) const override {
    const Eigen::Index n = h_.size();
    Eigen::Map<VectorXd>(residuals, n).noalias() =
        L_.triangularView<Eigen::Upper>() * Eigen::Map<const VectorXd>(x[0], n);
    Eigen::Map<VectorXd>(residuals, n) -= h_;
    if (jacobians != nullptr && jacobians[0] != nullptr) {
      Eigen::Map<RowMatrix>(jacobians[0], n, n) = L_;
    }
    return true;
  }

 private:
  bool ok_ = false;
  RowMatrix L_;
  VectorXd h_;
};

// Σ_j λw_j (√(β_j² + ε²) − t_j β_j), two residuals each: r_j and 0, with the
// derivatives r_j' and √(φ_j'' − r_j'²), as seen from axes that turn with β_j.
class PenaltyCost : public ceres::CostFunction {
 public:
  PenaltyCost(const SmoothedStage& stage, const VectorXd& share)
      : stage_(stage), share_(share) {
    set_num_residuals(2 * static_cast<int>(share.size()));
    *mutable_parameter_block_sizes() = {static_cast<int>(share.size())};
  }

  bool Evaluate(double const* const* x, double* residuals,
                double** jacobians) const override {
    const Eigen::Index n = share_.size();
    const bool with_jacobian = jacobians != nullptr && jacobians[0] != nullptr;
    if (with_jacobian) std::fill_n(jacobians[0], 2 * n * n, 0.0);
    for (Eigen::Index j = 0; j < n; ++j) {
      const double beta = stage_.beta(j) + x[0][j];
      const double t = share_(j);
      const double weight = stage_.penalty(j);
      const double root = std::hypot(beta, stage_.smoothing);
      // √(β² + ε²) − tβ > 0, without cancellation.
      const double rest =
          t * beta <= 0.0
              ? root - t * beta
              : (stage_.smoothing * stage_.smoothing +
                 (1.0 - std::abs(t)) * (1.0 + std::abs(t)) * beta * beta) /
                    (root + t * beta);
      const double r = std::sqrt(2.0 * weight * rest);
      residuals[2 * j] = r;
      residuals[2 * j + 1] = 0.0;
      if (!with_jacobian || !(r > 0.0)) continue;
      const double slope = weight * (beta / root - t) / r;
      const double curvature = weight * rest / (root * root);
      jacobians[0][2 * j * n + j] = slope;
      jacobians[0][(2 * j + 1) * n + j] =
          std::sqrt(std::max(curvature - slope * slope, 0.0));
    }
    return true;
  }

 private:
  const SmoothedStage& stage_;
  const VectorXd& share_;
};

// Ends a solve when the objective hardly changes, and after a few steps that
// were taken, so that t is set anew.
class StageEnd : public ceres::IterationCallback {
 public:
  StageEnd(double cost_tolerance, int max_steps)
      : cost_tolerance_(cost_tolerance), steps_left_(max_steps) {}

  ceres::CallbackReturnType operator()(
      const ceres::IterationSummary& iteration) override {
    if (iteration.iteration == 0 || !iteration.step_is_successful) {
      return ceres::SOLVER_CONTINUE;
    }
    --steps_left_;
    // Below the rounding of the cost its change says nothing.
    const double rounding =
        4.0 * std::numeric_limits<double>::epsilon() * iteration.cost;
    converged_ = iteration.cost_change <= std::max(cost_tolerance_, rounding);
    return converged_ || steps_left_ == 0 ? ceres::SOLVER_TERMINATE_SUCCESSFULLY
                                          : ceres::SOLVER_CONTINUE;
  }

  bool converged() const { return converged_; }

 private:
  double cost_tolerance_;
  int steps_left_;
  bool converged_ = false;
};

}  // namespace

StageResult SolveSmoothedStage(const SmoothedStage& stage) {
  const Eigen::Index n = stage.beta.size();
  StageResult result;
  // c scaled until it is allowed, as for the duality gap: what is left of the
  // slope then is (1 − scale) c, which G can give.
  double scale = 1.0;
  for (Eigen::Index j = 0; j < n; ++j) {
    const double size = std::abs(stage.gradient(j));
    if (stage.penalty(j) > 0.0 && size > stage.penalty(j)) {
      scale = std::min(scale, stage.penalty(j) / size);
    }
  }
  VectorXd share(n);
  for (Eigen::Index j = 0; j < n; ++j) {
    share(j) = stage.penalty(j) > 0.0
                   ? std::clamp(scale * stage.gradient(j) / stage.penalty(j),
                                -1.0, 1.0)
                   : 0.0;
  }
  auto quadratic = std::make_unique<QuadraticCost>(
      stage.gram, stage.gradient - stage.penalty.cwiseProduct(share));
  if (!quadratic->ok()) {
    result.message = "the Gram matrix of the unknowns has no Cholesky factor";
    return result;
  }
  VectorXd step = VectorXd::Zero(n);
  ceres::Problem problem;
  problem.AddResidualBlock(quadratic.release(), nullptr, step.data());
  problem.AddResidualBlock(new PenaltyCost(stage, share), nullptr, step.data());
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_NORMAL_CHOLESKY;
  options.max_num_iterations = stage.max_iterations;
  options.initial_trust_region_radius = stage.trust_radius;
  options.max_trust_region_radius = 1e32;
  options.jacobi_scaling = true;
  options.function_tolerance = 1e-17;
  options.parameter_tolerance = 1e-16;
  options.gradient_tolerance = 1e-18;
  options.logging_type = ceres::SILENT;
  StageEnd end(stage.cost_tolerance, stage.max_steps);
  options.callbacks.push_back(&end);
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  result.usable = summary.IsSolutionUsable() && step.allFinite();
  result.iterations = static_cast<int>(summary.iterations.size());
  result.message = summary.message;
  result.converged =
      end.converged() || summary.termination_type == ceres::CONVERGENCE;
  if (result.usable) result.beta = stage.beta + step;
  return result;
}

}  // namespace mle
