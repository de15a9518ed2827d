#include <algorithm>
#include <atomic>
#include <cstdint>
#include <iterator>
#include <utility>

#include "absl/strings/str_cat.h"
#include "apps/common/progress.h"
#include "apps/experiment/experiment.h"
#include "apps/experiment/grid.h"
#include "apps/experiment/run_folder.h"
#include "apps/experiment/study.h"
#include "apps/reproduce/request.h"
#include "mle/base/option_error.h"
#include "mle/base/parallel.h"
#include "mle/base/status.h"

namespace mle::reproduce {
namespace {

using experiment::Campaign;
using experiment::Coordinates;
using experiment::Grid;
using experiment::Method;
using experiment::Outcome;

// The campaign's methods: the paper's, the other rule for λ if there is one,
// the estimators.
class Methods {
 public:
  Methods(const Reproduction& reproduction, Campaign& campaign)
      : reproduction_(reproduction) {
    Method method = experiment::PaperMethod();
    method.selection = method.solver = 0;
    campaign.methods = {method};
    const int outputs = campaign.models.front().model.num_outputs();
    if (campaign.windows.front().num_changes(outputs) > 1) {
      const bool paper = campaign.selections.front().name == "paper";
      const auto& rules = experiment::NamedSelections();
      campaign.selections = {campaign.selections.front(), rules[paper ? 0 : 1]};
      other_rule_ = campaign.selections.back().name;
      method.selection = 1;
      campaign.methods.push_back(method);
    }
    first_estimator_ = static_cast<int>(campaign.methods.size());
    for (Method one : reproduction.estimators) {
      if (one.UsesLambda()) one.selection = one.solver = 0;
      campaign.methods.push_back(one);
    }
  }

  const std::string& other_rule() const { return other_rule_; }
  // Null for the paper's method and the other rule.
  const Method* EstimatorOf(int method) const {
    return method < first_estimator_
               ? nullptr
               : &reproduction_.estimators[method - first_estimator_];
  }

  // Ablations are of the paper's method with some seeds; the other rule and
  // what takes long, with the first.
  bool Wants(const Coordinates& at) const {
    if (at.scenario.ablation > 0) {
      return at.method == 0 && at.seed < reproduction_.ablation_seeds;
    }
    const Method* const estimator = EstimatorOf(at.method);
    const bool once =
        estimator == nullptr ? at.method > 0 : estimator->solve_by_ceres;
    return at.seed == 0 || !once;
  }

