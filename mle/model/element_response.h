// The sampled response of one element of a plant to an input that is held
// between samples, exact to rounding, and its derivatives.
//
// The element is K e^{−Ls} g₀(Ts) with g₀(0) = 1 and a fixed shape g₀: for a
// first-order element 1/(1 + s), so that T is its time constant. With
// g₀(s) = C (sI − A)⁻¹ B and L = (q + f) Δt, 0 ≤ f ≤ 1,
//
//   T ẋ = A x + B u(t − L),   y_k = K C x(kΔt),
//   T ∂ẋ/∂T = A ∂x/∂T − ẋ,    ∂x/∂L = −ẋ,
//
// where the input seen in [kΔt, (k+1)Δt) is u_{k−q−1} for the first fΔt and
// u_{k−q} after. An integrating element is K e^{−Ls} g₀(Ts)/s, with
// g₀(s) = C (sI − A)⁻¹ B + D, K its slope and
//
//   T ż = C x + D u(t − L),   y_k = K T z(kΔt);
//
// its response is that to u less the input before, at which it stands still:
// another balance is a ramp besides, of which an element knows nothing. The
// response is smooth in L within a sample q and has kinks
// where q changes, at each sample just after a move of the input; the caller
// says which q it means, so that at f = 0 and f = 1 the derivative is the one
// from inside that sample.
//
//   MLE_ASSIGN_OR_RETURN(const ElementResponse element,
//                        ElementResponse::Create(model.element(0, 1)));
//   element.Simulate(21.0, 0.2, {.whole = 15, .fraction = 0.5}, inputs,
//                    /*past_input=*/0.0, columns);

#ifndef MLE_MODEL_ELEMENT_RESPONSE_H_
#define MLE_MODEL_ELEMENT_RESPONSE_H_

#include "Eigen/Core"
#include "absl/status/statusor.h"
#include "mle/model/transfer_function.h"

namespace mle {

// What is fitted of an element. Time is in the process model's unit.
struct ElementValues {
  double gain = 0.0;        // K
  double time_scale = 1.0;  // T > 0, without a meaning where there is no lag
  double delay = 0.0;       // L ≥ 0
};

// L = (whole + fraction) Δt.
struct SampledDelay {
  int whole = 0;          // q ≥ 0
  double fraction = 0.0;  // f in [0, 1]
};

class ElementResponse {
 public:
  // Takes shape and values of `element`: K is its static gain (where that is 0,
  // the shape is the element itself and K is 1), T the time constant of its
  // slowest mode, or, of an integrator without lag, its dead time (1 if it has
  // none). InvalidArgument for a zero or invalid element, and for one with
  // feedthrough, whose sampled response jumps with L.
  static absl::StatusOr<ElementResponse> Create(
      const TransferFunction& element);

  const ElementValues& initial_values() const { return initial_values_; }
  bool is_integrating() const { return integrating_; }
  // The response depends on T.
  bool has_time_scale() const { return A_.rows() > 0; }
  // r, of modes that decay.
  int order() const { return static_cast<int>(A_.rows()); }

  // Of the mode that is over first, or oscillates fastest: 1/|s| of its pole,
  // as a share of T; 0 without modes.
  double shortest_time() const { return shortest_time_; }

  TransferFunction ToTransferFunction(const ElementValues& values) const;

  // columns (N × 3): the response for K = 1, its derivative by ln T and by L,
  // k = 0 … N−1, to `inputs` (N), held at `past_input` before and settled; of
  // an integrating element to what `inputs` differ from it.
  // Of one column (N × 1) the response alone, in half the time.
  void Simulate(double time_scale, double sample_time, SampledDelay delay,
                const Eigen::Ref<const Eigen::VectorXd>& inputs,
                double past_input, Eigen::Ref<Eigen::MatrixXd> columns) const;

  // What states (r) left by former inputs do to the output, kΔt after,
  // k = 0 … N−1: columns (N × r), and their derivatives by ln T. Those of an
  // integrating element are so but for constants. They are zero once they are
  // 1e-18 of what they were: from the row on whose number it returns.
  Eigen::Index FreeResponses(double time_scale, double sample_time,
                             Eigen::Ref<Eigen::MatrixXd> columns,
                             Eigen::Ref<Eigen::MatrixXd> derivatives) const;

 private:
  ElementResponse() = default;
  // x, and z of an integrating element, in the time unit T.
  struct System {
    Eigen::MatrixXd A;
    Eigen::VectorXd B;
    Eigen::RowVectorXd C;
  };
  System SystemAt(double time_scale) const;

  TransferFunction initial_;
  ElementValues initial_values_;
  double shape_gain_ = 1.0;  // of `initial_`, for K = 1
  bool integrating_ = false;
  double shortest_time_ = 0.0;
  Eigen::MatrixXd A_;     // r × r
  Eigen::VectorXd B_;     // r
  Eigen::RowVectorXd C_;  // r
  double D_ = 0.0;        // 0 but for an integrating element
};

}  // namespace mle

#endif  // MLE_MODEL_ELEMENT_RESPONSE_H_
