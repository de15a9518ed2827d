// The cost of one output's fit for Ceres: whitened residuals, with one
// parameter block (K, ln T, L) for each element. Internal to mle/nonlinear.

#ifndef MLE_NONLINEAR_OUTPUT_COST_H_
#define MLE_NONLINEAR_OUTPUT_COST_H_

#include <memory>

#include "mle/nonlinear/output_error_problem.h"

namespace ceres {
class CostFunction;
}  // namespace ceres

namespace mle {

// Dead times lie in the samples of `point`, or in any if not `fixed_cells`.
// `problem` must outlive it.
std::unique_ptr<ceres::CostFunction> MakeOutputCost(
    const OutputErrorProblem& problem, const OutputPoint& point,
    const NoiseShape& shape, bool fixed_cells);

}  // namespace mle

#endif  // MLE_NONLINEAR_OUTPUT_COST_H_
