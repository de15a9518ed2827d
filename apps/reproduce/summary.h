// What the runs of a case say together.

#ifndef APPS_REPRODUCE_SUMMARY_H_
#define APPS_REPRODUCE_SUMMARY_H_

#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "apps/experiment/ablations.h"
#include "apps/experiment/distribution.h"
#include "apps/report/table.h"
#include "apps/reproduce/run.h"
#include "mle/model/process_model.h"

namespace mle::reproduce {

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

  // Of all runs.
  std::vector<const ClosedLoopComparison*> ClosedLoops() const;
};

absl::Status SummariseCase(const ProcessModel& initial_model,
                           CaseResult& result);

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
