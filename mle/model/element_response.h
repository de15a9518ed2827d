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

#include <algorithm>
#include <cmath>
#include <utility>

#include "Eigen/Core"
#include "absl/status/statusor.h"
#include "mle/model/held_input_map.h"
#include "mle/model/transfer_function.h"

namespace mle {

// L = (whole + fraction) Δt.
struct SampledDelay {
  int whole = 0;          // q ≥ 0
  double fraction = 0.0;  // f in [0, 1]
};

// f < 1, of a dead time that counts as at least 0 and at most 1e8 samples.
inline SampledDelay SampledDelayOf(double delay, double sample_time) {
  const double samples = std::clamp(delay / sample_time, 0.0, 1e8);
  const double whole = std::floor(samples);
  return {.whole = static_cast<int>(whole), .fraction = samples - whole};
}

class ElementRun;

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

  // The time 1/|s| of the pole whose mode is over first, or oscillates fastest,
  // as a share of T; 0 without modes.
  double shortest_time() const { return shortest_time_; }

  TransferFunction ToTransferFunction(const ElementValues& values) const;

  // columns (N × 3): the response for K = 1, its derivative by ln T and by L,
  // k = 0 … N−1, to `inputs` (N), held at `past_input` before and settled; of
  // an integrating element to what `inputs` differ from it. With one column
  // (N × 1) only the response is computed, in half the time.
  void Simulate(double time_scale, double sample_time, SampledDelay delay,
                const Eigen::Ref<const Eigen::VectorXd>& inputs,
                double past_input, Eigen::Ref<Eigen::MatrixXd> columns) const;
  // The same in pieces; `inputs` must outlive it.
  ElementRun Run(double time_scale, double sample_time, SampledDelay delay,
                 const Eigen::Ref<const Eigen::VectorXd>& inputs,
                 double past_input, bool derivatives) const;

  // The response of the output to states (r) left by former inputs, kΔt after,
  // k = 0 … n−1: columns (n × r), and their derivatives by ln T. n is
  // `samples`, or less: from there on both are zero, being 1e-18 of what they
  // were. Those of an integrating element are so but for constants.
  void FreeResponses(double time_scale, double sample_time,
                     Eigen::Index samples, Eigen::MatrixXd& columns,
                     Eigen::MatrixXd& derivatives) const;

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

// ElementResponse::Run(): columns of Simulate() in pieces, one after the other,
// that need not leave the cache.
class ElementRun {
 public:
  // The next samples of the inputs, as many as rows.
  void Next(Eigen::Ref<Eigen::MatrixXd> columns);

  // The recursion of an element of first order, for callers that run many
  // elements side by side:
  //
  //   x_{k+1} = a x_k + b₁ u_{k−q−1} + b₀ u_{k−q},   y_k = C x_k,
  //   d_{k+1} = a d_k + e x_k + c₁ u_{k−q−1} + c₀ u_{k−q},   ∂y/∂ln T = C d_k,
  //   ∂y/∂L = s x_k + t u_{k−q−1}.
  struct FirstOrder {
    double a = 0.0;
    double b1 = 0.0;
    double b0 = 0.0;
    double C = 0.0;
    double e = 0.0;  // 0 without derivatives, and the rest
    double c1 = 0.0;
    double c0 = 0.0;
    double s = 0.0;
    double t = 0.0;
    double x = 0.0;  // of the next sample; d is zero at the first
  };
  bool is_first_order() const {
    return !integrating_ && C_.size() == 1 && map_.E(0, 0) < -kLeastDecay;
  }
  FirstOrder AsFirstOrder() const;
  // u_{k−q−1} … u_{k−q+n−1} of the next n samples, to the first column of
  // `inputs`, whose rows are `stride` numbers apart; goes past these samples.
  void TakeInputs(Eigen::Index n, double* inputs, Eigen::Index stride);

 private:
  friend class ElementResponse;
  // Below this −E = 1 − a a loses digits that the state then lacks.
  static constexpr double kLeastDecay = 1e-4;
  ElementRun(const SampleMap& map, Eigen::RowVectorXd C,
             Eigen::RowVectorXd slope, double slope_by_input)
      : map_(map),
        C_(std::move(C)),
        slope_(std::move(slope)),
        slope_by_input_(slope_by_input) {}

  template <bool kDerivatives>
  void NextOfFirstOrder(Eigen::Ref<Eigen::MatrixXd> columns);
  template <int kStates, int kOrder, bool kDerivatives>
  void NextOfAnyOrder(Eigen::Ref<Eigen::MatrixXd> columns);
  // u_{k−q} of the next sample k + `later`.
  double InputAt(Eigen::Index later) const {
    const Eigen::Index k = next_ + later - whole_;
    return k < 0 ? past_input_ : inputs_[k];
  }

  SampleMap map_;
  Eigen::RowVectorXd C_;
  Eigen::RowVectorXd slope_;  // by L, of the state x and of u_{k−q−1}
  double slope_by_input_;
  Eigen::VectorXd state_;  // x, or x and T ∂x/∂T
  const double* inputs_ = nullptr;
  double past_input_ = 0.0;
  double base_ = 0.0;      // what inputs are counted from
  int whole_ = 0;          // q
  Eigen::Index next_ = 0;  // sample
  bool integrating_ = false;
  bool has_time_scale_ = true;
};

}  // namespace mle

#endif  // MLE_MODEL_ELEMENT_RESPONSE_H_
