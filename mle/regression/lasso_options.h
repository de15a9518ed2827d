// How a lasso problem is scaled (lasso_problem.h) and solved (lasso_solver.h).

#ifndef MLE_REGRESSION_LASSO_OPTIONS_H_
#define MLE_REGRESSION_LASSO_OPTIONS_H_

#include <functional>

#include "Eigen/Core"
#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace mle {

struct LassoObjective;  // lasso_problem.h

enum class Scaling {
  kStandardise,  // centre, unit variance, intercept
  kRaw,          // neither, no intercept
};

struct CoordinateDescentOptions {
  enum class Stop {
    kDualityGap,  // relative duality gap ≤ tolerance
    // MATLAB's `lasso`: a sweep changes β by ≤ tolerance ‖β‖₂ (its default
    // tolerance is 1e-4). Says little about the distance to the minimiser.
    kRelativeChange,
  };
  Stop stop = Stop::kDualityGap;
  double tolerance = 1e-9;  // > 0
  int max_sweeps = 100000;  // ≥ 1

  absl::Status Validate() const;
};

enum class LassoSolver {
  kHomotopy,
  kCoordinateDescent,
  kFunction,
  kElasticNet  // not the lasso: elastic_net.h
};

// β (n) at one λ ≥ 0, from a start nearby (n). Fails where a solve does.
using LassoFunction = std::function<absl::StatusOr<Eigen::VectorXd>(
    const LassoObjective& objective, double lambda,
    const Eigen::VectorXd& start)>;

struct LassoSolverOptions {
  LassoSolver solver = LassoSolver::kHomotopy;
  CoordinateDescentOptions coordinate_descent;
  LassoFunction function;  // of kFunction; may be called by several threads
  // ρ of kElasticNet, 0 < ρ ≤ 1. Its λ must be above 0, and its gap is that of
  // the elastic net.
  double elastic_net_ratio = 0.5;
};

}  // namespace mle

#endif  // MLE_REGRESSION_LASSO_OPTIONS_H_
