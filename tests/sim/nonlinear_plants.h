// What the tests of all non-linear plants do with them.

#ifndef TESTS_SIM_NONLINEAR_PLANTS_H_
#define TESTS_SIM_NONLINEAR_PLANTS_H_

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "absl/status/statusor.h"
#include "gtest/gtest.h"
#include "mle/model/process_model.h"
#include "sim/continuous_plant.h"

namespace mle::testing {

inline sim::ContinuousSystem MadeSystem(
    absl::StatusOr<sim::ContinuousSystem> system) {
  EXPECT_TRUE(system.ok()) << system.status();
  return *std::move(system);
}

inline sim::ContinuousPlant PlantOf(const sim::ContinuousSystem& system,
                                    double sample_time) {
  absl::StatusOr<sim::ContinuousPlant> plant =
      sim::ContinuousPlant::Create(system, {.sample_time = sample_time});
  EXPECT_TRUE(plant.ok()) << plant.status();
  return *std::move(plant);
}

// ẋ at a state and inputs.
inline Eigen::VectorXd DerivativeOf(const sim::ContinuousSystem& system,
                                    const Eigen::VectorXd& state,
                                    const Eigen::VectorXd& inputs) {
  Eigen::VectorXd derivative = Eigen::VectorXd::Zero(state.size());
  system.derivative(0.0, state, inputs, derivative);
  return derivative;
}

// Holds the inputs for some samples.
inline void Hold(sim::ContinuousPlant& plant, const Eigen::VectorXd& inputs,
                 int samples) {
  for (int k = 0; k < samples; ++k) plant.Advance(inputs);
}

// How far the outputs are at most from those of the process model, over 100
// samples after a step of the inputs.
inline double DistanceFromModel(const sim::ContinuousSystem& system,
                                const ProcessModel& model, double sample_time,
                                const Eigen::VectorXd& step) {
  const int samples = 101;
  const StepResponse linear = model.ComputeStepResponse(sample_time, samples);
  sim::ContinuousPlant plant = PlantOf(system, sample_time);
  double worst = 0.0;
  for (int k = 0; k < samples; ++k) {
    for (int i = 0; i < model.num_outputs(); ++i) {
      double expected = 0.0;
      for (int j = 0; j < model.num_inputs(); ++j) {
        expected += linear.element(i, j)[k] * step[j];
      }
      worst = std::max(worst, std::abs(plant.outputs()[i] - expected));
    }
    plant.Advance(step);
  }
  return worst;
}

// That the model in configs/ is the plant linearised: what is between them is
// at most `tolerance`, and of the second order in the step.
inline void ExpectLinearisedAs(const std::string& config,
                               const sim::ContinuousSystem& system,
                               double sample_time, const Eigen::VectorXd& step,
                               double tolerance) {
  const absl::StatusOr<ProcessModel> model =
      ReadProcessModel(MLE_CONFIGS_FOLDER "/" + config);
  ASSERT_TRUE(model.ok()) << model.status();
  const double whole = DistanceFromModel(system, *model, sample_time, step);
  const double tenth =
      DistanceFromModel(system, *model, sample_time, 0.1 * step);
  EXPECT_LE(whole, tolerance);
  EXPECT_NEAR(whole / tenth, 100.0, 5.0);
}

}  // namespace mle::testing

#endif  // TESTS_SIM_NONLINEAR_PLANTS_H_
