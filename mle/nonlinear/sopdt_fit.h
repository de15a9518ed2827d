// Fit of a second-order-plus-dead-time element to a sampled step response y_k,
// k = 0 … N, and what shapes no such element has:
//
//   min over K, T₁ ≥ T₂, L of Σ_k (y_k − h(kΔt))²,
//   h(t) = K (1 − (T₁ e^{−s/T₁} − T₂ e^{−s/T₂}) / (T₁ − T₂)),  s = t − L > 0,
//
// and 0 before: two lags in series, no overshoot. Unlike a first-order
// response, h starts with slope 0, so that the objective is smooth in L; it
// still has local minima. Gain and all combinations of dead time (every sample)
// and time constants (a logarithmic grid) are searched in closed form, and
// Ceres refines the best of them.
//
//   MLE_ASSIGN_OR_RETURN(const SopdtFit fit,
//                        FitSopdt(response.element(0, 1), 0.2, {}));

#ifndef MLE_NONLINEAR_SOPDT_FIT_H_
#define MLE_NONLINEAR_SOPDT_FIT_H_

#include <limits>
#include <string>

#include "Eigen/Core"
#include "absl/status/statusor.h"
#include "mle/model/transfer_function.h"
#include "mle/nonlinear/fopdt_fit.h"

namespace mle {

enum class ResponseShape {
  kSettling,
  kNoResponse,   // within the options' negligible_response
  kIntegrating,  // still moving at the end
  kInverse,      // first goes the other way
};

// Reads a step response without a model. It is integrating if over its last
// quarter it moves by more than a fifth of its range and at least half as fast
// as over the quarter before; inverse if it goes further than 5 % of its range
// to the other side of rest than it ends on.
ResponseShape ClassifyResponse(
    const Eigen::Ref<const Eigen::VectorXd>& step_response,
    double negligible_response);

struct SopdtFit {
  double gain = 0.0;                  // K
  double time_constant = 0.0;         // T₁
  double second_time_constant = 0.0;  // T₂ ≤ T₁
  double delay = 0.0;                 // L

  // As those of FopdtFit. Where T₁ = T₂ they cannot be told apart, and their
  // errors are infinite.
  double gain_standard_error = std::numeric_limits<double>::infinity();
  double time_constant_standard_error = std::numeric_limits<double>::infinity();
  double second_time_constant_standard_error =
      std::numeric_limits<double>::infinity();
  double delay_standard_error = std::numeric_limits<double>::infinity();

  // Relative to the response's range.
  double relative_rms = std::numeric_limits<double>::infinity();
  double relative_max_residual = std::numeric_limits<double>::infinity();

  ResponseShape response = ResponseShape::kNoResponse;
  FopdtShape shape = FopdtShape::kPoorFit;
  FopdtTermination termination = FopdtTermination::kNotRun;
  int iterations = 0;

  TransferFunction ToTransferFunction() const;
  std::string BriefReport() const;  // One line.
};

// Options and errors are those of FitFopdt(); the response needs six samples.
// The fit is poor where FitFopdt() would call it so, and for every response
// that does not settle or goes the other way first.
absl::StatusOr<SopdtFit> FitSopdt(
    const Eigen::Ref<const Eigen::VectorXd>& step_response, double sample_time,
    const FopdtOptions& options);

}  // namespace mle

#endif  // MLE_NONLINEAR_SOPDT_FIT_H_
