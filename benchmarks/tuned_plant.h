// A published plant under a predictive controller that is tuned by published
// rules: what several benchmarks run.

#ifndef BENCHMARKS_TUNED_PLANT_H_
#define BENCHMARKS_TUNED_PLANT_H_

#include <string>

#include "control/mpc_options.h"
#include "control/prediction_model.h"
#include "mle/model/process_model.h"

namespace mle::benchmarks {

struct TunedPlant {
  ProcessModel model;
  control::PredictionModel prediction;
  control::MpcOptions tuning;
  double sample_time = 0.0;
  int samples_of_period = 2;
  double lag = 0.0;  // in samples, the median of the elements
};

// Failures end the program.
TunedPlant TunePlant(ProcessModel model);
TunedPlant ReadTunedPlant(const std::string& path);

}  // namespace mle::benchmarks

#endif  // BENCHMARKS_TUNED_PLANT_H_
