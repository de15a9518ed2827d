// The lasso at one λ as a smooth problem for Ceres,
//
//   minimise  ½ βᵀGβ − Cᵀβ + ½v + λ Σ_j w_j √(β_j² + ε²),   ε → 0,
//
// on the compressed problem (G, C and v of lasso_problem.h: the raw rows are
// not needed) and on the few coefficients that can be other than zero.
//
// Written naively, as residuals √(2λw(√(β² + ε²) − ε)), it converges slowly:
// the Gauss–Newton matrix then holds a curvature of λw/2|β|, where the
// objective has nearly none. Here each penalty keeps the slope λwt that the
// optimum asks of it, t = c/λw, c = C − Gβ, |t| ≤ 1, as its share of the
// linear term, and only the rest is a residual,
//
//   r = √(2λw (√(β² + ε²) − tβ)),  J = (r', √(φ'' − r'²)),
//
// whose second row turns with r: JᵀJ is the penalty's own curvature φ'', so
// that Levenberg–Marquardt takes Newton's steps. The minimiser does not depend
// on t.
//
// ε falls by stages. In each, coefficients held at zero whose |c_j| exceeds
// λw_j join the unknowns, and those far inside leave. At the smoothed optimum
// |c_j| < λw_j, so that the duality gap against the true problem is at most 0.3
// ελ Σ w_j; it is computed (duality_gap.h), for all coefficients, and ends the
// descent. Coefficients that only ε keeps from zero are then set to zero and
// the others solved once more.
//
//   MLE_ASSIGN_OR_RETURN(const SmoothedLassoSummary fit,
//                        SolveSmoothedLasso(LassoObjective(problem, 0), 1e-4,
//                                           {}, SmoothedLassoOptions()));
//   if (fit.gap.Relative() <= 1e-6) use(fit.beta);
//
// Smoothing: Nesterov, Math. Program. 103, 2005; curvature as residuals:
// Triggs, McLauchlan, Hartley and Fitzgibbon, Vision Algorithms, 2000,
// sec. 4.3.

#ifndef MLE_NONLINEAR_SMOOTHED_LASSO_H_
#define MLE_NONLINEAR_SMOOTHED_LASSO_H_

#include <limits>
#include <string>

#include "Eigen/Core"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "mle/regression/duality_gap.h"
#include "mle/regression/lasso_problem.h"
#include "mle/regression/lasso_solver.h"

namespace mle {

struct SmoothedLassoOptions {
  // Relative duality gap at which the descent of ε ends; > 0.
  double tolerance = 1e-9;
  // ε falls to this share from stage to stage, in (0, 1).
  double smoothing_decrease = 0.1;
  int max_stages = 300;     // Ceres solves in all, ≥ 1
  int max_iterations = 30;  // of each, ≥ 1

  absl::Status Validate() const;
};

enum class SmoothedLassoTermination {
  kNotRun,
  kConverged,
  kStageLimit,  // max_stages solves did not reach the tolerance
  kFailed,      // Ceres failed; `message` says how
};

struct SmoothedLassoSummary {
  SmoothedLassoTermination termination = SmoothedLassoTermination::kNotRun;
  Eigen::VectorXd beta;  // n
  DualityGap gap;        // of beta, against the true problem
  // ε of the last solve: what smoothing is left in coefficients not zero.
  double smoothing = std::numeric_limits<double>::infinity();
  int num_nonzero = 0;
  int max_unknowns = 0;  // of any one solve
  int solves = 0;
  int iterations = 0;   // of all solves
  std::string message;  // of the last solve, by Ceres

  std::string BriefReport() const;  // One line.
};

// λ ≥ 0; at λ = 0 nothing is left to smooth, and the least-squares solution of
// smallest norm is returned. `start` (n, or empty for zero) is where to begin:
// the solution at a λ nearby. InvalidArgument for invalid input only; that a
// solve fails is in the summary.
absl::StatusOr<SmoothedLassoSummary> SolveSmoothedLasso(
    const LassoObjective& objective, double lambda,
    const Eigen::VectorXd& start, const SmoothedLassoOptions& options);

// The same for SolveLasso(): options that solve each λ so.
LassoSolverOptions SmoothedLassoSolver(const SmoothedLassoOptions& options);

}  // namespace mle

#endif  // MLE_NONLINEAR_SMOOTHED_LASSO_H_
