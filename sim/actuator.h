// The actuator between the input that a controller asks for and the one that
// acts on the plant: a valve that sticks, its ends, its characteristic and how
// fast it moves. The record holds the input asked for.
//
// Friction, with the two parameters of the data-driven models of Choudhury,
// Thornhill and Shah (Control Engineering Practice 13, 2005, p. 641) and of
// Kano, Maruta, Kugemoto and Shimizu (DYCOPS, 2004): S, deadband plus
// stickband, and the slip jump J. With f_S = (S + J)/2 and f_D = (S − J)/2 a
// valve at rest at x stays there while |u − x| ≤ f_S, and one that moves in the
// direction d = ±1 is at x = u − d f_D until u stands still or turns. J = 0 is
// backlash of width S; J = S has no lag while the valve moves.
//
// Characteristic: equal percentage of rangeability R, scaled to have the slope
// 1 at the operating point, where u = 0:
//
//   φ(x) = s (R^{x/s} − 1) / ln R,   x in s · [−l₀, 1 − l₀],
//
// with s the span, the change of the input over the full stroke, and l₀ the
// stem's position at the operating point. R = 1 is linear without ends. Of a
// split range the slope changes where the second valve takes over: beyond the
// kink k ≥ 0, φ(x) is φ(k) + c (φ(x) − φ(k)).
//
// Ends: the stem stays in [min, max]. Rate: what acts follows φ by at most r a
// unit of time.

#ifndef SIM_ACTUATOR_H_
#define SIM_ACTUATOR_H_

#include <limits>

#include "Eigen/Core"
#include "absl/status/status.h"
#include "mle/model/process_model.h"

namespace mle::sim {

struct ActuatorOptions {
  int input = 0;              // not a disturbance
  double stiction = 0.0;      // S ≥ 0, in the input's unit
  double slip_jump = 0.0;     // J ≥ 0, in the input's unit
  double rangeability = 1.0;  // R ≥ 1
  double span = 1.0;          // s > 0, in the input's unit
  double position = 0.5;      // l₀ in [0, 1]
  double kink = 0.0;          // k ≥ 0, in the input's unit
  double kink_slope = 1.0;    // c, finite
  double min = -std::numeric_limits<double>::infinity();  // ≤ 0
  double max = std::numeric_limits<double>::infinity();   // ≥ 0
  double rate = std::numeric_limits<double>::infinity();  // r > 0

  absl::Status Validate(const ProcessModel& channels) const;
};

// At rest at 0. For valid options.
class Actuator {
 public:
  explicit Actuator(const ActuatorOptions& options) : options_(options) {}

  // To be called at every control instant with the input asked for; what acts
  // from then on, if there is no limit of the rate.
  double Move(double asked);
  // To be called at every sample, after Move; what acts during that sample.
  double Act(double sample_time);

  int input() const { return options_.input; }

 private:
  double EqualPercentage(double stem) const;
  double Characteristic(double stem) const;

  ActuatorOptions options_;
  double asked_ = 0.0;      // at the instant before
  double stem_ = 0.0;       // x
  double direction_ = 0.0;  // d, 0 at rest
  double target_ = 0.0;     // φ(x)
  double acting_ = 0.0;
};

}  // namespace mle::sim

#endif  // SIM_ACTUATOR_H_
