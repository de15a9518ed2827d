// The average operation of a plant under predictive control without limits:
// errors and moves from the noise, the disturbances and the changes of set
// points that it meets, computed, not simulated.
//
// Without limits the loop is linear. At the control instants the error y − r of
// each output and the move of each input, x below, answer
//
//   a step of the disturbance of output i      by D_i(k), k = 0, 1, …,
//   an impulse of it, H_i(k) = D_i(k) − D_i(k−1),
//   a step of its set point                    by R_i(k),
//
// so that with increments of variance q_i (a random walk), the autocovariances
// γ_i(h) of a stationary disturbance and white measurement noise of variance
// r_i at rest
//
//   σ² = Σ_i [ q_i Σ_k D_i(k)² + Σ_h γ_i(|h|) Σ_k H_i(k) H_i(k+|h|)
//              + r_i Σ_k H′_i(k)² ],
//
// H′_i being H_i without the noise itself, which the product does not have; a
// walk behind a lag answers by D_i behind that lag. A
// set point that moves by s_i adds, in all instants after it,
//
//   to ∫ (y − r)² dt   Δt_c Σ_k (s_i R_i(k))²,
//   to ∫ |y − r| dt    Δt_c Σ_k [A(s_i R_i(k), σ) − A(0, σ)],
//   to Σ |Δu|          Σ_k [A(s_i R_i(k), σ) − A(0, σ)],
//
// where A(m, σ) = E|m + σ z| = σ √(2/π) exp(−m²/2σ²) + m erf(m/(σ√2)), all of
// it Gaussian. Where an error of up to w is allowed, what is beyond it,
// ∫ max(0, |y − r| − w) dt, is told in the same way with
//
//   A_w(m, σ) = E max(0, |m + σ z| − w) = B(m − w) + B(−m − w),
//   B(d) = E max(0, d + σ z) = d Φ(d/σ) + σ φ(d/σ),
//
// A being A_0. Changes are taken to be so far apart that each is over before
// the next; the time between control instants is not looked at.
//
//   MLE_ASSIGN_OR_RETURN(const ExpectedOperation operation,
//                        ExpectOperation(mpc, plant, conditions));

#ifndef CONTROL_EXPECTED_OPERATION_H_
#define CONTROL_EXPECTED_OPERATION_H_

#include <vector>

#include "Eigen/Core"
#include "absl/status/statusor.h"
#include "control/mpc.h"
#include "control/operating_cost.h"
#include "mle/base/double_limits.h"
#include "mle/model/process_model.h"

namespace mle::control {

// The conditions that an output meets; variances in its squared unit.
struct OutputConditions {
  double noise_variance = 0.0;  // r ≥ 0, of the measurement alone
  double walk_variance = 0.0;   // q ≥ 0, of a control period
  // The walk acts behind a lag of this time constant, in control periods ≥ 0.
  double walk_lag = 0.0;
  std::vector<double> covariances = {};  // γ_0, γ_1, … by period; 0 beyond
  double changes = 0.0;                  // of its set point, per unit of time
  double change_size = 0.0;              // s, root mean square
  double allowed_error = kInfinity;      // w ≥ 0, of y − r either way
};

struct ExpectedOperation {
  // Sums over a unit of time; `violation` is of errors beyond the allowed ones.
  OperationSums sums;
  // p: σ² of the errors between changes, without the noise itself.
  Eigen::VectorXd resting_variance;
};

// `conditions`: p. The controller begins at rest; its limits are not looked
// at. InvalidArgument where sizes disagree, FailedPrecondition where the loop
// does not settle: it is not stable, too slow, or has outputs that the inputs
// cannot hold.
absl::StatusOr<ExpectedOperation> ExpectOperation(
    const Mpc& mpc, const ProcessModel& plant,
    const std::vector<OutputConditions>& conditions);

}  // namespace mle::control

#endif  // CONTROL_EXPECTED_OPERATION_H_
