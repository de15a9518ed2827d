// An integrating element as an integrator and what is left, which settles, both
// under held inputs (held_response.h):
//
//   e^{−Ls} N(s) / (s D(s)) = e^{−Ls} (K/s + R(s)),  L = (ℓ + f) Δt.
//
// The integrator starts ℓ' ≤ ℓ whole samples too early, x(k+1) = x(k) + K Δt
// v(k), so that all integrating elements of an output can share its state. What
// is left is R, ℓ' samples later, and an impulse response of −K Δt at the
// samples 1 … ℓ' and −f K Δt at ℓ' + 1. Internal to the project.

#ifndef MLE_MODEL_INTEGRATOR_SPLIT_H_
#define MLE_MODEL_INTEGRATOR_SPLIT_H_

#include <optional>

#include "absl/status/statusor.h"
#include "mle/model/row_realization.h"
#include "mle/model/transfer_function.h"

namespace mle {

struct IntegratorSplit {
  double slope = 0.0;              // K, per unit of time
  std::optional<RowElement> rest;  // its delay is 0; none where nothing is left
  double rest_gain = 0.0;          // what the response of the rest settles at
};

// `element` is valid and integrates; `left` is ℓ' ≥ 0; the other ℓ − ℓ' samples
// of dead time are taken out elsewhere. InvalidArgument as
// HeldResponse::Create().
absl::StatusOr<IntegratorSplit> SplitIntegrator(const TransferFunction& element,
                                                double sample_time, int left);

}  // namespace mle

#endif  // MLE_MODEL_INTEGRATOR_SPLIT_H_
