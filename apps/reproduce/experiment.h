// One run of the paper's experiment: everything from the initial model, the
// true plant and a seed to the corrected model and its judgement.
//
//   conversion   initial model, excited, → R                 (once for a seed)
//   records      closed loop on the plant, a run for each output → windows
//   correction   R and the windows → ΔR(λ) for all λ, λ*
//   judgement    step responses against the plant's
//
// Only the second and the last step see the plant.

#ifndef APPS_REPRODUCE_EXPERIMENT_H_
#define APPS_REPRODUCE_EXPERIMENT_H_

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "Eigen/Core"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "apps/reproduce/closed_loop_comparison.h"
#include "apps/reproduce/estimators.h"
#include "control/mpc.h"
#include "mle/correction/conversion.h"
#include "mle/correction/correction.h"
#include "mle/correction/judgement.h"
#include "mle/data/record.h"
#include "mle/model/process_model.h"
#include "mle/model/step_response.h"
#include "sim/plant_conditions.h"

namespace mle::reproduce {

// Times in the model's time unit. The defaults are the paper's.
struct ExperimentOptions {
  double sample_time = 0.2;  // Δt > 0

  // The loop.
  double control_period = 1.0;    // Δt_c, a whole multiple of Δt
  int prediction_horizon = 30;    // H_p ≥ H_c
  int control_horizon = 5;        // H_c ≥ 1
  Eigen::VectorXd output_weight;  // p, diagonal of Q_y, ≥ 0
  Eigen::VectorXd move_weight;    // m, diagonal of Q_u, ≥ 0
  // Of the disturbance observer: increment variance over noise variance, ≥ 0.
  double disturbance_variance_ratio = 0.1;
  double noise_variance = 0.001;  // σ² ≥ 0

  // The runs: set point e steps at step_time, those before it stand at
  // setpoint_step throughout.
  double duration = 1000.0;
  double step_time = 500.0;
  double setpoint_step = 1.0;  // not 0
  double window = 200.0;       // kept before and after the step
  // What else the plant has to bear: drift, faults of measurements, …
  sim::PlantConditions conditions;

  // The conversion.
  double conversion_duration = 10000.0;
  double conversion_noise_variance = 0.001;
  ConversionOptions conversion;

  CorrectionOptions correction;

  // To be compared, of EstimatorNames().
  std::vector<std::string> estimators;

  double response_horizon = 100.0;  // N Δt

  // What must hold before anything is run; the rest is checked on the way.
  absl::Status Validate(const ProcessModel& initial) const;

  int response_samples() const;  // N + 1
  int window_rows() const;       // samples of a window, less the order
};

control::MpcOptions MpcOptionsOf(const ExperimentOptions& options);

// R for one seed.
absl::StatusOr<ConversionSummary> ConvertInitialModel(
    const ProcessModel& initial, std::uint64_t seed,
    const ExperimentOptions& options);

// The records of the closed loop, a window for each output's set-point change.
absl::StatusOr<std::vector<Record>> SimulateWindows(
    const ProcessModel& initial, const ProcessModel& plant, std::uint64_t seed,
    const ExperimentOptions& options);

struct RunResult {
  std::uint64_t seed = 0;
  SelectionSummary selection;
  double lambda_star = 0.0;  // of the first output, all alike unless one each
  double E_star = 0.0;
  // The paper's rule for λ beside another one, and the default beside the
  // paper's. Where asked for, and there are two set-point changes or more.
  struct OtherRule {
    std::string name;  // as --selection has it
    double lambda = 0.0;
    double E = 0.0;
  };
  std::optional<OtherRule> other_rule;
  double E_zero = 0.0;         // infinite for a model that is very unstable
  double lambda_oracle = 0.0;  // best λ of the grid, in hindsight
  double E_oracle = 0.0;
  double max_relative_gap = 0.0;  // conversion and all fits, every λ
  Judgement judgement;            // at λ*
  ClosedLoopComparison closed_loop;
  EstimatorComparison estimators;
  // How to tune the controller for the corrected model, and why; where asked
  // for. A single line says why there is no advice.
  std::vector<std::string> retuning;

  // For figures: E at every λ of the grid (only where asked for), and step
  // responses.
  Eigen::VectorXd squared_distance;
  StepResponse corrected;      // at λ*
  StepResponse unregularised;  // at λ = 0
};

// `in_full` also computes E at every λ of the grid, and the other rule.
absl::StatusOr<RunResult> RunExperiment(const ProcessModel& initial,
                                        const ProcessModel& plant,
                                        const ConversionSummary& conversion,
                                        std::uint64_t seed, bool in_full,
                                        const ExperimentOptions& options);

}  // namespace mle::reproduce

#endif  // APPS_REPRODUCE_EXPERIMENT_H_
