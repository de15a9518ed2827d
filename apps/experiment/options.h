// The options of one run of the experiment: all but the models and the seed.
// The steps of a run:
//
//   conversion   initial model, excited, → R
//   records      closed loop on the plant around set-point changes → windows
//   estimate     the model from the windows, and R where ΔR is sought
//   judgement    its step responses against the plant's
//
// Only the second and the last step see the plant.

#ifndef APPS_EXPERIMENT_OPTIONS_H_
#define APPS_EXPERIMENT_OPTIONS_H_

#include <optional>
#include <string>

#include "absl/status/status.h"
#include "control/mpc_options.h"
#include "mle/correction/conversion.h"
#include "mle/correction/correction.h"
#include "mle/model/process_model.h"
#include "sim/effects_json.h"
#include "sim/plant_conditions.h"

namespace mle::experiment {

enum class OutlierTreatment {
  kNone,
  kModel,   // marked by a model; for ΔR replaced (output_reconstruction.h)
  kHuber,   // Huber's loss in the output-error correction
  kCauchy,  // Cauchy's
};

// The set-point changes and what is kept of them. With `changes` = 0 as in the
// paper: a run for each output e, whose set point steps at `step_time`, those
// before it standing at `setpoint_step` throughout. Else one run of so many
// changes, `spacing` apart, of one output after the other, each from 0 to
// `setpoint_step` and back in turn; then `duration` and `step_time` are not
// used: the first change comes after `window`.
struct WindowSpec {
  std::string name;
  double duration = 1000.0;
  double step_time = 500.0;
  double setpoint_step = 1.0;  // not 0
  double window = 200.0;       // kept before and after each change
  int changes = 0;
  double spacing = 400.0;  // ≥ 2 window

  // Outliers: share of the samples of every output, in [0, 0.5];
  // single ones, or in bursts of kShortestBurst to `longest_outlier` samples.
  static constexpr int kShortestBurst = 3;
  double outlier_share = 0.0;
  int longest_outlier = 1;
  OutlierTreatment robust = OutlierTreatment::kNone;

  double first_change() const { return changes > 0 ? window : step_time; }
  double run_duration() const {
    return changes > 0 ? 2.0 * window + (changes - 1) * spacing : duration;
  }
  int num_changes(int outputs) const { return changes > 0 ? changes : outputs; }
};

// Times in the model's time unit. The defaults are the paper's.
struct ExperimentOptions {
  double sample_time = 0.2;        // Δt > 0
  control::MpcOptions controller;  // weights diagonal, no limits
  double noise_variance = 0.001;   // σ² ≥ 0
  WindowSpec windows;
  // Further conditions of the plant: drift, faults of measurements, …
  sim::PlantConditions conditions;
  // Beside the conditions and what the windows say of set points.
  sim::Effects effects;

  double conversion_duration = 10000.0;
  // Noise variance of the excitation; none: the noise variance.
  std::optional<double> conversion_noise_variance;
  ConversionOptions conversion;
  CorrectionOptions correction;

  double response_horizon = 100.0;  // N Δt

  // Checks what must hold between values that are in their ranges (OptionsOf()
  // in campaign.h); the rest is checked on the way. Errors name the flags of
  // mle_reproduce; a campaign's keys are called the same.
  absl::Status Validate(const ProcessModel& initial) const;

  int response_samples() const;  // N + 1
  int window_rows() const;       // samples of a window, less the order
};

// That the controller acts at samples.
absl::Status CheckControlPeriod(double control_period, double sample_time);

}  // namespace mle::experiment

#endif  // APPS_EXPERIMENT_OPTIONS_H_
