#include "apps/study/unit.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "apps/reproduce/distance_curve.h"
#include "apps/reproduce/estimators.h"
#include "apps/reproduce/experiment.h"
#include "apps/study/plants.h"
#include "mle/base/status.h"
#include "mle/correction/combined.h"
#include "mle/correction/conversion.h"
#include "mle/correction/correction.h"
#include "mle/correction/judgement.h"
#include "mle/nonlinear/model_adequacy.h"
#include "mle/nonlinear/structured_correction.h"

namespace mle::study {
namespace {

using reproduce::DistanceOrInfinity;
using reproduce::ExperimentOptions;

absl::Status During(const char* what, const absl::Status& status) {
  return absl::Status(status.code(),
                      absl::StrCat(what, ": ", status.message()));
}

absl::StatusOr<ProcessModel> InitialModel(const Campaign& campaign, int model,
                                          std::uint64_t seed) {
  const ModelSpec& spec = campaign.models[model];
  if (!spec.random.has_value()) return spec.model;
  return DrawModel(*spec.random, seed, campaign.controllers);
}

// R of the initial model, for all scenarios of a unit: made when first asked
// for, since not every estimator needs it.
class SharedConversion {
 public:
  SharedConversion(const ProcessModel& initial, std::uint64_t seed)
      : initial_(initial), seed_(seed) {}

  absl::StatusOr<const ConversionSummary*> Get(
      const ExperimentOptions& options) {
    if (!conversion_.has_value()) {
      conversion_ = reproduce::ConvertInitialModel(initial_, seed_, options);
    }
    if (!conversion_->ok()) return During("conversion", conversion_->status());
    return &**conversion_;
  }

 private:
  const ProcessModel& initial_;
  const std::uint64_t seed_;
  std::optional<absl::StatusOr<ConversionSummary>> conversion_;
};

// One scenario with one seed, and what its methods share.
class ScenarioRuns {
 public:
  // What is given must outlive the object.
  static absl::StatusOr<std::unique_ptr<ScenarioRuns>> Create(
      const Campaign& campaign, const Scenario& scenario, std::uint64_t seed,
      const ProcessModel& initial, SharedConversion& conversion);

  absl::Status Run(const Method& method, Row& row);

 private:
  // A path with λ chosen by every rule asked for, and the best λ.
  struct Path {
    double conversion_gap = 0.0;
    Correction correction;
    std::map<int, SelectionSummary> selections;  // by rule
    double best_lambda = 0.0;
    double best_E = 0.0;
    double zero_E = 0.0;
  };

  ScenarioRuns(const Campaign& campaign, std::uint64_t seed,
               const ProcessModel& initial, SharedConversion& conversion)
      : campaign_(campaign),
        seed_(seed),
        initial_(initial),
        conversion_(conversion) {}

  absl::Status Arx(const Method& method, bool tested, Row& row);
  absl::Status Structured(Row& row);
  absl::Status Combined(const Method& method, Row& row);
  absl::StatusOr<const Path*> PathOf(const Method& method);
  absl::StatusOr<Path> SolvePath(const Method& method);
  absl::StatusOr<const ModelAdequacy*> Adequacy();
  absl::StatusOr<const StructuredCorrection*> StructuredResult();
  // E, gains and dead times of a model's responses.
  absl::Status JudgeModel(const StepResponse& response, Row& row) const;
  StepResponse InitialResponse() const;

