#include <algorithm>
#include <cmath>
#include <vector>

#include "absl/strings/str_cat.h"
#include "mle/base/status.h"
#include "mle/exchange/nearest_integrator.h"
#include "mle/maintain/corrected_model.h"

namespace mle {
namespace {

constexpr int kDescriptionSamples = 600;
constexpr double kNegligible = 1e-9;  // of the largest response
// The difference of a fit of second order must be at most this share of that of
// first order; else one more parameter says little.
constexpr double kWorthSecondOrder = 0.5;
constexpr int kFewestFitSamples = 10;  // of a fit of second order
// The dead time of second order is shorter than that of first order, whose lag
// begins at once; oscillations aside.
constexpr double kLongestDelays = 2.0;

FopdtElement FromFit(const FopdtFit& fit) {
  FopdtElement element;
  element.gain = fit.gain;
  element.time_constant = fit.time_constant;
  element.delay = fit.delay;
  element.gain_error = fit.gain_standard_error;
  element.time_constant_error = fit.time_constant_standard_error;
  element.delay_error = fit.delay_standard_error;
  element.shape = fit.shape;
  element.relative_rms = fit.relative_rms;
  element.largest_difference = fit.relative_max_residual;
  if (fit.shape == FopdtShape::kNoResponse) {
    element.gain_error = 0.0;
    element.time_constant_error = 0.0;
    element.delay_error = 0.0;
    element.relative_rms = 0.0;
    element.largest_difference = 0.0;
  }
  return element;
}

// The nearest element of first order, and where that is not near, of second.
absl::StatusOr<FopdtElement> Described(
    const Eigen::Ref<const Eigen::VectorXd>& response, double sample_time,
    const FopdtOptions& options) {
  MLE_ASSIGN_OR_RETURN(const FopdtFit fit,
                       FitFopdt(response, sample_time, options));
  FopdtElement element = FromFit(fit);
  if (fit.shape == FopdtShape::kNoResponse ||
      element.largest_difference <= kNearFopdt ||
      response.size() < kFewestFitSamples) {
    return element;
  }
  // Long responses are thinned out: the fit takes as long as they are.
  const Eigen::Index stride =
      std::max<Eigen::Index>(1, response.size() / kDescriptionSamples);
  const double step = sample_time * static_cast<double>(stride);
  const Eigen::VectorXd samples =
      response(Eigen::seq(0, response.size() - 1, stride));
  const double horizon = step * static_cast<double>(samples.size() - 1);
  MLE_ASSIGN_OR_RETURN(
      const SopdtFit second,
      FitSopdt(samples, step,
               std::min(kLongestDelays * (fit.delay + sample_time), horizon)));
  if (second.largest_difference <=
      kWorthSecondOrder * element.largest_difference) {
    element.second_order = second;
  }
  return element;
}

FopdtElement FromIntegrating(const TransferFunction& transfer) {
  const NearestIntegrator nearest = NearestIntegrator::Of(transfer);
  FopdtElement element;
  element.integrating = true;
  element.gain = nearest.gain;
  element.time_constant = nearest.time_constant;
  element.delay = nearest.delay;
  element.exact = transfer.IsIntegratorWithLag();
  element.relative_rms = nearest.relative_rms;
  element.largest_difference = nearest.largest_difference;
  return element;
}

absl::StatusOr<FopdtElement> FromTransfer(const TransferFunction& transfer) {
  if (transfer.IsIntegrating()) return FromIntegrating(transfer);
  FopdtElement element;
  if (transfer.IsZero()) {
    element.exact = true;
    element.shape = FopdtShape::kNoResponse;
    return element;
  }
  if (transfer.IsFirstOrder()) {
    element.exact = true;
    element.gain = transfer.StaticGain();
    element.time_constant = transfer.TimeConstant();
    element.delay = transfer.delay();
    return element;
  }
  // As long again at rest, for the gain to be that of the element.
  const double sample_time =
      transfer.TimeToSettle() / (kDescriptionSamples - 1);
  return Described(
      transfer.StepResponse(sample_time, 2 * kDescriptionSamples - 1),
      sample_time, {});
}

// The errors of (K, T, L) carried over to the fit.
void CarryErrors(const OutputErrorFit& fit, int i, int j,
                 FopdtElement& element) {
  const ElementEstimate& estimate = fit.element(i, j);
  element.gain_error = 0.0;
  element.time_constant_error = 0.0;
  element.delay_error = 0.0;
  if (estimate.state != ElementState::kFitted) return;
  // An integrator without lag has none.
  const double scale = estimate.time_scale.value;
  const bool has_scale = scale > 0.0;
  const double ratio = has_scale ? element.time_constant / scale : 0.0;
  const double shift =
      has_scale ? (element.delay - estimate.delay.value) / scale : 0.0;
  const double gain = estimate.gain.value;
  const double covariance = fit.covariances[i](3 * j + 1, 3 * j + 2);
  const double t = estimate.time_scale.standard_error;
  const double l = estimate.delay.standard_error;
  element.gain_error = estimate.gain.standard_error *
                       (gain != 0.0 ? std::abs(element.gain / gain) : 1.0);
  element.time_constant_error = ratio * t;
  element.delay_error = std::sqrt(
      std::max(l * l + shift * shift * t * t + 2.0 * shift * covariance, 0.0));
}

}  // namespace

absl::StatusOr<std::vector<FopdtElement>> DescribeAsFopdt(
    const Estimate& estimate, bool accepted, const CorrectedModel& corrected) {
  const int p = estimate.setting.initial.num_outputs();
  const int m = estimate.setting.initial.num_inputs();
  std::vector<FopdtElement> elements;
  for (int i = 0; i < p; ++i) {
    for (int j = 0; j < m; ++j) {
      if (!corrected.process.has_value()) {
        const StepResponse& response = corrected.response;
        FopdtOptions options;
        options.negligible_response =
            kNegligible * response.values.cwiseAbs().maxCoeff();
        MLE_ASSIGN_OR_RETURN(
            const FopdtElement element,
            Described(response.element(i, j), response.sample_time, options));
        elements.push_back(element);
        continue;
      }
      MLE_ASSIGN_OR_RETURN(FopdtElement element,
                           FromTransfer(corrected.process->element(i, j)));
      if (accepted) {
        CarryErrors(estimate.fit.output_error.corrected, i, j, element);
      } else {
        element.gain_error = 0.0;
        element.time_constant_error = 0.0;
        element.delay_error = 0.0;
      }
      elements.push_back(element);
    }
  }
  return elements;
}

ProcessModel FopdtModel(const ProcessModel& initial,
                        const std::vector<FopdtElement>& elements,
                        double time_floor) {
  ProcessModel model(initial.name(), initial.time_unit(), initial.inputs(),
                     initial.outputs());
  for (int i = 0; i < model.num_outputs(); ++i) {
    for (int j = 0; j < model.num_inputs(); ++j) {
      const FopdtElement& element = elements[i * model.num_inputs() + j];
      if (element.shape == FopdtShape::kNoResponse || element.gain == 0.0) {
        continue;
      }
      model.element(i, j) =
          element.integrating
              ? TransferFunction::Integrator(
                    element.gain, element.time_constant, element.delay)
              : TransferFunction::FirstOrder(
                    element.gain, std::max(element.time_constant, time_floor),
                    element.delay);
    }
  }
  return model;
}

}  // namespace mle
