#include <cmath>
#include <string>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "mle/model/element_response.h"
#include "mle/nonlinear/ar_component.h"
#include "mle/nonlinear/output_error_correction.h"

namespace mle {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

std::string TerminationName(FitTermination termination) {
  switch (termination) {
    case FitTermination::kNotRun:
      return "not run";
    case FitTermination::kConverged:
      return "converged";
    case FitTermination::kIterationLimit:
      return "stopped at the iteration limit";
    case FitTermination::kFailed:
      return "failed";
  }
  return "unknown";
}

std::string StateName(ElementState state, bool aged) {
  switch (state) {
    case ElementState::kAbsent:
      return "absent";
    case ElementState::kNotInformed:
      return "not informed: its input does not move";
    case ElementState::kHeld:
    case ElementState::kFitted:
      return aged ? "aged" : "unchanged";
  }
  return "unknown";
}

std::string Describe(const ParameterEstimate& estimate) {
  return absl::StrFormat("%.6g -> %.6g ± %.2g [%.6g, %.6g]", estimate.initial,
                         estimate.value, estimate.standard_error,
                         estimate.lower, estimate.upper);
}

void AppendAr(const NoiseEstimate& noise, std::string& report) {
  if (noise.ar_ratio > 0.0) {
    absl::StrAppendFormat(
        &report, "    coloured          variance %.4g, memory %.3g samples",
        noise.ar_variance(), noise.ar_memory());
    if (noise.ar_damping > 0.0) {
      absl::StrAppendFormat(&report, ", damping %.3g", noise.ar_damping);
    }
    report += "\n";
  }
  for (const PeriodicLine& line : noise.lines) {
    absl::StrAppendFormat(&report,
                          "    periodic          period %.4g, amplitude %.3g\n",
                          line.period, line.amplitude);
  }
  for (const LevelStep& step : noise.steps) {
    absl::StrAppendFormat(
        &report,
        "    step              record %d at %.6g, size %.3g, lag %.3g\n",
        step.record + 1, step.time, step.size, step.lag);
  }
}

// (N+1) × 3: a step response's derivatives by K, T and L.
MatrixXd StepDerivatives(const ElementResponse& element,
                         const ElementValues& values, double sample_time,
                         int samples) {
  MatrixXd columns(samples, 3);
  element.Simulate(values.time_scale, sample_time,
                   SampledDelayOf(values.delay, sample_time),
                   VectorXd::Ones(samples), 0.0, columns);
  columns.col(1) *= values.gain / values.time_scale;
  columns.col(2) *= values.gain;
  return columns;
}

}  // namespace

double NoiseEstimate::ar_variance() const {
  return ar_ratio * variance * ArComponent(ar_pole, ar_damping).Stationary().aa;
}

double NoiseEstimate::ar_memory() const {
  return ar_ratio > 0.0 ? -1.0 / std::log(ar_pole) : 0.0;
}

ElementValues ElementEstimate::values() const {
  return {.gain = gain.value,
          .time_scale = time_scale.value > 0.0 ? time_scale.value : 1.0,
          .delay = delay.value};
}

StepResponse OutputErrorFit::StepResponseErrors(double sample_time,
                                                int samples) const {
  const int m = model.num_inputs();
  StepResponse errors(sample_time, model.num_outputs(), m, samples);
  for (int i = 0; i < model.num_outputs(); ++i) {
    for (int j = 0; j < m; ++j) {
      const ElementEstimate& estimate = element(i, j);
      if (estimate.state != ElementState::kFitted) continue;
      const auto response = ElementResponse::Create(model.element(i, j));
      if (!response.ok()) continue;  // A gain of exactly 0 has no shape.
      const MatrixXd columns =
          StepDerivatives(*response, estimate.values(), sample_time, samples);
      const MatrixXd own = covariances[i].block(3 * j, 3 * j, 3, 3);
      errors.element(i, j) = (columns * own)
                                 .cwiseProduct(columns)
                                 .rowwise()
                                 .sum()
                                 .cwiseMax(0.0)
                                 .cwiseSqrt();
    }
  }
  return errors;
}

double OutputErrorFit::ExpectedSquaredDistance(double sample_time,
                                               int samples) const {
  return StepResponseErrors(sample_time, samples).values.squaredNorm();
}

std::string OutputErrorCorrection::FullReport() const {
  std::string report = absl::StrFormat(
      "Output-error correction\n"
      "  change              %s\n"
      "  against no change   %.6g, chi-square of %d: p = %.3g\n",
      change_proposed ? "proposed" : "none proposed", statistic,
      degrees_of_freedom, p_value);
  const int m = full.model.num_inputs();
  for (int i = 0; i < full.model.num_outputs(); ++i) {
    const FitCertificate& certificate = full.certificates[i];
    absl::StrAppendFormat(
        &report,
        "  output %s\n"
        "    noise variance    %.4g, increments %.4g (ratio %.3g)\n"
        "    fit               %s after %d iterations, %d searches, %s\n"
        "    certificate       gradient %.2g, rank %d of %d, condition %.3g%s\n"
        "    Ceres             %s\n",
        full.model.outputs()[i].name, full.noise[i].variance,
        full.noise[i].increment_variance(), full.noise[i].ratio,
        TerminationName(certificate.termination), certificate.iterations,
        certificate.grid_searches,
        certificate.search_confirmed ? "confirmed" : "not confirmed",
        certificate.gradient, certificate.rank, certificate.num_parameters,
        certificate.condition,
        certificate.at_bound ? ", a parameter at its bound" : "",
        certificate.message);
    AppendAr(full.noise[i], report);
    for (int j = 0; j < m; ++j) {
      const ElementEstimate& proposed = corrected.element(i, j);
      absl::StrAppendFormat(&report, "    input %s: %s (p = %.3g)\n",
                            full.model.inputs()[j].name,
                            StateName(full.element(i, j).state, aged(i, j)),
                            element_p_values(i, j));
      const ElementEstimate& shown = aged(i, j) ? proposed : full.element(i, j);
      if (shown.state != ElementState::kFitted) continue;
      absl::StrAppend(&report,  //
                      "      gain            ", Describe(shown.gain), "\n",
                      "      time scale      ", Describe(shown.time_scale),
                      "\n",  //
                      "      dead time       ", Describe(shown.delay), "\n");
    }
  }
  return report;
}

}  // namespace mle
