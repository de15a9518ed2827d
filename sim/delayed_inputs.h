// Held inputs as they arrive through dead times that may change.
//
// Path i carries an input j_i with dead time L_i(t):
//
//   w_i(t) = u_{j_i}(t − L_i(t)),
//
// where u_j is held from sample to sample (zero-order hold). So w is piecewise
// constant; its jumps lie where t − L_i(t) passes a sampling instant, and are
// located exactly. Within one sample that gives a few events, each saying from
// when on a path carries the input of which earlier sample.
//
// The meaning of a changing dead time: L_i(t) is the age of what arrives at t
// (for a pipe: the time since it entered). While it grows at a rate β the input
// is seen stretched by 1/(1 − β), while it shrinks it is seen compressed;
// nothing is lost or repeated as long as dL/dt < 1, which is required. At an
// upward step of L by ΔL (a longer way is switched in) the path sees the last
// ΔL of its input once more, at a downward step it never sees ΔL of it.
//
// A jump within kSnap samples of a sampling instant counts as on it.

#ifndef SIM_DELAYED_INPUTS_H_
#define SIM_DELAYED_INPUTS_H_

#include <vector>

#include "Eigen/Core"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "sim/schedule.h"

namespace mle::sim {

inline constexpr double kSnap = 1e-9;  // of Δt

struct InputPath {
  int input = 0;
  Schedule delay = Schedule(0.0);  // L ≥ 0, dL/dt < 1
};

class DelayedInputs {
 public:
  // From `at` (in samples after the present one, in [0, 1]) on, path `path`
  // carries the input held `age` samples ago.
  struct Event {
    double at = 0.0;
    int path = 0;
    int age = 0;
  };

  // All past inputs zero. InvalidArgument for a path with a missing input, a
  // negative dead time or one longer than 10⁷ samples, or dL/dt ≥ 1.
  static absl::StatusOr<DelayedInputs> Create(int num_inputs,
                                              std::vector<InputPath> paths,
                                              double sample_time);

  int num_inputs() const { return static_cast<int>(history_.rows()); }
  int num_paths() const { return static_cast<int>(paths_.size()); }

  // Takes the input that is held from the sample at `time` to the next one.
  void Hold(double time, const Eigen::Ref<const Eigen::VectorXd>& input);

  // The events of that sample in order of `at`. Every path has one at 0.
  const std::vector<Event>& events() const { return events_; }
  // The value an event brings.
  double Value(const Event& event) const;

 private:
  DelayedInputs() = default;
  void AddEvents(double time, int path);
  void AddEventsOfPiece(double time, int path, double from, double to);

  double sample_time_ = 0.0;
  std::vector<InputPath> paths_;
  Eigen::MatrixXd history_;  // m × depth, a ring: column newest_ is u_k
  int newest_ = 0;
  std::vector<Event> events_;
};

}  // namespace mle::sim

#endif  // SIM_DELAYED_INPUTS_H_
