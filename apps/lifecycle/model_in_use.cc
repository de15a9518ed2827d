#include "apps/lifecycle/model_in_use.h"

#include <algorithm>
#include <cmath>

#include "mle/base/double_limits.h"
#include "mle/base/status.h"
#include "mle/nonlinear/fopdt_fit.h"

namespace mle::lifecycle {
namespace {

// The larger of both, NaN if either is.
double Larger(double a, double b) {
  return std::isnan(a) || std::isnan(b) ? kNaN : std::max(a, b);
}

absl::StatusOr<double> DelayOf(const StepResponse& response, int i, int j) {
  const Eigen::VectorXd values = response.element(i, j);
  MLE_ASSIGN_OR_RETURN(const FopdtFit fit,
                       FitFopdt(values, response.sample_time, {}));
  return fit.shape == FopdtShape::kFits ? fit.delay : kNaN;
}

}  // namespace

absl::StatusOr<ModelInUse> UseProcess(const ProcessModel& process,
                                      double control_period) {
  ModelInUse model;
  model.process = process;
  MLE_ASSIGN_OR_RETURN(model.prediction,
                       control::PredictFromProcess(process, control_period));
  return model;
}

absl::StatusOr<ModelError> CompareWithPlant(const ModelInUse& model,
                                            const ProcessModel& plant,
                                            double sample_time, int samples) {
  const StepResponse truth = plant.ComputeStepResponse(sample_time, samples);
  StepResponse response = model.response;
  if (model.own_response) {
    response.values = model.response.values.topRows(samples).eval();
  } else {
    response = model.process.ComputeStepResponse(sample_time, samples);
  }
  ModelError error;
  error.distance = SquaredDistance(truth, response);
  for (int i = 0; i < plant.num_outputs(); ++i) {
    for (int j = 0; j < plant.num_inputs(); ++j) {
      const TransferFunction& element = plant.element(i, j);
      if (element.IsZero()) continue;
      const double gain = model.own_response
                              ? response.element(i, j)(samples - 1)
                              : model.process.element(i, j).StaticGain();
      const double true_gain = model.own_response
                                   ? truth.element(i, j)(samples - 1)
                                   : element.StaticGain();
      error.gain = std::max(error.gain,
                            std::abs(gain - true_gain) / std::abs(true_gain));
      double delay = model.process.element(i, j).delay();
      if (model.own_response) {
        MLE_ASSIGN_OR_RETURN(delay, DelayOf(response, i, j));
      }
      error.delay = Larger(error.delay, std::abs(delay - element.delay()));
    }
  }
  return error;
}

}  // namespace mle::lifecycle
