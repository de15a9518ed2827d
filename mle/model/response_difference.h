// How far a model is from the one that it stands for, by their step responses:
// φ_k, k = 0 … N, of `found`, with static gains K, and ψ_k of `wanted`, with G.
// Both of the same shape, zero at k = 0; of pair (i, j) relative to
//
//   s_ij = max(max_k |ψ_k|, |G|).

#ifndef MLE_MODEL_RESPONSE_DIFFERENCE_H_
#define MLE_MODEL_RESPONSE_DIFFERENCE_H_

#include "Eigen/Core"
#include "mle/model/step_response.h"

namespace mle {

struct ResponsesOfModel {
  StepResponse response;
  Eigen::MatrixXd gains;  // p × m
};

// p: over the inputs j the largest of max(max_k |φ_k − ψ_k|, |K − G|) / s_ij.
// Pairs that do not respond in `wanted` do not count; infinite where a
// difference is not finite.
Eigen::VectorXd RelativeDifferences(const ResponsesOfModel& found,
                                    const ResponsesOfModel& wanted);

// p: over the inputs j the largest bound, over all frequencies, of the gain of
// the difference, relative to s_ij: with δ = φ − ψ and h_k = δ_k − δ_{k−1},
// k = 1 … N,
//
//   (max_ω |Σ_k h_k e^{−jωk}| + |K − G − δ_N|) / s_ij
//
// (largest_gain.h). What lies beyond N is taken to keep its sign: then its part
// of the sum is at most what δ still moves.
Eigen::VectorXd LargestGainsOfDifference(const ResponsesOfModel& found,
                                         const ResponsesOfModel& wanted);

}  // namespace mle

#endif  // MLE_MODEL_RESPONSE_DIFFERENCE_H_
