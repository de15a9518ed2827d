// How much of what an output does a simulated response explains: 1 − Σ (y − ŷ)²
// over Σ y², each less its own trend in every window. At most 1; negative where
// the response is worse than none.

#ifndef MLE_MAINTAIN_SIMULATED_SHARE_H_
#define MLE_MAINTAIN_SIMULATED_SHARE_H_

#include <vector>

#include "Eigen/Core"

namespace mle {

// The share for one output in all windows, without gaps; responses are as long.
// 0 where the output does not move.
double SimulatedShare(const std::vector<Eigen::VectorXd>& outputs,
                      const std::vector<Eigen::VectorXd>& responses);

// The share for an output that integrates: of its moves over 20 samples.
double SimulatedShareOfIncrements(
    const std::vector<Eigen::VectorXd>& outputs,
    const std::vector<Eigen::VectorXd>& responses);

}  // namespace mle

#endif  // MLE_MAINTAIN_SIMULATED_SHARE_H_
