// Robust losses by weights: at the minimum of
// Σ ρ(e_k/s) over parameters that residuals e_k depend on,
//
//   Σ w_k e_k ∂e_k = 0,   w_k = ψ(e_k/s) / (e_k/s),   ψ = ρ′,
//
// so that it is the fixed point of least squares weighted with its own w_k
// (iteratively reweighted least squares).
//
//   Huber   w = min(1, c/|e/s|)         c = 1.345
//   Cauchy  w = 1/(1 + (e/(cs))²)       c = 2.3849
//
// with 95 % of least squares' efficiency each under Gaussian noise. Huber's ρ
// is convex; under Cauchy's the influence of a large residual tends to 0. s is
// 1.4826 times the median |e_k|. Sources: Huber and Ronchetti, Robust
// Statistics, 2nd ed. 2009, ch. 6 and 7; Holland and Welsch, Commun. Stat. A 6,
// 1977 (constants).

#ifndef MLE_NONLINEAR_ROBUST_LOSS_H_
#define MLE_NONLINEAR_ROBUST_LOSS_H_

#include "Eigen/Core"

namespace mle {

enum class RobustLoss { kNone, kHuber, kCauchy };

// Weights are found where no round moves one by more than this.
inline constexpr double kWeightTolerance = 1e-3;

// ψ(x)/x and ψ′(x), x = e/s; 1 and 1 without a loss.
double RobustWeight(RobustLoss loss, double x);
double RobustCurvature(RobustLoss loss, double x);

struct RobustWeights {
  Eigen::VectorXd weights;  // in (0, 1]
  double scale = 0.0;       // s; 0 where more than half the residuals are 0
  // The covariance of parameters is this times what weighted least squares
  // takes for it, Σ we²/N (JᵀWJ)⁻¹: s² E[ψ²]/E[ψ′]² (JᵀJ)⁻¹, with means over
  // the residuals.
  double variance_factor = 1.0;
};

// Weights for residuals of one size; all 1 without a loss, or where s is 0.
RobustWeights ComputeRobustWeights(RobustLoss loss,
                                   const Eigen::VectorXd& residuals);

}  // namespace mle

#endif  // MLE_NONLINEAR_ROBUST_LOSS_H_
