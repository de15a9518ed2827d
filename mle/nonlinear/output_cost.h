// The cost of one output's fit for Ceres, with one parameter block (K, ln T, L)
// for each of f free elements. In place of the N whitened residuals e and their
// Jacobian J without what the amplitudes explain, Ceres gets the rows of
// Cholesky's factor of (J e)ᵀ(J e), 3f + 1 of them: cost, gradient and normal
// matrix are the same. An evaluation takes O(N f²) operations, with f
// simulations and filters; what the elements held contribute is computed once.
// Amplitudes that are large cost a little, so that the objective is smooth
// where time constants come together and free responses become one. Internal to
// mle/nonlinear.

#ifndef MLE_NONLINEAR_OUTPUT_COST_H_
#define MLE_NONLINEAR_OUTPUT_COST_H_

#include <functional>
#include <memory>
#include <vector>

#include "Eigen/Core"
#include "mle/nonlinear/box_least_squares.h"
#include "mle/nonlinear/output_error_problem.h"

namespace ceres {
class CostFunction;
}  // namespace ceres

namespace mle {

// Elements that are not `free` stay at `point`. Dead times lie in the samples
// of `point`, or in any if not `fixed_cells`. `problem` must outlive it. One
// evaluation at a time.
std::unique_ptr<ceres::CostFunction> MakeOutputCost(
    const OutputErrorProblem& problem, const OutputPoint& point,
    const std::vector<bool>& free, const NoiseShape& shape, bool fixed_cells);

// The same for MinimiseWithinBox(): x is K, ln T and L of each free element.
std::function<QuadraticModel(const Eigen::VectorXd&)> MakeOutputModel(
    const OutputErrorProblem& problem, const OutputPoint& point,
    const std::vector<bool>& free, const NoiseShape& shape, bool fixed_cells);

}  // namespace mle

#endif  // MLE_NONLINEAR_OUTPUT_COST_H_
