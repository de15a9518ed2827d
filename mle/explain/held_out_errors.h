// Errors of an output over several horizons, on blocks of 3 τ that had no part
// in the estimate of what explains it: the blocks are dealt out to five folds.
// Over a horizon h the error is that of the change from h before; of 0, of the
// free simulation, offsets and free responses apart.
// Internal to mle/explain.

#ifndef MLE_EXPLAIN_HELD_OUT_ERRORS_H_
#define MLE_EXPLAIN_HELD_OUT_ERRORS_H_

#include <functional>
#include <vector>

#include "Eigen/Core"
#include "mle/explain/competition.h"
#include "mle/explain/explained_output.h"
#include "mle/explain/instruments.h"

namespace mle {

// Errors at the horizons τ/5, τ, 3 τ and 0; those that fewer than two blocks
// show are left out.
// `estimate` gives the explanations estimated from the rows of weight one.
std::vector<HorizonErrors> HeldOutErrors(
    const ExplainedOutput& output, const Instruments& instruments,
    const std::function<
        std::vector<Explanation>(const Eigen::VectorXd& weights)>& estimate);

}  // namespace mle

#endif  // MLE_EXPLAIN_HELD_OUT_ERRORS_H_
