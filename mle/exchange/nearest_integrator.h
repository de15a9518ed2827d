// The integrator with one lag that is nearest to an integrating element,
//
//   K e^{−Ls} / (s (T s + 1)),
//
// among those of the same ramp: K is the element's, and L + T the time from
// which its ramp rises. Of all T the one of the smallest difference of the step
// response is taken.

#ifndef MLE_EXCHANGE_NEAREST_INTEGRATOR_H_
#define MLE_EXCHANGE_NEAREST_INTEGRATOR_H_

#include "mle/model/transfer_function.h"

namespace mle {

struct NearestIntegrator {
  double gain = 0.0;           // K
  double time_constant = 0.0;  // T
  double delay = 0.0;          // L
  // Differences between the step responses of integrator and element over dead
  // time and six times the slowest time constant, relative to the range of the
  // element's; 0 where the element has the form.
  double relative_rms = 0.0;
  double largest_difference = 0.0;

  // `element` is valid and integrates.
  static NearestIntegrator Of(const TransferFunction& element);
};

}  // namespace mle

#endif  // MLE_EXCHANGE_NEAREST_INTEGRATOR_H_
