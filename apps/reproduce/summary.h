// The summary of the runs of a case.

#ifndef APPS_REPRODUCE_SUMMARY_H_
#define APPS_REPRODUCE_SUMMARY_H_

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "Eigen/Core"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "apps/experiment/campaign.h"
#include "apps/experiment/distribution.h"
#include "apps/experiment/experiment.h"
#include "apps/experiment/options.h"
#include "apps/report/table.h"
#include "apps/report/text.h"
#include "mle/correction/judgement.h"
#include "mle/correction/selection.h"
#include "mle/data/record.h"
#include "mle/model/arx_model.h"
#include "mle/model/process_model.h"
#include "mle/model/step_response.h"
#include "nlohmann/json_fwd.hpp"

namespace mle::reproduce {

// The benefit of a correction in the closed loop: the aged plant under the
// controller with the model before correction, with the corrected one (the ARX
// model R̂ as it is), and with the plant's own. Horizons, weights and observer
// are the experiment's; each set-point change of the experiment is run with
// each model, without noise and with it, noise being the same for all three.

// How one set-point change went, from the change to the end of its window. All
// outputs count; times in the model's time unit.
struct LoopPerformance {
  // Σ (y − r)² Δt over samples and outputs. With measurement noise, σ² of every
  // sample is part of it.
  double integrated_squared_error = 0.0;
  double input_movement = 0.0;  // Σ |u_k − u_{k−1}| over samples and inputs
  // How far the stepped output goes beyond its set point, over the step; ≥ 0.
  double overshoot = 0.0;
  // From the change until every output stays within 5 % of the step from its
  // set point; infinite where that is not before the end of the window. Without
  // noise only, else 0.
  double settling_time = 0.0;
};

// The model in the controller, in the order of what follows.
inline constexpr std::array<const char*, 3> kLoopModelNames = {
    "initial", "corrected", "true"};

// With one model and one noise variance.
struct LoopRun {
  // Why there is none: a model that cannot predict, or a loop that runs away.
  absl::Status status;
  std::vector<LoopPerformance> changes;  // one for each output
  // The records about each change, for figures; where asked for.
  std::vector<Record> records;
};

struct ClosedLoopComparison {
  std::array<LoopRun, 3> noise_free;
  std::array<LoopRun, 3> noisy;
};

// Only what makes the comparison itself impossible is an error. `in_full` also
// keeps the records without noise.
absl::StatusOr<ClosedLoopComparison> CompareClosedLoops(
    const ProcessModel& initial, const ArxModel& corrected,
    const ProcessModel& plant, std::uint64_t seed, bool in_full,
    const experiment::ExperimentOptions& options);

// Means over the seeds, a row for each change and model.
report::Table ClosedLoopTable(
    const std::string& case_name, const ProcessModel& plant,
    const std::vector<const ClosedLoopComparison*>& comparisons);

// The value of "closed_loop" in results.json (docs/formats.md).
nlohmann::ordered_json ClosedLoopJson(
    const std::vector<const ClosedLoopComparison*>& comparisons);

// The results that mle_reproduce keeps of one run of the paper's method: one
// case, one seed.

// The result of another method on the records of the paper's, or of the paper's
// method on records that an ablation changed.
struct MethodRun {
  std::string name;     // as --estimators, --selection or --ablations has it
  absl::Status status;  // why there is no result
  double E = 0.0;
  double lambda = 0.0;            // of the first output, where there is ΔR
  double max_relative_gap = 0.0;  // of every lasso fit
  // Whether the records proved a change. If not, the model stays as it is, and
  // E is that of the initial model.
  bool change_proposed = false;
  double p_value = 1.0;  // of the initial model being right
  double seconds = 0.0;  // Evaluation::seconds
};

struct RunResult {
  std::uint64_t seed = 0;
  absl::Status status;  // why there is no result
  SelectionSummary selection;
  double lambda_star = 0.0;  // of the first output, all alike unless one each
  double E_star = 0.0;
  // The paper's rule for λ beside another one, and the default beside the
  // paper's. Of the first seed, where there are two set-point changes or more.
  std::optional<MethodRun> other_rule;
  double E_zero = 0.0;         // infinite for a model that is very unstable
  double lambda_oracle = 0.0;  // best λ of the grid, in hindsight
  double E_oracle = 0.0;
  double max_relative_gap = 0.0;  // conversion and all fits, every λ
  Judgement judgement;            // at λ*
  ClosedLoopComparison closed_loop;
  // Side by side on the same records, as asked for and in that order.
  std::vector<MethodRun> estimators;
  double E_limit = 0.0;  // Experiment::Limit(), where there are estimators
  // For figures: E at every λ of the grid, and step responses; of the first
  // seed.
  Eigen::VectorXd squared_distance;
  StepResponse corrected;      // at λ*
  StepResponse unregularised;  // at λ = 0
};

// Relative duality gaps up to this are as good as exact.
inline constexpr double kAcceptedGap = 1e-9;

// An ablation with the first of the seeds.
struct AblationResult {
  const experiment::Ablation* ablation = nullptr;
  std::vector<MethodRun> runs;  // seed by seed
};

// The corrected model's errors at one input–output pair, over all runs.
struct ElementErrors {
  double true_gain = 0.0;   // of the plant's element
  double true_delay = 0.0;  // its dead time, or that of the best FOPDT fit
  double initial_gain = 0.0;
  double initial_delay = 0.0;
  double static_gain_error_rms = 0.0;  // end of the step response
  double fopdt_gain_error_rms = 0.0;
  double delay_impulse_peak_mean = 0.0;
  double fopdt_delay_error_rms = 0.0;
};

// One case: a plant and its runs.
struct CaseResult {
  std::string name;
  bool from_paper = false;  // the paper's figures belong beside the results
  ProcessModel plant;
  StepResponse truth;
  StepResponse initial;
  double E_initial = 0.0;  // E(M, G₀)
  std::vector<RunResult> runs;
  // Each with the first of the runs' seeds.
  std::vector<AblationResult> ablations;
  // Filled in by SummariseCase.
  experiment::Distribution E_star;
  experiment::Distribution E_zero;
  experiment::Distribution E_oracle;
  experiment::Distribution lambda_star;
  std::vector<ElementErrors> elements;  // row by row (p·m)
  double max_relative_gap = 0.0;