 private:
  const Reproduction& reproduction_;
  std::string other_rule_;
  int first_estimator_ = 0;
};

CaseResult Describe(const Reproduction& reproduction, int number,
                    const experiment::ExperimentOptions& options) {
  const Campaign& campaign = reproduction.campaign;
  const ProcessModel& initial = campaign.models.front().model;
  CaseResult result;
  result.name = campaign.mismatches[number].name;
  result.from_paper = reproduction.from_paper;
  result.plant = *campaign.mismatches[number].plant;
  const int samples = options.response_samples();
  result.truth = result.plant.ComputeStepResponse(options.sample_time, samples);
  result.initial = initial.ComputeStepResponse(options.sample_time, samples);
  result.E_initial = SquaredDistance(result.truth, result.initial);
  result.runs.resize(campaign.seeds.size());
  const std::size_t seeds =
      std::min(static_cast<std::size_t>(reproduction.ablation_seeds),
               campaign.seeds.size());
  for (const experiment::Ablation* ablation : campaign.ablations) {
    if (ablation == nullptr) continue;
    result.ablations.push_back({ablation, std::vector<MethodRun>(seeds)});
  }
  return result;
}

MethodRun MakeMethodRun(std::string name, const Outcome& outcome) {
  MethodRun run;
  run.name = std::move(name);
  run.status = outcome.evaluation.status();
  if (!run.status.ok()) return run;
  const experiment::Evaluation& evaluation = *outcome.evaluation;
  run.E = evaluation.E();
  if (evaluation.lambda.size() > 0) run.lambda = evaluation.lambda(0);
  run.max_relative_gap = evaluation.max_relative_gap;
  run.change_proposed = evaluation.change_proposed;
  run.p_value = evaluation.p_value.value_or(1.0);
  run.seconds = evaluation.seconds;
  return run;
}

// Fills in everything but the other rule and the estimators from what ΔR, the
// paper's method, made of a run; `in_full` also what only the first seed has.
absl::Status FillRun(const experiment::Experiment& experiment,
                     const experiment::Evaluation& evaluation, bool in_full,
                     RunResult& run) {
  const Correction& correction = *evaluation.estimate->fit.arx;
  const experiment::Hindsight& hindsight = *evaluation.hindsight;
  const StepResponse& truth = experiment.truth();
  run.selection = correction.selection();
  run.lambda_star = evaluation.lambda(0);
  run.max_relative_gap = evaluation.max_relative_gap;
  run.lambda_oracle = hindsight.best_lambda;
  run.E_oracle = hindsight.best_E;
  run.judgement = evaluation.judgement;
  run.E_star = evaluation.E();
  const StepResponse unregularised =
      correction.Model(0.0).ComputeStepResponse(truth.samples());
  run.E_zero = experiment::DistanceOrInfinity(truth, unregularised);
  MLE_ASSIGN_OR_RETURN(
      run.closed_loop,
      CompareClosedLoops(experiment.initial(), correction.Model(),
                         experiment.plant(), experiment.seed(), in_full,
                         experiment.options()));
  if (!in_full) {
    // The curves of all seeds would fill the memory.
    run.selection.loss.resize(0);
    run.selection.penalised_loss.resize(0);
    return absl::OkStatus();
  }
  run.squared_distance =
      experiment::DistanceCurve(correction, correction.fits().front().lambdas,
                                truth)
          .Whole();
  run.corrected = evaluation.response;
  run.unregularised = unregularised;
  return absl::OkStatus();
}

// Puts an outcome where it belongs. The runs of a case and seed come one after
// the other, those of different ones from any thread.
void Keep(const Reproduction& reproduction, const Methods& methods,
          const Outcome& outcome, std::vector<CaseResult>& results) {
  const Coordinates& at = outcome.at;
  CaseResult& result = results[at.scenario.mismatch];
  if (at.scenario.ablation > 0) {
    AblationResult& ablation = result.ablations[at.scenario.ablation - 1];
    ablation.runs[at.seed] = MakeMethodRun(ablation.ablation->name, outcome);
    return;
  }
  RunResult& run = result.runs[at.seed];
  if (const Method* const one = methods.EstimatorOf(at.method)) {
    run.estimators.push_back(MakeMethodRun(one->name(), outcome));
    if (outcome.experiment != nullptr) {
      run.E_limit = outcome.experiment->Limit();
    }
    return;
  }
  if (at.method > 0) {
    run.other_rule = MakeMethodRun(methods.other_rule(), outcome);
    run.max_relative_gap =
        std::max(run.max_relative_gap, run.other_rule->max_relative_gap);
    return;
  }
  run.seed = reproduction.campaign.seeds[at.seed];
  run.status = outcome.evaluation.status();
  if (run.status.ok()) {
    run.status = FillRun(*outcome.experiment, *outcome.evaluation,
                         /*in_full=*/at.seed == 0, run);
  }
}

absl::Status FirstFailure(const std::vector<CaseResult>& results) {
  for (const CaseResult& result : results) {
    for (const RunResult& run : result.runs) {
      absl::Status status = run.status;
      if (run.other_rule.has_value()) status.Update(run.other_rule->status);
      if (status.ok()) continue;
      return WithPrefix(status, absl::StrCat("case ", result.name, ", seed ",
                                             run.seed, ": "));
    }
  }
  return absl::OkStatus();
}

// The runs wanted, unit by unit. With fewer seeds than threads every case has
// its own unit, and its own conversion.
std::vector<std::vector<std::int64_t>> UnitsOf(const Grid& grid,
                                               const Methods& methods) {
  std::vector<std::vector<std::int64_t>> units;
  for (std::int64_t unit = 0; unit < grid.num_units(); ++unit) {
    std::vector<std::int64_t> runs;
    for (const std::int64_t run : grid.RunsOf(unit)) {
      if (methods.Wants(grid.At(run))) runs.push_back(run);
    }
    if (!runs.empty()) units.push_back(std::move(runs));
  }
  return units;
}

}  // namespace

absl::StatusOr<experiment::ExperimentOptions> Reproduction::Options() const {
  const ProcessModel& initial = campaign.models.front().model;
  MLE_ASSIGN_OR_RETURN(
      experiment::ExperimentOptions options,
      OptionsOf(campaign, {}, initial.num_outputs(), initial.num_inputs()));
  options.correction.selection = campaign.selections.front().options;
  options.correction.solver = campaign.solvers.front().options;
  return options;
}

absl::StatusOr<std::vector<CaseResult>> RunReproduction(
    const Reproduction& reproduction) {
  MLE_ASSIGN_OR_RETURN(const experiment::ExperimentOptions options,
                       reproduction.Options());
  Campaign campaign = reproduction.campaign;
  const Methods methods(reproduction, campaign);
  const int threads = experiment::RunThreads(reproduction.threads);
  const bool many = static_cast<int>(campaign.seeds.size()) >= threads;
  const Grid grid(campaign, many ? Grid::kUnitScenarios : 1);
  std::vector<CaseResult> results;
  for (std::size_t c = 0; c < campaign.mismatches.size(); ++c) {
    results.push_back(Describe(reproduction, static_cast<int>(c), options));
  }
  const std::vector<std::vector<std::int64_t>> units = UnitsOf(grid, methods);
  std::int64_t runs = 0;
  for (const auto& unit : units) runs += std::ssize(unit);
  const ProgressFunction told = ShowProgress("runs");
  std::atomic<std::int64_t> done{0};
  told(0, runs);
  const std::atomic<bool> stop{false};
  ParallelFor(static_cast<int>(units.size()), threads, [&](int i) {
    RunUnit(campaign, grid, units[i], stop, [&](const Outcome& outcome) {
      Keep(reproduction, methods, outcome, results);
      told(++done, runs);
    });
  });
  MLE_RETURN_IF_ERROR(FirstFailure(results));
  for (CaseResult& result : results) {
    MLE_RETURN_IF_ERROR(SummariseCase(campaign.models.front().model, result));
  }
  return results;
}

}  // namespace mle::reproduce
