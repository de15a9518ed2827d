// E(M, R̂_λ) over the penalty λ, and the λ that is best in hindsight: what only
// a simulation can know.

#ifndef APPS_EXPERIMENT_DISTANCE_CURVE_H_
#define APPS_EXPERIMENT_DISTANCE_CURVE_H_

#include "Eigen/Core"
#include "mle/correction/correction.h"
#include "mle/model/arx_model.h"
#include "mle/model/step_response.h"

namespace mle::experiment {

// E, infinite for an unstable model whose response leaves the range of numbers.
double DistanceOrInfinity(const StepResponse& truth,
                          const StepResponse& response);

class DistanceCurve {
 public:
  // All three must outlive the curve; `lambdas` ascend.
  DistanceCurve(const Correction& correction, const Eigen::VectorXd& lambdas,
                const StepResponse& truth);

  // At λ of the grid, by number, one for all outputs.
  double operator()(Eigen::Index i);
  // At every λ of the grid.
  Eigen::VectorXd Whole();
  // The number of the smallest E: among λ that grow by 1 %, then among all
  // between the best one's neighbours.
  Eigen::Index Best();

 private:
  const Correction& correction_;
  const Eigen::VectorXd& lambdas_;
  const StepResponse& truth_;
  ArxModel model_;
};

}  // namespace mle::experiment

#endif  // APPS_EXPERIMENT_DISTANCE_CURVE_H_