  // Comparisons of all runs.
  std::vector<const ClosedLoopComparison*> ClosedLoops() const;
};

absl::Status SummariseCase(const ProcessModel& initial_model,
                           CaseResult& result);

// What the runs of a method that did not fail have in common.
struct MethodSummary {
  experiment::Distribution E;
  experiment::Distribution lambda;
  double max_relative_gap = 0.0;
  int proposed = 0;  // runs that proved a change
  double seconds = 0.0;
  std::string failure;  // why the last one failed
};

MethodSummary SummariseRuns(const std::vector<MethodRun>& runs);

// "5.8×10⁻⁵ … 9.4×10⁻⁵" from the smallest to the largest, or one number where
// these are alike.
std::string Extremes(
    const experiment::Distribution& values,
    std::string (*format)(double value, int digits) = report::FormatScientific);

// A number that the paper reports on one of its two cases, from one run each.
// Output and input count from 0.
struct PaperFigure {
  std::string_view case_name;
  int output;
  int input;
  // Magnitude of the error of the static gain, read from the step response.
  double gain_error;
  // Dead time read at the peak of the impulse response, in min; 0: not given.
  double delay;
};

// Null where the paper has none.
const PaperFigure* FindPaperFigure(const CaseResult& result, int output,
                                   int input);

// The paper's figures beside those of the runs, and why they differ; no rows
// without a case of the paper.
report::Table PaperTable(const std::vector<CaseResult>& cases);

// E and λ of a case; with one run its values, with several their statistics.
report::Table DistanceTable(const CaseResult& result);

// Gains, and dead times, of every pair, beside the paper's where it has any.
report::Table GainTable(const CaseResult& result);
report::Table DelayTable(const CaseResult& result);

// A row for each estimator over the runs, and one for the limit. With times
// only where the same input need not give the same bytes.
report::Table EstimatorTable(const CaseResult& result, bool with_times);

// A row for each ablation, beside the paper's method with the same seeds.
report::Table AblationTable(const CaseResult& result);

}  // namespace mle::reproduce

#endif  // APPS_REPRODUCE_SUMMARY_H_
