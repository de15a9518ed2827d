// What mle_reproduce keeps of one run of the paper's method: one case, one
// seed.

#ifndef APPS_REPRODUCE_RUN_H_
#define APPS_REPRODUCE_RUN_H_

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "Eigen/Core"
#include "absl/status/status.h"
#include "apps/experiment/experiment.h"
#include "apps/reproduce/closed_loop_comparison.h"
#include "mle/correction/judgement.h"
#include "mle/correction/selection.h"
#include "mle/model/step_response.h"

namespace mle::reproduce {

// What a method made of the same records as the paper's, or the paper's of
// records that an ablation changed.
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
  // How to tune the controller for the corrected model, and why; of the first
  // seed. A single line says why there is no advice.
  std::vector<std::string> retuning;

  // For figures: E at every λ of the grid, and step responses; of the first
  // seed.
  Eigen::VectorXd squared_distance;
  StepResponse corrected;      // at λ*
  StepResponse unregularised;  // at λ = 0
};

// Fills in everything but the other rule and the estimators from what ΔR, the
// paper's method, made of a run; `in_full` also what only the first seed has.
absl::Status FillRun(const experiment::Experiment& experiment,
                     const experiment::Evaluation& evaluation, bool in_full,
                     RunResult& run);

}  // namespace mle::reproduce

#endif  // APPS_REPRODUCE_RUN_H_
