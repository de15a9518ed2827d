// Records of simulated plants for the tests of output-error fits.

#ifndef TESTS_MLE_NONLINEAR_OUTPUT_ERROR_RECORDS_H_
#define TESTS_MLE_NONLINEAR_OUTPUT_ERROR_RECORDS_H_

#include <cmath>
#include <random>
#include <vector>

#include "Eigen/Core"
#include "absl/strings/str_cat.h"
#include "glog/logging.h"
#include "mle/data/record.h"
#include "mle/model/process_model.h"
#include "sim/plant.h"

namespace mle {

inline ProcessModel MakeModel(int num_outputs, int num_inputs) {
  std::vector<InputChannel> inputs(num_inputs);
  std::vector<OutputChannel> outputs(num_outputs);
  for (int j = 0; j < num_inputs; ++j) inputs[j].name = absl::StrCat("u", j);
  for (int i = 0; i < num_outputs; ++i) {
    outputs[i].name = absl::StrCat("y", i);
  }
  return ProcessModel("test", "min", inputs, outputs);
}

// Two inputs, one output.
inline ProcessModel TwoElements() {
  ProcessModel model = MakeModel(1, 2);
  model.element(0, 0) = TransferFunction::FirstOrder(2.0, 4.0, 1.0);
  model.element(0, 1) = TransferFunction::FirstOrder(-3.0, 6.0, 2.3);
  return model;
}

// The first element has aged in gain and dead time.
inline ProcessModel AgedPlant() {
  ProcessModel plant = TwoElements();
  plant.element(0, 0) = TransferFunction::FirstOrder(1.2, 4.0, 4.21);
  return plant;
}

struct RecordNoise {
  double variance = 0.0;   // r, white
  double increment = 0.0;  // q, of a random walk
  double offset = 0.0;     // of the outputs
  double shock = 0.0;      // s, of an autoregression of first order
  double pole = 0.0;       // φ
  double lag = 0.0;        // pole of a lag that it passes; 0: none
  double amplitude = 0.0;  // of a sine
  double period = 1.0;     // in samples
};

// Open loop: each input moves to a new random level now and then. Sampled every
// 0.5; the plant has run for `before` samples when the record begins.
inline Record MakeRecord(const ProcessModel& plant, int samples, unsigned seed,
                         const RecordNoise& noise, int before = 100) {
  std::mt19937_64 engine(seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform;
  auto simulated = sim::Plant::Create(plant, {.sample_time = 0.5});
  CHECK(simulated.ok()) << simulated.status();
  const int p = plant.num_outputs();
  const int m = plant.num_inputs();
  Record record;
  record.start_time = 0.5 * before;
  record.sample_time = 0.5;
  record.outputs.resize(p, samples);
  record.inputs.resize(m, samples);
  Eigen::VectorXd level = Eigen::VectorXd::Zero(p);
  Eigen::VectorXd input = Eigen::VectorXd::Zero(m);
  // Random numbers of its own: other noise is the same with and without.
  std::mt19937_64 ar_engine(seed + 1000);
  Eigen::VectorXd ar = Eigen::VectorXd::Zero(p);
  Eigen::VectorXd lagged = Eigen::VectorXd::Zero(p);
  for (int k = -before; k < samples; ++k) {
    for (int j = 0; j < m; ++j) {
      if (uniform(engine) < 0.02) input(j) = normal(engine);
    }
    for (int i = 0; i < p; ++i) {
      const double white = std::sqrt(noise.variance) * normal(engine);
      if (k >= 0) {
        const double sine = noise.amplitude *
                            std::sin(2.0 * M_PI * k / noise.period + seed + i);
        record.outputs(i, k) = simulated->outputs()(i) + level(i) +
                               noise.offset + white + lagged(i) + sine;
      }
      if (noise.shock > 0.0) {
        ar(i) = noise.pole * ar(i) + std::sqrt(noise.shock) * normal(ar_engine);
        lagged(i) = noise.lag * lagged(i) + (1.0 - noise.lag) * ar(i);
      }
      level(i) += std::sqrt(noise.increment) * normal(engine);
    }
    if (k >= 0) record.inputs.col(k) = input;
    simulated->Advance(input);
  }
  return record;
}

inline std::vector<Record> MakeRecords(const ProcessModel& plant, int samples,
                                       unsigned seed,
                                       const RecordNoise& noise) {
  return {MakeRecord(plant, samples, 2 * seed, noise),
          MakeRecord(plant, samples, 2 * seed + 1, noise)};
}

}  // namespace mle

#endif  // TESTS_MLE_NONLINEAR_OUTPUT_ERROR_RECORDS_H_
