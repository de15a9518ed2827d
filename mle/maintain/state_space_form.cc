#include <algorithm>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/str_format.h"
#include "absl/strings/strip.h"
#include "mle/maintain/corrected_model.h"
#include "mle/model/balanced_reduction.h"
#include "mle/model/response_difference.h"

namespace mle {
namespace {

double LargestOf(const std::vector<double>& values) {
  return values.empty() ? 0.0 : *std::max_element(values.begin(), values.end());
}

// Differences from the ARX model's step responses; the values that these settle
// at are not compared.
Eigen::VectorXd DifferencesFrom(const StepResponse& response,
                                const DiscreteStateSpace& system) {
  const Eigen::MatrixXd gains = system.StaticGains();
  return RelativeDifferences(
      {system.ComputeStepResponse(response.samples()), gains},
      {response, gains});
}

}  // namespace

double StateSpaceForm::error_bound() const {
  return model.has_value() ? LargestOf(model->accuracy->error_bounds) : 0.0;
}

double StateSpaceForm::largest_difference() const {
  return model.has_value() ? LargestOf(model->accuracy->largest_differences)
                           : 0.0;
}

StateSpaceForm MakeStateSpaceForm(const ProcessModel& transfer_functions,
                                  const CorrectedModel& corrected,
                                  int threads) {
  StateSpaceForm form;
  const ReductionOptions options = {.threads = threads};
  absl::StatusOr<ReducedModel> reduced =
      ReduceModel(transfer_functions, corrected.response.sample_time, options);
  if (!reduced.ok()) {
    form.reason = std::string(
        absl::StripPrefix(reduced.status().message(), "state-space model: "));
    return form;
  }
  Eigen::VectorXd differences = reduced->largest_differences;
  if (!corrected.process.has_value()) {
    differences = DifferencesFrom(corrected.response, reduced->system);
  }
  if (!(differences.maxCoeff() <= options.tolerance)) {
    form.reason = absl::StrFormat(
        "the transfer functions of model.json differ from the ARX model by "
        "%.2g %% of a step response, more than %.2g %%; use arx.json",
        100.0 * differences.maxCoeff(), 100.0 * options.tolerance);
    return form;
  }
  NamedStateSpace named;
  named.SetChannels(transfer_functions);
  named.system = std::move(reduced->system);
  const Eigen::VectorXd& bounds = reduced->error_bounds;
  named.accuracy = StateSpaceAccuracy{{bounds.begin(), bounds.end()},
                                      {differences.begin(), differences.end()}};
  form.model = std::move(named);
  return form;
}

}  // namespace mle
