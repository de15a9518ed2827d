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
#include "absl/status/statusor.h"
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

}  // namespace mle::lifecycle

#endif  // APPS_LIFECYCLE_SCENARIO_H_
