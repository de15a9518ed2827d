#include "sim/plant_at_rest.h"

#include <utility>

#include "mle/base/status.h"
#include "sim/check_options.h"
#include "sim/fastest_time_constant.h"
#include "sim/steady_state.h"

namespace mle::sim {

using Eigen::VectorXd;

absl::Status CheckFactors(const std::vector<AgeingFactor>& factors) {
  for (const AgeingFactor& ageing : factors) {
    MLE_RETURN_IF_ERROR(CheckPositive(ageing.name, ageing.factor->Min()));
  }
  return absl::OkStatus();
}

absl::StatusOr<ContinuousSystem> MakePlantAtRest(
    PlantEquations equations, const std::vector<AgeingFactor>& factors,
    double start_time) {
  const SystemFunction at_start = [&equations, start_time](
                                      double, const VectorXd& x,
                                      const VectorXd& w, VectorXd& dx) {
    equations.derivative(start_time, x, w, dx);
  };
  ContinuousSystem system;
  MLE_ASSIGN_OR_RETURN(
      system.initial_state,
      SolveSteadyState(at_start, equations.inputs, std::move(equations.guess)));
  system.largest_step =
      0.02 * FastestTimeConstant(
                 Linearise(at_start, system.initial_state, equations.inputs).A);
  system.num_inputs = static_cast<int>(equations.inputs.size());
  system.num_outputs = static_cast<int>(equations.outputs.size());
  system.input_origin = std::move(equations.inputs);
  system.output_origin = system.initial_state(equations.outputs);
  for (int j = 0; j < static_cast<int>(equations.delays.size()); ++j) {
    system.paths.push_back(
        {.input = j,
         .delay = Schedule(equations.delays[static_cast<std::size_t>(j)])});
  }
  for (const AgeingFactor& ageing : factors) {
    for (const Schedule::Point& point : ageing.factor->points()) {
      system.breaks.push_back(point.time);
    }
  }
  system.output = [outputs = std::move(equations.outputs)](
                      double, const VectorXd& x, const VectorXd&, VectorXd& y) {
    y = x(outputs);
  };
  system.derivative = std::move(equations.derivative);
  return system;
}

}  // namespace mle::sim
