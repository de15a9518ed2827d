// Days of a small plant for the tests of the watch: two outputs, of which the
// first has two elements, sampled every 5 min. Inputs step twice a day, as an
// operator moves them, or rest.

#ifndef TESTS_MLE_MONITOR_WATCHED_TANK_H_
#define TESTS_MLE_MONITOR_WATCHED_TANK_H_

#include <cstdint>
#include <vector>

#include "mle/model/process_model.h"
#include "mle/monitor/model_watch.h"

namespace mle {

inline constexpr double kTankSampleTime = 5.0;  // min
inline constexpr double kTankNoise = 0.05;      // standard deviation

ProcessModel TankModel();

struct TankDay {
  bool moves = true;
  double level = 0.0;  // added to the outputs
  std::uint64_t seed = 1;
};

// Of the plant `truth`, `lead` samples longer than a day.
WatchBatch SimulateTankDay(const ProcessModel& truth, const TankDay& day,
                           int lead);

}  // namespace mle

#endif  // TESTS_MLE_MONITOR_WATCHED_TANK_H_
