// Steps of an output's level that nobody measures, among the whitened samples
// around one change of set points. Internal to mle/monitor.
//
// A step is 1 − exp(−(k − t + 1)/T) at the samples k ≥ t, 1 if T = 0 (LevelStep
// in output_error_correction.h). Of residuals e, whitened and without what the
// sensitivities, the offset and a ramp explain, clipped at four deviations s,
//
//   χ² = (xᵀe)²/(s² xᵀx),   x the step, whitened and reduced likewise,
//
// is scanned over t and T; the largest is a step where it exceeds 2 ln N + 8,
// then the next beside it, up to six. What a change of the parameters would
// explain is no step, and steps of which it would explain nine tenths are not
// looked for.

#ifndef MLE_MONITOR_LEVEL_STEPS_H_
#define MLE_MONITOR_LEVEL_STEPS_H_

#include <vector>

#include "Eigen/Core"
#include "mle/nonlinear/innovations_filter.h"

namespace mle {

// The whitened columns of the steps found (N × their number). `whitened`: the
// residual, then what is fitted beside it, one column at least; `filter` has
// whitened them, of samples at `instants`. `lags`: each T, in samples.
// `deviation`: of the residuals, at least.
Eigen::MatrixXd FindLevelSteps(const std::vector<int>& instants,
                               const InnovationsFilter& filter,
                               const std::vector<double>& lags,
                               double deviation,
                               const Eigen::MatrixXd& whitened);

}  // namespace mle

#endif  // MLE_MONITOR_LEVEL_STEPS_H_
