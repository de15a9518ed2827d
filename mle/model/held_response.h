// One transfer function with dead time under an input that is held between
// samples (zero-order hold), exact to rounding.
//
// With L = (q + f) Δt, 0 ≤ f < 1, the element ẋ = A x + B u(t − L), y = C x + D
// u(t − L) sees u_{k−q−1} during the first fΔt of sample k and u_{k−q} during
// the rest, so that
//
//   x_{k+1} = x_k + E x_k + b_older u_{k−q−1} + b_newer u_{k−q},
//   y_{k+1} = C x_{k+1} + D u_{k−q},
//
// y being that just before the input may change again. An f within 1e-9 of 0 or
// 1 is taken as the whole sample.

#ifndef MLE_MODEL_HELD_RESPONSE_H_
#define MLE_MODEL_HELD_RESPONSE_H_

#include "Eigen/Core"
#include "absl/status/statusor.h"
#include "mle/model/held_input_map.h"
#include "mle/model/transfer_function.h"

namespace mle {

struct HeldResponse {
  int whole_delay = 0;   // q
  SampleMap map;         // E, b_older, b_newer
  Eigen::RowVectorXd C;  // r
  double D = 0.0;

  // InvalidArgument for Δt that is none (ValidateSampleTime), for an invalid
  // element, where its dead time is longer than 10⁷ samples, and where its
  // coefficients over a sample are not finite.
  static absl::StatusOr<HeldResponse> Create(const TransferFunction& element,
                                             double sample_time);
};

}  // namespace mle

#endif  // MLE_MODEL_HELD_RESPONSE_H_
