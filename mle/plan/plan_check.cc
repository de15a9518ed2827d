// What is checked of a problem and its options before a plan is sought.

#include <algorithm>
#include <cmath>
#include <string>

#include "mle/base/double_limits.h"
#include "mle/base/number_range.h"
#include "mle/base/status.h"
#include "mle/plan/plan.h"
#include "mle/plan/plan_problem.h"

namespace mle {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

absl::Status CheckSize(const char* name, Index size, Index count,
                       bool may_be_empty) {
  if (size == count || (may_be_empty && size == 0)) return absl::OkStatus();
  return InvalidArgument("plan: ", name, " has ", size,
                         " values; it must have ", count);
}

absl::Status CheckPrices(const char* name, const VectorXd& prices, Index p) {
  MLE_RETURN_IF_ERROR(CheckSize(name, prices.size(), p, true));
  for (const double price : prices) {
    if (!(price >= 0.0) || !std::isfinite(price)) {
      return InvalidArgument("plan: ", name, " is ", price,
                             "; it must be ≥ 0 and finite");
    }
  }
  return absl::OkStatus();
}

absl::Status CheckNumber(const char* name, double value, bool good,
                         const char* range) {
  if (good && std::isfinite(value)) return absl::OkStatus();
  return InvalidArgument("plan: ", name, " is ", value, "; it must be ", range);
}

// A limit that usual operation keeps, with `kept` deviations.
template <typename Channel>
absl::Status CheckLimits(const std::vector<Channel>& channels, const char* kind,
                         const VectorXd& min, const VectorXd& max,
                         const VectorXd& at, const VectorXd& deviations,
                         double kept) {
  for (std::size_t c = 0; c < channels.size(); ++c) {
    const auto i = static_cast<Index>(c);
    const double low = min.size() > 0 ? min(i) : -kInfinity;
    const double high = max.size() > 0 ? max(i) : kInfinity;
    const double margin = kept * deviations(i);
    if (at(i) + margin < high && at(i) - margin > low) continue;
    const bool upper = !(at(i) + margin < high);
    const double limit = upper ? high : low;
    return InvalidArgument(
        "plan: ", upper ? "max_" : "min_", kind, " of ", channels[c].name,
        " is ", limit, ", which usual operation does not keep: it is at ",
        at(i), " with a standard deviation of ", deviations(i),
        "; the limit must be ", upper ? "above " : "below ",
        upper ? at(i) + margin : at(i) - margin);
  }
  return absl::OkStatus();
}

absl::Status CheckQuestion(const PlanProblem& problem,
                           const PlanQuestion& question) {
  const ProcessModel& plant = problem.plant;
  if (question.output < 0 || question.output >= plant.num_outputs() ||
      question.input < 0 || question.input >= plant.num_inputs()) {
    return InvalidArgument("plan: a question is about output ", question.output,
                           " and input ", question.input, "; the model has ",
                           plant.num_outputs(), " and ", plant.num_inputs());
  }
  const std::string pair = PairName(plant, question.output, question.input);
  MLE_RETURN_IF_ERROR(CheckNumber("error", question.error,
                                  question.error > 0.0 && question.error <= 1.0,
                                  "in (0, 1]"));
  if (plant.element(question.output, question.input).IsZero()) {
    return InvalidArgument("plan: ", pair, " is zero in the model");
  }
  if (plant.inputs()[question.input].role != InputRole::kManipulated) {
    return InvalidArgument("plan: ", plant.inputs()[question.input].name,
                           " is a disturbance, which no set point moves");
  }
  const NoiseEstimate& noise =
      problem.noise[static_cast<std::size_t>(question.output)];
  if (!(noise.variance > 0.0) || !std::isfinite(noise.variance)) {
    return InvalidArgument("plan: ", plant.outputs()[question.output].name,
                           " is not measured: its noise is not known");
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status PlanOptions::Validate(const ProcessModel& plant) const {
  const int p = plant.num_outputs();
  const int m = plant.num_inputs();
  MLE_RETURN_IF_ERROR(CheckSize("min_output", min_output.size(), p, true));
  MLE_RETURN_IF_ERROR(CheckSize("max_output", max_output.size(), p, true));
  MLE_RETURN_IF_ERROR(CheckSize("min_input", min_input.size(), m, true));
  MLE_RETURN_IF_ERROR(CheckSize("max_input", max_input.size(), m, true));
  MLE_RETURN_IF_ERROR(CheckSize("movable", std::ssize(movable), p, true));
  if (!movable.empty() &&
      std::find(movable.begin(), movable.end(), true) == movable.end()) {
    return InvalidArgument("plan: no set point is movable; one must be");
  }
  MLE_RETURN_IF_ERROR(CheckPrices("squared_price", squared_price, p));
  MLE_RETURN_IF_ERROR(CheckPrices("absolute_price", absolute_price, p));
  MLE_RETURN_IF_ERROR(
      CheckNumber("longest", longest, longest > 0.0, "> 0 and finite"));
  MLE_RETURN_IF_ERROR(CheckNumber(
      "shortest_hold", shortest_hold,
      shortest_hold >= 0.0 && shortest_hold <= longest, "from 0 to longest"));
  MLE_RETURN_IF_ERROR(CheckNumber("grid", grid, grid >= 0.0, "≥ 0"));
  MLE_RETURN_IF_ERROR(CheckNumber("most_steps", most_steps,
                                  most_steps >= 1 && most_steps <= 12,
                                  "from 1 to 12"));
  MLE_RETURN_IF_ERROR(
      CheckNumber("ageing", ageing, ageing > 0.0, "> 0 and finite"));
  MLE_RETURN_IF_ERROR(CheckNumber("draws", draws, draws >= 10, "≥ 10"));
  return CheckNumber("deviations", deviations, deviations >= 0.0, "≥ 0");
}

absl::Status CheckProblem(const PlanProblem& problem,
                          const PlanOptions& options) {
  const ProcessModel& plant = problem.plant;
  MLE_RETURN_IF_ERROR(plant.Validate());
  MLE_RETURN_IF_ERROR(CheckNotIntegrating(
      plant, "a plan needs outputs that settle where they are held"));
  MLE_RETURN_IF_ERROR(options.Validate(plant));
  const int p = plant.num_outputs();
  const int m = plant.num_inputs();
  MLE_RETURN_IF_ERROR(ValidateSampleTime("sample_time", problem.sample_time));
  MLE_RETURN_IF_ERROR(
      CheckSize("set_points", problem.set_points.size(), p, false));
  MLE_RETURN_IF_ERROR(CheckSize("inputs", problem.inputs.size(), m, false));
  MLE_RETURN_IF_ERROR(CheckSize("output_deviations",
                                problem.output_deviations.size(), p, false));
  MLE_RETURN_IF_ERROR(
      CheckSize("input_deviations", problem.input_deviations.size(), m, false));
  MLE_RETURN_IF_ERROR(CheckSize("noise", std::ssize(problem.noise), p, false));
  for (const PlanQuestion& question : problem.questions) {
    MLE_RETURN_IF_ERROR(CheckQuestion(problem, question));
  }
  MLE_RETURN_IF_ERROR(CheckLimits(
      plant.outputs(), "output", options.min_output, options.max_output,
      problem.set_points, problem.output_deviations, options.deviations));
  return CheckLimits(plant.inputs(), "input", options.min_input,
                     options.max_input, problem.inputs,
                     problem.input_deviations, options.deviations);
}

}  // namespace mle
