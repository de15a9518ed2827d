// How the elements of a process model age.
//
// An element g(s) = b(s)/a(s) e^{-Ls} with realisation A, B, C, D has, at time
// t, a gain factor γ(t) of any size, a factor of its time
// constants τ(t) > 0 and an increase of its dead time ΔL(t):
//
//   ẋ = (A x + B u(t − L − ΔL(t))) / τ(t),
//   y = γ(t) (C x + D u(t − L − ΔL(t))).
//
// So τ stretches all time constants of the element alike and leaves its static
// gain; for constant γ, τ, ΔL the element is γ g(τ s) with dead time L + ΔL. Of
// an integrating element γ and τ act on the rate of its integral and leave the
// slope K and what has been integrated: for constant γ, τ it is γ τ g(τ s).
// Where the element has another speed downwards (it is heated, and cools by
// itself), τ is longer by a factor while γ C ẋ < 0.
// Each is a schedule: drift over months is a few points far apart, an event is
// a step. delayed_inputs.h defines a changing dead time.
//
//   AgeingSchedule fouling;
//   fouling.elements.push_back({.output = 0, .input = 1, .gain = *drift});

#ifndef SIM_AGEING_H_
#define SIM_AGEING_H_

#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "mle/model/process_model.h"
#include "mle/model/transfer_function.h"
#include "sim/schedule.h"

namespace mle::sim {

// Something that ages in a plant of other equations (plant_at_rest.h): a factor
// > 0 of what it is when new, at the time of the plant, by the name that files
// of ageing have for it.
struct AgeingFactor {
  const char* name;
  Schedule* factor;
};

struct ElementAgeing {
  int output = 0;
  int input = 0;
  Schedule gain = Schedule(1.0);           // γ, a factor
  Schedule time_constant = Schedule(1.0);  // τ > 0, a factor
  Schedule delay = Schedule(0.0);  // ΔL, added; L + ΔL ≥ 0, slope < 1
  // Factor > 0 of τ while the element's output falls; 1 for an integrating
  // element. It has no part in AgedElement() and ScaleAgeing().
  double falling = 1.0;
};

struct AgeingSchedule {
  std::vector<ElementAgeing> elements;

  // Every element exists in `model`, is not zero there and is named once; the
  // ranges above hold, and what they make of the element has finite
  // coefficients. The message names the element.
  absl::Status Validate(const ProcessModel& model) const;
};

// The element as it is at `time`.
TransferFunction AgedElement(const TransferFunction& element,
                             const ElementAgeing& ageing, double time);

// The process as it is at `time`: a snapshot, the truth for who estimates it
// from a record of around that time.
ProcessModel AgedModel(const ProcessModel& model, const AgeingSchedule& ageing,
                       double time);

// The schedule of a plant that ages `rate` ≥ 0 times as far in the same time:
// at every point γ^rate, τ^rate and rate · ΔL, so that rate 0 is a plant that
// does not age. Between points the result is linear again. InvalidArgument for
// a rate that is negative or not finite, and for factors γ that are not
// positive.
absl::StatusOr<AgeingSchedule> ScaleAgeing(const AgeingSchedule& ageing,
                                           double rate);

}  // namespace mle::sim

#endif  // SIM_AGEING_H_
