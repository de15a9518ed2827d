// One stage of the smoothed lasso (smoothed_lasso.h): a fixed ε, a fixed set of
// unknowns, one Ceres solve. Internal to mle/nonlinear.

#ifndef MLE_NONLINEAR_SMOOTHED_STAGE_H_
#define MLE_NONLINEAR_SMOOTHED_STAGE_H_

#include <string>

#include "Eigen/Core"

namespace mle {

struct SmoothedStage {
  Eigen::MatrixXd gram;      // G of the unknowns
  Eigen::VectorXd gradient;  // c = C − Gβ of all coefficients, at `beta`
  Eigen::VectorXd penalty;   // λw_j, finite
  Eigen::VectorXd beta;      // where to begin
  double smoothing = 0.0;    // ε > 0
  // A step that lowers the objective by no more than this is the last.
  double cost_tolerance = 0.0;
  // The radius of Ceres' trust region at first: large for nearly Newton's step.
  double trust_radius = 1e9;
  int max_steps = 3;        // that are taken, ≥ 1
  int max_iterations = 30;  // with those that are not
};

struct StageResult {
  bool usable = false;
  bool converged = false;
  Eigen::VectorXd beta;
  int iterations = 0;
  std::string message;  // of Ceres
};

StageResult SolveSmoothedStage(const SmoothedStage& stage);

}  // namespace mle

#endif  // MLE_NONLINEAR_SMOOTHED_STAGE_H_
