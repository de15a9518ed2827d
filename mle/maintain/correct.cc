#include "mle/maintain/correct.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <set>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "mle/base/status.h"
#include "mle/data/stretches.h"
#include "mle/exchange/model_file.h"
#include "mle/maintain/certificates.h"
#include "mle/maintain/evidence.h"
#include "mle/maintain/explained.h"
#include "mle/maintain/outlier_search.h"
#include "mle/maintain/unfitted.h"
#include "mle/maintain/usual_rest.h"
#include "mle/maintain/withdrawal.h"

namespace mle {
namespace {

constexpr double kFewestResponseSamples = 5.0;
constexpr double kMostResponseSamples = 1e6;
// By default, whatever the model's settling time, where records cannot be used
// or are shorter than half of it.
constexpr double kMostShownSamples = 1e4;
constexpr double kMostRecords = 2.0;
// The smallest time constant of fopdt_model, in Δt: that of a jump.
constexpr double kTimeFloor = 1e-3;

absl::Status NotPositive(const char* field, double value) {
  return absl::InvalidArgumentError(absl::StrCat(
      field, " = ", value, ": it must be finite and greater than 0"));
}

absl::StatusOr<int> ResponseSamples(const ProcessModel& model,
                                    const RecordData& data,
                                    const CorrectOptions& options) {
  const double sample_time = data.sample_time();
  const double horizon = options.response_horizon > 0.0
                             ? options.response_horizon
                             : SettlingTime(model);
  double samples = std::round(horizon / sample_time) + 1.0;
  if (options.response_horizon == 0.0) {
    double longest = 0.0;
    for (const Record& record : data.records) {
      longest = std::max(longest, static_cast<double>(record.samples()));
    }
    // The model may be in another unit of time, which is then the answer.
    samples = std::min(samples,
                       data.obstacles.empty()
                           ? std::max(kMostRecords * longest, kMostShownSamples)
                           : kMostShownSamples);
    samples = std::clamp(samples, kFewestResponseSamples, kMostResponseSamples);
  }
  if (!(samples >= kFewestResponseSamples) ||
      !(samples <= kMostResponseSamples)) {
    return OptionError(
        "response_horizon",
        absl::StrCat("response_horizon = ", options.response_horizon, " gives ",
                     samples, " samples at a sample time of ", sample_time,
                     "; from 5 to 1,000,000 are possible"));
  }
  return static_cast<int>(samples);
}

// Changes in the first window, at different times.
int ChangesOf(const RecordData& data) {
  std::set<int> samples;
  for (const SetPointChange& change : data.windows.front().changes) {
    samples.insert(change.sample);
  }
  return static_cast<int>(samples.size());
}

// Compares explanations of the records. Nothing where the data forbid a
// correction, for the estimator arx, and without CorrectOptions::examine.
absl::StatusOr<std::optional<Competition>> Compete(
    const std::vector<Record>& stretches, CorrectionResult& result) {
  if (!result.options.examine || !result.data.obstacles.empty() ||
      result.options.estimation.estimator == Estimator::kArx) {
    return std::optional<Competition>();
  }
  const Stage stage(result.options.progress, "comparing explanations");
  MLE_RETURN_IF_ERROR(stage.status());
  ExplainOptions options = result.options.explain;
  options.threads = result.options.threads;
  for (const Sampling& sampling : result.data.sampling) {
    options.averages.push_back(sampling.average);
  }
  MLE_ASSIGN_OR_RETURN(Competition competition,
                       Competition::Run(result.initial, stretches, options));
  result.explanations = competition.outputs();
  return std::optional<Competition>(std::move(competition));
}

absl::Status DecideByEvidence(const std::vector<Record>& windows, int order,
                              const std::vector<bool>& unexplained,
                              const Competition* competition,
                              CorrectionResult& result) {
  const CorrectOptions& options = result.options;
  MLE_ASSIGN_OR_RETURN(
      result.validation,
      ValidateByHoldOut(result.estimate, windows, ChangesOf(result.data), order,
                        options.hold_out, options.in_use, options.threads,
                        options.progress));
  const Evidence evidence = GatherEvidence(result, unexplained, competition);
  Verdict verdict = Decide(evidence, options.decision);
  result.decision = verdict.decision;
  result.reasons = std::move(verdict.reasons);
  result.accepted_outputs = std::move(verdict.outputs);
  return absl::OkStatus();
}

// Leaves of the proposal what is accepted; of a proposal that is not accepted
// at all, the whole, to be shown.
absl::Status TakeAccepted(const std::vector<Record>& windows,
                          const Competition* competition,
                          CorrectionResult& result) {
  if (!result.accepted()) return absl::OkStatus();
  for (int i = 0; i < result.initial.num_outputs(); ++i) {
    if (result.accepted_outputs[i] == Acceptance::kExplained) {
      TakeExplained(*competition, i, result);
    } else if (result.accepted_outputs[i] == Acceptance::kNothing) {
      KeepInitialOutput(i, result.estimate);
    } else if (result.accepted_outputs[i] == Acceptance::kParametric) {
      KeepParametricOutput(i, result.estimate);
    }
  }
  return MakePredictors(windows, result.estimate);
}

absl::Status MakeModels(int samples, CorrectionResult& result) {
  const double sample_time = result.data.sample_time();
  MLE_ASSIGN_OR_RETURN(
      result.corrected,
      MakeCorrectedModel(result.estimate, result.accepted(), sample_time,
                         samples, result.options.make_arx));
  MLE_RETURN_IF_ERROR(CheckResponse(result.corrected.response));
  result.change =
      CompareResponses(result.initial_response, result.corrected.response);
  MLE_ASSIGN_OR_RETURN(
      result.fopdt,
      DescribeAsFopdt(result.estimate, result.accepted(), result.corrected));
  result.fopdt_model =
      FopdtModel(result.initial, result.fopdt, kTimeFloor * sample_time);
  MLE_ASSIGN_OR_RETURN(result.model,
                       TransferFunctionsOf(result.initial, result.corrected));
  if (result.options.make_arx) {
    result.state_space = MakeStateSpaceForm(result.model, result.corrected,
                                            result.options.threads);
  }
  return absl::OkStatus();
}

// Examines the residuals of the model in the controller, which the decision
// about shapes needs.
absl::Status ExamineInitial(const std::vector<Record>& windows, int order,
                            CorrectionResult& result) {
  bool needed = result.options.examine;
  for (int i = 0; i < result.initial.num_outputs(); ++i) {
    needed = needed || ProposesShape(result.estimate, i);
  }
  if (!needed) return absl::OkStatus();
  const Stage stage(result.options.progress, "examining the residuals");
  MLE_RETURN_IF_ERROR(stage.status());
  result.max_lag = order;
  result.initial_residuals = ExamineResiduals(
      result.options.in_use ? result.options.in_use
                            : result.estimate.fit.initial,
      JoinAdjoining(windows).records, order, result.options.threads);
  return absl::OkStatus();
}

absl::Status ExamineWindows(const std::vector<Record>& windows, int order,
                            CorrectionResult& result) {
  CheckCertificates(result);
  if (!result.options.examine) return absl::OkStatus();
  result.corrected_residuals =
      result.accepted() ? ExamineResiduals(result.estimate.fit.corrected,
                                           JoinAdjoining(windows).records,
                                           order, result.options.threads)
                        : result.initial_residuals;
  return absl::OkStatus();
}

// Estimates all that needs fits to the windows, whose outliers are marked
// first.
absl::Status EstimateFromWindows(CorrectionResult& result) {
  for (const Message& obstacle : result.data.obstacles) {
    // The model is not of these channels, units or times.
    if (obstacle.code == MessageCode::kMistake) {
      return absl::FailedPreconditionError(obstacle.text);
    }
  }
  const CorrectOptions& options = result.options;
  const EstimationOptions& estimation = options.estimation;
  MLE_RETURN_IF_ERROR(SearchOutliers(result.initial, options.records,
                                     estimation.output_error, options.progress,
                                     result.data));
  const std::vector<Record> windows = result.data.Records();
  MLE_ASSIGN_OR_RETURN(RestParts rest,
                       DivideRest(result.initial, result.data.AtRest()));
  result.data.operated_as_usual = rest.left_out.empty();
  for (const auto& [from, to] : rest.left_out) {
    result.data.notes.push_back(
        {MessageCode::kUnmeasured,
         "",
         absl::StrCat("The plant was not operated as usual from ",
                      result.data.Times(result.initial).Span(from, to),
                      ": what its outputs did there is not taken for noise."),
         {}});
  }
  result.options.estimation.output_error.at_rest =
      std::make_shared<const std::vector<Record>>(std::move(rest.usual));
  MLE_ASSIGN_OR_RETURN(
      result.estimate,
      EstimateModel(result.initial, windows, estimation, options.progress));
  if (options.examine) {
    MLE_ASSIGN_OR_RETURN(
        result.information,
        AssessInformation(result.initial, JoinAdjoining(windows).records,
                          result.estimate.setting.noise,
                          {.output_error = estimation.output_error}));
  }
  return absl::OkStatus();
}

RecordOptions RecordOptionsOf(const CorrectOptions& options) {
  RecordOptions records = options.records;
  records.examination.threads = options.threads;
  return records;
}

absl::Status CheckModel(const ProcessModel& model) {
  MLE_RETURN_IF_ERROR(model.Validate());
  if (SettlingTime(model) > 0.0 || IsIntegrating(model)) {
    return absl::OkStatus();
  }
  return absl::InvalidArgumentError(absl::StrCat(
      "the model '", model.name(),
      "' has no element with a time constant or a dead time: there is nothing "
      "to correct"));
}

}  // namespace

absl::Status CorrectOptions::Validate() const {
  MLE_RETURN_IF_ERROR(records.Validate());
  MLE_RETURN_IF_ERROR(estimation.Validate());
  MLE_RETURN_IF_ERROR(hold_out.Validate());
  MLE_RETURN_IF_ERROR(explain.Validate());
  MLE_RETURN_IF_ERROR(decision.Validate());
  if (!(response_horizon >= 0.0) || !std::isfinite(response_horizon)) {
    return OptionError(
        "response_horizon",
        absl::StrCat("response_horizon = ", response_horizon,
                     ": it must be a time > 0, or 0 for the default"));
  }
  if (!(accepted_gap > 0.0) || !std::isfinite(accepted_gap)) {
    return NotPositive("accepted_gap", accepted_gap);
  }
  if (!(accepted_gradient > 0.0) || !std::isfinite(accepted_gradient)) {
    return NotPositive("accepted_gradient", accepted_gradient);
  }
  if (threads < 0) {
    return absl::InvalidArgumentError(
        absl::StrCat("threads = ", threads, ": it must not be negative"));
  }
  return absl::OkStatus();
}

ResponseDistance CompareResponses(const StepResponse& from,
                                  const StepResponse& to) {
  ResponseDistance distance;
  distance.total = SquaredDistance(from, to);
  const double size = from.values.squaredNorm();
  distance.relative = size > 0.0 ? std::sqrt(distance.total / size) : 0.0;
  distance.elements = Eigen::MatrixXd::Zero(from.num_outputs, from.num_inputs);
  for (int i = 0; i < from.num_outputs; ++i) {
    for (int j = 0; j < from.num_inputs; ++j) {
      const double norm = from.element(i, j).norm();
      if (!(norm > 0.0)) continue;
      distance.elements(i, j) =
          (from.element(i, j) - to.element(i, j)).norm() / norm;
    }
  }
  return distance;
}

absl::StatusOr<CorrectionResult> CorrectFromData(
    const ProcessModel& model, RecordData data, const CorrectOptions& options) {
  MLE_RETURN_IF_ERROR(options.Validate());
  MLE_RETURN_IF_ERROR(CheckModel(model));
  CorrectionResult result;
  result.initial = model;
  result.options = options;
  result.options.estimation.output_error.threads = options.threads;
  result.data = std::move(data);
  if (result.data.windows.empty()) {
    return absl::InvalidArgumentError("there are no windows");
  }
  const EstimationOptions& estimation = result.options.estimation;
  const double sample_time = result.data.sample_time();
  const bool obstacles = !result.data.obstacles.empty();
  MLE_ASSIGN_OR_RETURN(const int samples,
                       ResponseSamples(model, result.data, options));
  result.initial_response = model.ComputeStepResponse(sample_time, samples);
  const absl::Status estimated = EstimateFromWindows(result);
  const std::vector<Record> windows = result.data.Records();
  if (!estimated.ok()) {
    // Records that say nothing of the plant may defeat any fit.
    if (!obstacles || absl::IsCancelled(estimated)) return estimated;
    result.estimate = UnfittedEstimate(model, windows, estimation);
    if (options.examine) result.information = NoInformation(model);
  }
  result.notes = result.data.notes;
  if (options.response_horizon == 0.0 &&
      SettlingTime(model) > samples * sample_time) {
    result.notes.push_back(
        {MessageCode::kSampling,
         "",
         absl::StrFormat("Step responses are computed for %.6g %s: the records "
                         "are too short to show the %.6g %s in which the "
                         "model settles.",
                         (samples - 1) * sample_time, model.time_unit(),
                         SettlingTime(model), model.time_unit()),
         {"response_horizon"}});
  }
  result.warnings = result.data.warnings;
  const std::vector<bool> unexplained = UnexplainedOutputs(result.estimate);
  MLE_RETURN_IF_ERROR(WithdrawProposals(samples, result));
  const int order = estimation.conversion.OrderFor(model, sample_time);
  MLE_RETURN_IF_ERROR(ExamineInitial(windows, order, result));
  // Whole records have more placebos than their windows; a shutdown between
  // these is nothing to be explained.
  const bool whole =
      result.data.operated_as_usual && !result.data.records.empty();
  const std::vector<Record> stretches =
      whole ? result.data.records : JoinAdjoining(windows).records;
  MLE_ASSIGN_OR_RETURN(const std::optional<Competition> competition,
                       Compete(stretches, result));
  const Competition* const judge =
      competition.has_value() ? &*competition : nullptr;
  MLE_RETURN_IF_ERROR(
      DecideByEvidence(windows, order, unexplained, judge, result));
  MLE_RETURN_IF_ERROR(TakeAccepted(windows, judge, result));
  const Stage making(options.progress, "making the corrected model");
  MLE_RETURN_IF_ERROR(making.status());
  MLE_RETURN_IF_ERROR(MakeModels(samples, result));
  MLE_RETURN_IF_ERROR(ExamineWindows(windows, order, result));
  return result;
}

double DetectableGain(const CorrectionResult& result, int i, int j) {
  if (!result.explanations.empty() && result.explanations[i].judged()) {
    return result.explanations[i].detectable[j];
  }
  const ElementEstimate& element =
      result.estimate.fit.output_error.full.element(i, j);
  return element.detectable_gain / std::abs(element.gain.initial);
}

absl::StatusOr<CorrectionResult> CorrectFromRecords(
    const ProcessModel& model, std::vector<Record> records,
    const CorrectOptions& options) {
  MLE_RETURN_IF_ERROR(options.Validate());
  MLE_RETURN_IF_ERROR(CheckModel(model));
  MLE_ASSIGN_OR_RETURN(
      RecordData data,
      PrepareRecords(std::move(records), model, RecordOptionsOf(options)));
  return CorrectFromData(model, std::move(data), options);
}

absl::StatusOr<CorrectionResult> CorrectFromRecords(
    const std::string& model_path, const std::vector<std::string>& record_paths,
    const HistorianOptions& import, const CorrectOptions& options) {
  MLE_RETURN_IF_ERROR(options.Validate());
  MLE_ASSIGN_OR_RETURN(const ModelFile file, ReadModelFile(model_path));
  const ProcessModel& model = file.process;
  MLE_RETURN_IF_ERROR(CheckModel(model));
  MLE_ASSIGN_OR_RETURN(RecordData data,
                       LoadRecords(record_paths, model, import,
                                   RecordOptionsOf(options), options.progress));
  return CorrectFromData(model, std::move(data), options);
}

}  // namespace mle