  const Campaign& campaign_;
  const std::uint64_t seed_;
  const ProcessModel& initial_;
  SharedConversion& conversion_;
  ExperimentOptions options_;
  ProcessModel plant_;
  StepResponse truth_;
  Judgement truth_judged_;
  std::vector<Record> windows_;
  std::map<int, absl::StatusOr<Path>> paths_;  // by solver
  std::optional<absl::StatusOr<ModelAdequacy>> adequacy_;
  std::optional<absl::StatusOr<StructuredCorrection>> structured_;
};

absl::StatusOr<std::unique_ptr<ScenarioRuns>> ScenarioRuns::Create(
    const Campaign& campaign, const Scenario& scenario, std::uint64_t seed,
    const ProcessModel& initial, SharedConversion& conversion) {
  std::unique_ptr<ScenarioRuns> runs(
      new ScenarioRuns(campaign, seed, initial, conversion));
  MLE_ASSIGN_OR_RETURN(runs->options_,
                       OptionsOf(campaign, scenario, initial.num_outputs(),
                                 initial.num_inputs()));
  MLE_ASSIGN_OR_RETURN(
      runs->plant_,
      AgeModel(initial, campaign.mismatches[scenario.mismatch], seed));
  const ExperimentOptions& options = runs->options_;
  runs->truth_ = runs->plant_.ComputeStepResponse(options.sample_time,
                                                  options.response_samples());
  MLE_ASSIGN_OR_RETURN(runs->truth_judged_, Judge(runs->truth_, runs->truth_));
  absl::StatusOr<std::vector<Record>> windows = SimulateChanges(
      initial, runs->plant_, seed, campaign.windows[scenario.windows], options);
  if (!windows.ok()) return During("closed loop", windows.status());
  runs->windows_ = *std::move(windows);
  return runs;
}

StepResponse ScenarioRuns::InitialResponse() const {
  return initial_.ComputeStepResponse(options_.sample_time, truth_.samples());
}

absl::Status ScenarioRuns::JudgeModel(const StepResponse& response,
                                      Row& row) const {
  row[Metric::kE] = DistanceOrInfinity(truth_, response);
  if (!std::isfinite(row[Metric::kE])) {
    return absl::FailedPreconditionError(absl::StrFormat(
        "the model estimated is unstable: its step response leaves the range "
        "of numbers within %g",
        options_.response_horizon));
  }
  MLE_ASSIGN_OR_RETURN(const Judgement judged, Judge(truth_, response));
  double gain_squares = 0.0;
  double delay_squares = 0.0;
  double gain_max = 0.0;
  double delay_max = 0.0;
  int count = 0;
  for (int i = 0; i < plant_.num_outputs(); ++i) {
    for (int j = 0; j < plant_.num_inputs(); ++j) {
      if (plant_.element(i, j).IsZero()) continue;
      const int pair = i * plant_.num_inputs() + j;
      const FopdtFit& wanted = truth_judged_.fopdt[pair];
      const FopdtFit& found = judged.fopdt[pair];
      const double gain = (found.gain - wanted.gain) / wanted.gain;
      const double delay = found.delay - wanted.delay;
      if (!std::isfinite(gain) || !std::isfinite(delay)) continue;
      gain_squares += gain * gain;
      delay_squares += delay * delay;
      gain_max = std::max(gain_max, std::abs(gain));
      delay_max = std::max(delay_max, std::abs(delay));
      ++count;
    }
  }
  if (count == 0) return absl::OkStatus();
  row[Metric::kGainErrorRms] = std::sqrt(gain_squares / count);
  row[Metric::kDelayErrorRms] = std::sqrt(delay_squares / count);
  row[Metric::kGainErrorMax] = gain_max;
  row[Metric::kDelayErrorMax] = delay_max;
  return absl::OkStatus();
}

absl::StatusOr<ScenarioRuns::Path> ScenarioRuns::SolvePath(
    const Method& method) {
  MLE_ASSIGN_OR_RETURN(const ConversionSummary* const conversion,
                       conversion_.Get(options_));
  CorrectionOptions correction_options = options_.correction;
  correction_options.solver = campaign_.solvers[method.solver].options;
  correction_options.selection = campaign_.selections[method.selection].options;
  Path path;
  MLE_ASSIGN_OR_RETURN(
      path.correction,
      CorrectModel(conversion->model, windows_, correction_options));
  path.conversion_gap = conversion->max_relative_gap;
  path.selections[method.selection] = path.correction.selection();
  reproduce::DistanceCurve curve(path.correction, campaign_.lambdas, truth_);
  const Eigen::Index best = curve.Best();
  path.best_lambda = campaign_.lambdas(best);
  path.best_E = curve(best);
  path.zero_E = curve(0);
  return path;
}

// The path of the method's solver, with λ chosen by its rule.
absl::StatusOr<const ScenarioRuns::Path*> ScenarioRuns::PathOf(
    const Method& method) {
  auto known = paths_.find(method.solver);
  if (known == paths_.end()) {
    known = paths_.emplace(method.solver, SolvePath(method)).first;
  }
  if (!known->second.ok()) return known->second.status();
  Path& path = *known->second;
  if (path.selections.count(method.selection) == 0) {
    MLE_ASSIGN_OR_RETURN(
        path.selections[method.selection],
        path.correction.Select(campaign_.selections[method.selection].options));
  }
  return &path;
}

absl::StatusOr<const ModelAdequacy*> ScenarioRuns::Adequacy() {
  if (!adequacy_.has_value()) {
    adequacy_ = TestAdequacy(initial_, windows_, {}, AdequacyOptions());
  }
  if (!adequacy_->ok()) return adequacy_->status();
  return &**adequacy_;
}

absl::Status ScenarioRuns::Arx(const Method& method, bool tested, Row& row) {
  MLE_ASSIGN_OR_RETURN(const Path* const path, PathOf(method));
  const SelectionSummary& selection = path->selections.at(method.selection);
  row[Metric::kBestE] = path->best_E;
  row[Metric::kBestLambda] = path->best_lambda;
  row[Metric::kZeroE] = path->zero_E;
  row[Metric::kLambdaMin] = selection.lambda_star.minCoeff();
  row[Metric::kLambdaMax] = selection.lambda_star.maxCoeff();
  double gap = std::max(path->conversion_gap, selection.max_relative_gap);
  for (const LassoSolution& fit : path->correction.fits()) {
    gap = std::max(gap, fit.MaxRelativeGap());
  }
  row[Metric::kGap] = gap;
  bool change = true;
  if (tested) {
    MLE_ASSIGN_OR_RETURN(const ModelAdequacy* const adequacy, Adequacy());
    change = !adequacy->adequate;
    row[Metric::kProposed] = change ? 1.0 : 0.0;
    row[Metric::kPValue] = adequacy->p_value;
  }
  MLE_RETURN_IF_ERROR(
      JudgeModel(change ? path->correction.Model(selection.lambda_star)
                              .ComputeStepResponse(truth_.samples())
                        : InitialResponse(),
                 row));
  if (path->best_E > 0.0) {
    row[Metric::kRatio] = row[Metric::kE] / path->best_E;
  }
  return absl::OkStatus();
}

absl::StatusOr<const StructuredCorrection*> ScenarioRuns::StructuredResult() {
  if (!structured_.has_value()) {
    structured_ = CorrectStructure(initial_, windows_, StructuredOptions());
  }
  if (!structured_->ok()) return structured_->status();
  return &**structured_;
}

absl::Status ScenarioRuns::Structured(Row& row) {
  MLE_ASSIGN_OR_RETURN(const StructuredCorrection* const structured,
                       StructuredResult());
  row[Metric::kProposed] = structured->change_proposed ? 1.0 : 0.0;
  row[Metric::kPValue] = structured->p_value;
  return JudgeModel(structured->corrected.model.ComputeStepResponse(
                        options_.sample_time, truth_.samples()),
                    row);
}

absl::Status ScenarioRuns::Combined(const Method& method, Row& row) {
  MLE_ASSIGN_OR_RETURN(const StructuredCorrection* const structured,
                       StructuredResult());
  CombinedOptions combined_options;
  combined_options.correction = options_.correction;
  combined_options.correction.solver = campaign_.solvers[method.solver].options;
  combined_options.correction.selection =
      campaign_.selections[method.selection].options;
  MLE_ASSIGN_OR_RETURN(const CombinedCorrection combined,
                       CompleteStructured(
                           initial_, *structured, windows_,
                           [this](const ProcessModel& model) {
                             return reproduce::ConvertInitialModel(model, seed_,
                                                                   options_);
                           },
                           combined_options));
  row[Metric::kProposed] = combined.change_proposed() ? 1.0 : 0.0;
  row[Metric::kPValue] = structured->p_value;
  if (combined.correction.has_value()) {
    const Eigen::VectorXd& lambda =
        combined.correction->selection().lambda_star;
    row[Metric::kLambdaMin] = lambda.minCoeff();
    row[Metric::kLambdaMax] = lambda.maxCoeff();
    row[Metric::kGap] = std::max(combined.conversion->max_relative_gap,
                                 combined.correction->MaxRelativeGap());
  }
  return JudgeModel(
      combined.ComputeStepResponse(options_.sample_time, truth_.samples()),
      row);
}

absl::Status ScenarioRuns::Run(const Method& method, Row& row) {
  row[Metric::kInitialE] = DistanceOrInfinity(truth_, InitialResponse());
  switch (method.estimator) {
    case Estimator::kNone:
      return JudgeModel(InitialResponse(), row);
    case Estimator::kArx:
      return Arx(method, /*tested=*/false, row);
    case Estimator::kArxTested:
      return Arx(method, /*tested=*/true, row);
    case Estimator::kStructured:
      return Structured(row);
    case Estimator::kCombined:
      return Combined(method, row);
  }
  return absl::InternalError("unknown estimator");
}

bool SameScenario(const Scenario& a, const Scenario& b) {
  return a.model == b.model && a.noise == b.noise && a.drift == b.drift &&
         a.controller == b.controller && a.windows == b.windows &&
         a.mismatch == b.mismatch;
}

}  // namespace

void RunUnit(const Campaign& campaign, const Grid& grid,
             const std::vector<std::int64_t>& runs,
             const std::atomic<bool>& stop,
             const std::function<void(const Row&)>& emit) {
  if (runs.empty()) return;
  double start = reproduce::ThreadSeconds();
  const Coordinates first = grid.At(runs.front());
  const std::uint64_t seed = campaign.seeds[first.seed];
  const absl::StatusOr<ProcessModel> initial =
      InitialModel(campaign, first.scenario.model, seed);
  std::optional<SharedConversion> conversion;
  if (initial.ok()) conversion.emplace(*initial, seed);

  std::optional<Scenario> current;
  absl::StatusOr<std::unique_ptr<ScenarioRuns>> scenario =
      absl::InternalError("not run");
  for (const std::int64_t run : runs) {
    if (stop.load(std::memory_order_relaxed)) return;
    const Coordinates at = grid.At(run);
    Row row;
    row.run = run;
    absl::Status status;
    if (!initial.ok()) {
      status = During("model", initial.status());
    } else {
      if (!current.has_value() || !SameScenario(*current, at.scenario)) {
        current = at.scenario;
        scenario = ScenarioRuns::Create(campaign, at.scenario, seed, *initial,
                                        *conversion);
      }
      status = scenario.ok()
                   ? (*scenario)->Run(campaign.methods[at.method], row)
                   : scenario.status();
    }
    if (!status.ok()) {
      row.status = absl::StrCat("failed: ", status.message());
    }
    const double now = reproduce::ThreadSeconds();
    row.seconds = now - start;
    start = now;
    emit(row);
  }
}

}  // namespace mle::study
