// Plants and loops that plans are made for in tests.

#ifndef TESTS_MLE_PLAN_PLAN_CASES_H_
#define TESTS_MLE_PLAN_PLAN_CASES_H_

#include "Eigen/Core"
#include "Eigen/LU"
#include "mle/model/process_simulator.h"
#include "mle/plan/plan.h"

namespace mle {

// A loop of a known answer: each output is asked to follow its set point behind
// a lag of its own (5, 8, … samples), and the inputs are those that hold the
// outputs of `model` there.
inline PlannedLoop FeedForward(const ProcessModel& model, double sample_time) {
  const Eigen::MatrixXd inverse = StaticGains(model).inverse();
  return [inverse, sample_time](
             const ProcessModel& plant,
             const Eigen::MatrixXd& set_points) -> absl::StatusOr<Record> {
    Record record;
    record.sample_time = sample_time;
    Eigen::MatrixXd asked = set_points;
    for (Eigen::Index i = 0; i < asked.rows(); ++i) {
      const double share = 1.0 / (5.0 + 3.0 * static_cast<double>(i));
      double state = 0.0;
      for (double& value : asked.row(i)) {
        state += share * (value - state);
        value = state;
      }
    }
    record.inputs = inverse * asked;
    // At rest before the first sample.
    Eigen::MatrixXd inputs(record.inputs.rows(), record.inputs.cols() + 1);
    inputs << Eigen::MatrixXd::Zero(record.inputs.rows(), 1), record.inputs;
    absl::StatusOr<Eigen::MatrixXd> outputs =
        SimulateResponse(plant, sample_time, inputs);
    if (!outputs.ok()) return outputs.status();
    record.outputs = outputs->rightCols(set_points.cols());
    record.set_points = set_points;
    return record;
  };
}

inline PlanProblem ProblemOf(const ProcessModel& plant) {
  const int p = plant.num_outputs();
  const int m = plant.num_inputs();
  PlanProblem problem;
  problem.plant = plant;
  problem.sample_time = 1.0;
  problem.noise.assign(p, {.variance = 1.0});
  problem.loop = FeedForward(plant, 1.0);
  problem.set_points = Eigen::VectorXd::Constant(p, 70.0);
  problem.inputs = Eigen::VectorXd::Constant(m, 30.0);
  problem.output_deviations = Eigen::VectorXd::Ones(p);
  problem.input_deviations = Eigen::VectorXd::Constant(m, 0.1);
  return problem;
}

// One element 2/(10 s + 1): its gain is asked for.
inline PlanProblem OneElement() {
  ProcessModel plant("one", "min", {{"valve", "%"}}, {{"level", "mm"}});
  plant.element(0, 0) = TransferFunction::FirstOrder(2.0, 10.0, 3.0);
  PlanProblem problem = ProblemOf(plant);
  problem.questions = {{.error = 0.05}};
  return problem;
}

// Two outputs, of which both inputs move each; the first gain is asked for.
inline PlanProblem TwoByTwo() {
  ProcessModel plant("two", "min", {{"reflux", ""}, {"steam", ""}},
                     {{"top", ""}, {"bottom", ""}});
  plant.element(0, 0) = TransferFunction::FirstOrder(4.0, 12.0, 2.0);
  plant.element(0, 1) = TransferFunction::FirstOrder(-2.0, 15.0, 4.0);
  plant.element(1, 0) = TransferFunction::FirstOrder(1.0, 9.0, 6.0);
  plant.element(1, 1) = TransferFunction::FirstOrder(-5.0, 8.0, 2.0);
  PlanProblem problem = ProblemOf(plant);
  problem.questions = {{.output = 0, .input = 1, .error = 0.05}};
  return problem;
}

inline PlanOptions Longest(double longest) {
  PlanOptions options;
  options.longest = longest;
  options.draws = 50;
  options.threads = 1;
  return options;
}

}  // namespace mle

#endif  // TESTS_MLE_PLAN_PLAN_CASES_H_
