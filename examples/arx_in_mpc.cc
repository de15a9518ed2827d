// A predictive controller of the ARX model that mle_correct writes, for five
// instants of a step of the first set point: arx_in_mpc ARX.json CONTROL_PERIOD

#include <cstdlib>
#include <iostream>

#include "control/mpc.h"
#include "mle/model/arx_model_json.h"

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  const auto named = mle::ReadArxModel(argv[1]);
  if (!named.ok()) return 2;
  const int p = named->model.num_outputs;
  const int m = named->model.num_inputs;
  mle::control::MpcOptions tuning;
  tuning.control_period = std::atof(argv[2]);
  tuning.output_weight = Eigen::MatrixXd::Identity(p, p);
  tuning.move_weight = 0.1 * Eigen::MatrixXd::Identity(m, m);
  tuning.limits.max_move = Eigen::VectorXd::Constant(m, 0.01);
  const auto model =
      mle::control::PredictFromArx(named->model, {}, tuning.control_period);
  if (!model.ok()) return 2;
  auto mpc = mle::control::Mpc::Create(*model, tuning);
  if (!mpc.ok()) return 2;
  Eigen::VectorXd inputs(m);
  for (int instant = 0; instant < 5; ++instant) {
    const Eigen::VectorXd outputs = mpc->PredictedOutputs();
    mpc->Step(outputs, Eigen::VectorXd::Unit(p, 0), inputs);
    const mle::control::PlanSummary& plan = mpc->last_plan();
    if (!plan.optimal) return 1;
    std::cout << named->inputs[0] << " " << inputs(0)
              << ", limits met: " << plan.active_limits << ", "
              << named->outputs[0] << " expected " << mpc->PredictedOutputs()(0)
              << "\n";
  }
  return 0;
}
