// A plant with one input and one output, small enough for years in a blink.

#ifndef TESTS_APPS_LIFECYCLE_SMALL_SCENARIO_H_
#define TESTS_APPS_LIFECYCLE_SMALL_SCENARIO_H_

#include <utility>

#include "apps/lifecycle/life.h"
#include "apps/lifecycle/scenario.h"
#include "mle/model/process_model.h"
#include "sim/ageing.h"

namespace mle::lifecycle::testing {

inline ProcessModel Tank(double gain = 2.0) {
  ProcessModel model("tank", "min", {{"steam", ""}}, {{"level", ""}});
  model.element(0, 0) = TransferFunction::FirstOrder(gain, 8.0, 3.0);
  return model;
}

// The gain goes linearly to `factor` of what it was within `time`.
inline sim::AgeingSchedule Fouling(double factor, double time) {
  sim::AgeingSchedule ageing;
  sim::ElementAgeing element;
  element.gain = *sim::Schedule::Create({{0.0, 1.0}, {time, factor}});
  ageing.elements.push_back(std::move(element));
  return ageing;
}

inline SetPointOptions Changes(int count, double every = 2000.0) {
  SetPointOptions options;
  options.duration = count * every;
  options.change_every = every;
  options.range = Eigen::VectorXd::Ones(1);
  return options;
}

inline Scenario TankScenario(int changes, sim::AgeingSchedule ageing,
                             std::uint64_t seed = 1) {
  Scenario scenario;
  scenario.model = Tank();
  scenario.plant = Tank();
  scenario.ageing = std::move(ageing);
  scenario.events = DrawSetPointEvents(Changes(changes), seed);
  scenario.seed = seed;
  return scenario;
}

inline OperationOptions QuietTank() {
  OperationOptions options;
  options.sample_time = 1.0;
  options.noise_variance = 0.0;
  options.controller.control_period = 1.0;
  options.controller.output_weight = Eigen::MatrixXd::Identity(1, 1);
  options.controller.move_weight = Eigen::MatrixXd::Constant(1, 1, 2.0);
  options.limits = {Eigen::VectorXd::Constant(1, -1.5),
                    Eigen::VectorXd::Constant(1, 1.5)};
  options.before = 80.0;
  options.after = 120.0;
  options.quiet_stretch = 200.0;
  options.warm_up = 60.0;
  return options;
}

inline OperationOptions NoisyTank() {
  OperationOptions options = QuietTank();
  options.noise_variance = 1e-3;
  options.disturbance_deviation = Eigen::VectorXd::Constant(1, 0.05);
  options.disturbance_time = 300.0;
  return options;
}

inline LifeOptions TankLife(OperationOptions operation) {
  LifeOptions options;
  options.operation = std::move(operation);
  options.update.correct.estimation.change_test = ChangeTest::kChiSquare;
  options.update.response_samples = 44;
  options.test = {.hold = 50.0, .move = Eigen::VectorXd::Ones(1)};
  return options;
}

}  // namespace mle::lifecycle::testing

#endif  // TESTS_APPS_LIFECYCLE_SMALL_SCENARIO_H_
