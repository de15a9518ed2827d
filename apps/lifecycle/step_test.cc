#include "apps/lifecycle/step_test.h"

#include <algorithm>
#include <cmath>

namespace mle::lifecycle {

Eigen::VectorXd StepTestPlan::InputsAt(double time, int num_inputs) const {
  Eigen::VectorXd deviation = Eigen::VectorXd::Zero(num_inputs);
  // The millionth keeps times on the boundary on its later side.
  const auto part =
      static_cast<std::size_t>(std::max(0.0, std::floor(time / hold + 1e-6)));
  const std::size_t place = part / (2 * static_cast<std::size_t>(cycles));
  if (part % 2 == 0 && place < inputs.size()) {
    deviation[inputs[place]] = steps[static_cast<Eigen::Index>(place)];
  }
  return deviation;
}

StepTestPlan PlanStepTest(const ProcessModel& model,
                          const StepTestOptions& options) {
  StepTestPlan plan;
  plan.hold = options.hold;
  plan.cycles = options.cycles;
  std::vector<double> steps;
  for (int j = 0; j < model.num_inputs(); ++j) {
    if (model.inputs()[j].role != InputRole::kManipulated) continue;
    double relative = 0.0;  // the largest |K_ij| / move_i
    for (int i = 0; i < model.num_outputs(); ++i) {
      relative = std::max(relative, std::abs(model.element(i, j).StaticGain()) /
                                        options.move[i]);
    }
    if (!(relative > 0.0)) continue;
    plan.inputs.push_back(j);
    steps.push_back(1.0 / relative);
  }
  plan.steps = Eigen::Map<const Eigen::VectorXd>(
      steps.data(), static_cast<Eigen::Index>(steps.size()));
  return plan;
}

}  // namespace mle::lifecycle
