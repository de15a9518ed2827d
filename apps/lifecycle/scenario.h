// The scenario that all policies share: the plant, its ageing, and the changes
// of set points.
//
// Times are in the process model's unit, 0 being the commissioning, when the
// model was right.

#ifndef APPS_LIFECYCLE_SCENARIO_H_
#define APPS_LIFECYCLE_SCENARIO_H_

#include <cstdint>
#include <vector>

#include "Eigen/Core"
#include "absl/status/status.h"
#include "mle/model/process_model.h"
#include "sim/ageing.h"

namespace mle::lifecycle {

struct SetPointEvent {
  double time = 0.0;
  int output = 0;          // −1: none is changed, the end of the years
  Eigen::VectorXd before;  // p, all set points before
  Eigen::VectorXd after;   // p, and from `time` on
};

struct SetPointOptions {
  double duration = 0.0;  // of all years, > 0
  // Mean time between changes, > 0; times between are uniform from half to one
  // and a half times it.
  double change_every = 0.0;
  // Times are whole multiples of it, > 0.
  double grid = 1.0;
  // Set points stay within ± this (p), > 0. A change is uniform over that
  // range, but of at least half of it.
  Eigen::VectorXd range;

  absl::Status Validate() const;
  double ShortestGap() const { return 0.5 * change_every; }
};

// In order of time; each changes one output. The last event is the end.
std::vector<SetPointEvent> DrawSetPointEvents(const SetPointOptions& options,
                                              std::uint64_t seed);

struct Scenario {
  ProcessModel model;  // what every controller begins with
  ProcessModel plant;  // as it is at time 0
  sim::AgeingSchedule ageing;
  std::vector<SetPointEvent> events;
  std::uint64_t seed = 1;

  ProcessModel PlantAt(double time) const {
    return sim::AgedModel(plant, ageing, time);
  }
};

// A slow disturbance of each output, one stationary path over all years:
//
//   d_{k+1} = φ d_k + √(1−φ²) s e_k,   φ = exp(−Δt/T),
//
// drawn stretch by stretch; the time between stretches is skipped in one
// step. It depends on the seed and the streams alone.

class SlowDisturbance {
 public:
  // `deviation` s ≥ 0 (p), `time` T > 0, `sample_time` Δt > 0.
  SlowDisturbance(std::uint64_t seed, Eigen::VectorXd deviation, double time,
                  double sample_time);

  // The path from `start` on: p × (samples + 1). The last value that was kept
  // is where it comes from.
  Eigen::MatrixXd Draw(std::uint64_t stream, double start, int samples) const;

  // Keeps the end of `path` as the disturbance at `time`.
  void Keep(const Eigen::MatrixXd& path, double time);

 private:
  std::uint64_t seed_;
  Eigen::VectorXd deviation_;
  double time_;
  double sample_time_;
  Eigen::VectorXd level_;  // at level_time_
  double level_time_ = 0.0;
};

// A step test: the controller is off, one input after the other is stepped, and
// the record is made for identification.
//
// Input j goes up by Δ_j, stays for `hold`, and back for `hold`, `cycles`
// times, where
//
//   Δ_j = min_i move_i / |K_ij|
//
// with the gains K of the model in use, so that no output is expected to move
// by more than `move`. Where an input would leave its limits it stays there.

struct StepTestOptions {
  double hold = 0.0;     // > 0
  int cycles = 1;        // ≥ 1
  Eigen::VectorXd move;  // p, > 0: the largest expected move of each output
};

struct StepTestPlan {
  double hold = 0.0;
  int cycles = 1;
  std::vector<int> inputs;  // in the order in which they are stepped
  Eigen::VectorXd steps;    // of each of them

  double duration() const {
    return 2.0 * hold * cycles * static_cast<double>(inputs.size());
  }
  // Deviation of all `num_inputs` inputs at `time` of the test.
  Eigen::VectorXd InputsAt(double time, int num_inputs) const;
};

// Steps the inputs that the controller moves and that reach an output.
StepTestPlan PlanStepTest(const ProcessModel& model,
                          const StepTestOptions& options);

}  // namespace mle::lifecycle

#endif  // APPS_LIFECYCLE_SCENARIO_H_
