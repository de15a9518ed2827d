// A tank under predictive control for tests of trials: records of a plant whose
// set point moves, with white noise and drift.

#ifndef TESTS_MLE_TRIAL_TRIED_LOOP_H_
#define TESTS_MLE_TRIAL_TRIED_LOOP_H_

#include <cstdint>
#include <vector>

#include "mle/data/record.h"
#include "mle/model/process_model.h"

namespace mle {

// K e^{−4s}/(10 s + 1), minutes; it settles in 54.
ProcessModel Tank(double gain);

struct TriedLoop {
  double model_gain = 2.0;  // of the model in the controller
  double plant_gain = 2.0;
  double noise_variance = 1e-3;
  double drift_variance = 0.0;  // of its increments, by sample
  int changes = 0;              // of the set point, to 1 and 0 in turn
  double period = 240.0;        // between them, min
  double quiet = 600.0;         // before the first
};

// Sampled every minute.
Record RecordOf(const TriedLoop& loop, std::uint64_t seed);

}  // namespace mle

#endif  // TESTS_MLE_TRIAL_TRIED_LOOP_H_
