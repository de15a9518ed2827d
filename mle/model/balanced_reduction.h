// A process model as a discrete state-space model of low order, by balanced
// truncation, with a bound of its error.
//
// Dead time that elements have in common is taken out first: a_j + c_i ≤ the
// dead time of element (i, j), in whole samples, by whichever of two rules
// (inputs first, outputs first) leaves less. Row by row, with input j divided
// by the largest magnitude s_ij of the element's step response, the exact
// discrete system of n states has Hankel singular values σ_1 ≥ … ≥ σ_n.
// Balanced and cut after r,
//
//   max_ω ‖(g_i(e^{jω}) − ĝ_i(e^{jω})) diag(s_i)⁻¹‖₂ ≤ 2 Σ_{k>r} σ_k.
//
// That bound needs no response, and is far too large for dead times that
// differ: their σ_k fall like a power of k only, and the sum over all of them
// asks for nearly every state. So r is the smallest order at which two things
// that are computed of the result are within the tolerance, for every element,
// relative to its s_ij: the bound of |g_ij − ĝ_ij| over all frequencies
// (response_difference.h; at most 4 % above the maximum), and the largest
// difference of the step responses and static gains. The rows stand one below
// the other: the order of the model is the sum of theirs.
//
//   MLE_ASSIGN_OR_RETURN(const ReducedModel reduced,
//                        ReduceModel(model, /*sample_time=*/0.2, {}));
//   reduced.system.order();  reduced.error_bounds.maxCoeff();
//
// The integrating elements of a row share one state, an integrator that is
// exact (integrator_split.h); what they have besides settles, and is reduced
// with the row. Their s_ij, error and differences are those of what they have
// besides.
//
// Square-root method: R and L with observability gramian RᵀR and
// controllability gramian L Lᵀ (row_realization.h), R L = U Σ Vᵀ, T = L V
// Σ^{−½} and T⁻¹ = Σ^{−½} Uᵀ R; no gramian is formed, none inverted.
//
// Cost: of a row about 30 n³ operations, n the longest dead time left in
// samples plus the orders of the row's elements, and for each of some ten
// orders tried N (2 m r (r + m) + 50 m log₂ N), N the samples until it has
// settled (at most 20,000). No matrix is larger than n × n, N × pm or 8N × 1.
// On one core a 20 × 20 model of 51 states a row takes half a second, a 7 × 7
// model of 84 states a row two seconds, a 20 × 20 model of 119 states a row
// some twenty.
//
// Moore, IEEE Trans. Autom. Control 26 (1981); Tombs and Postlethwaite, Int. J.
// Control 46 (1987); the bound in discrete time: Al-Saggaf and Franklin, IEEE
// Trans. Autom. Control 32 (1987).

#ifndef MLE_MODEL_BALANCED_REDUCTION_H_
#define MLE_MODEL_BALANCED_REDUCTION_H_

#include <vector>

#include "Eigen/Core"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "mle/model/process_model.h"
#include "mle/model/state_space.h"

namespace mle {

struct ReductionOptions {
  // The bound and the largest difference of a step response stay below this,
  // relative to the largest value of that step response; > 0. One percent is
  // half of the smallest change that counts as one
  // (DecisionOptions::least_change), and what an ARX model is held to as well
  // (kAcceptedArxError). Below some 1e-11 rounding decides.
  double tolerance = 0.01;
  // The states of a row before it is cut, and of the model after, are at most
  // this many, ≥ 1. Dead times of a row that differ by more samples than this
  // take more.
  int max_states = 1000;
  // Rows are reduced side by side; 0: one thread for each processor.
  int threads = 1;

  // Names the field, its value and the constraint broken.
  absl::Status Validate() const;
};

struct ReducedModel {
  DiscreteStateSpace system;
  // p: over all frequencies, and of step responses and static gains
  // (response_difference.h).
  Eigen::VectorXd error_bounds;
  Eigen::VectorXd largest_differences;
  std::vector<int> orders;                     // p: r of each row, with its
                                               // integrator
  std::vector<Eigen::VectorXd> hankel_values;  // p: σ of each row
  Eigen::VectorXd hankel_bounds;               // p: 2 Σ of those neglected
};

// InvalidArgument for options, models and sample times that are wrong, for a
// model without any element, and where a row has more states than max_states;
// FailedPrecondition where the model has, and where rounding leaves none within
// the tolerance.
absl::StatusOr<ReducedModel> ReduceModel(const ProcessModel& model,
                                         double sample_time,
                                         const ReductionOptions& options);

}  // namespace mle

#endif  // MLE_MODEL_BALANCED_REDUCTION_H_
