#include "mle/maintain/correct.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "mle/base/status.h"
#include "mle/data/stretches.h"
#include "mle/exchange/model_file.h"
#include "mle/maintain/candidates.h"
#include "mle/maintain/certificates.h"
#include "mle/maintain/evidence.h"
#include "mle/maintain/explained.h"
#include "mle/maintain/usual_residuals.h"

namespace mle {
namespace {

// The smallest time constant of fopdt_model, in Δt: that of a jump.
constexpr double kTimeFloor = 1e-3;

absl::Status NotPositive(const char* field, double value) {
  return absl::InvalidArgumentError(absl::StrCat(
      field, " = ", value, ": it must be finite and greater than 0"));
}

// Changes in the first window, at different times: of set points or, in a whole
// record without any, of inputs.
int ChangesOf(const RecordData& data) {
  const SetPointWindow& window = data.windows.front();
  std::set<int> samples;
  for (const SetPointChange& change : window.changes) {
    samples.insert(change.sample);
  }
  if (!samples.empty()) return static_cast<int>(samples.size());
  const Eigen::MatrixXd& inputs = window.record.inputs;
  int moves = 0;
  for (Eigen::Index k = 1; k < inputs.cols(); ++k) {
    if ((inputs.col(k).array() != inputs.col(k - 1).array()).any()) ++moves;
  }
  return moves;
}

// The order of the ARX model, and of the lags of diagnostics.
int OrderOfModel(const Candidates& candidates) {
  return candidates.options.estimation.conversion.OrderFor(
      candidates.initial, candidates.sample_time());
}

absl::StatusOr<Validation> Judge(const Candidates& candidates) {
  const CorrectOptions& options = candidates.options;
  return ValidateByHoldOut(candidates.estimate, candidates.windows,
                           ChangesOf(candidates.data), OrderOfModel(candidates),
                           options.hold_out, options.in_use, options.threads,
                           options.progress);
}

// Of the proposal what is accepted; of one that is not accepted at all, the
// whole, to be shown.
absl::StatusOr<Estimate> TakeAccepted(const Candidates& candidates,
                                      const Verdict& verdict) {
  Estimate estimate = candidates.estimate;
  if (verdict.decision != Decision::kCorrected) return estimate;
  for (int i = 0; i < candidates.initial.num_outputs(); ++i) {
    if (verdict.outputs[i] == Acceptance::kExplained) {
      TakeExplained(candidates, i, estimate);
    } else if (verdict.outputs[i] == Acceptance::kNothing) {
      KeepInitialOutput(i, estimate);
    }
  }
  MLE_RETURN_IF_ERROR(MakePredictors(candidates.windows, estimate));
  return estimate;
}

absl::Status MakeModels(CorrectionResult& result) {
  const double sample_time = result.data.sample_time();
  const auto samples = static_cast<int>(result.initial_response.values.rows());
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

// The residuals of the model in the controller and of the corrected one.
absl::Status ExamineWindows(const std::vector<Record>& windows, int order,
                            CorrectionResult& result) {
  const CorrectOptions& options = result.options;
  if (!options.examine) return absl::OkStatus();
  const Stage stage(options.progress, "examining the residuals");
  MLE_RETURN_IF_ERROR(stage.status());
  result.max_lag = order;
  const EstimateFit& fit = result.estimate.fit;
  const std::vector<Record> stretches = JoinAdjoining(windows).records;
  result.initial_residuals =
      ExamineResiduals(options.in_use ? options.in_use : fit.initial, stretches,
                       order, options.threads);
  result.corrected_residuals =
      result.accepted()
          ? ExamineResiduals(fit.corrected, stretches, order, options.threads)
          : result.initial_residuals;
  return absl::OkStatus();
}

// What the model for use leaves of all usual operation, and its filters.
absl::Status EstimateFilters(CorrectionResult& result) {
  const CorrectOptions& options = result.options;
  const auto& rest = options.estimation.output_error.at_rest;
  if (!options.examine || !options.filter.estimate || rest == nullptr) {
    return absl::OkStatus();
  }
  const Stage stage(options.progress, "estimating the filter");
  MLE_RETURN_IF_ERROR(stage.status());
  MLE_ASSIGN_OR_RETURN(const std::vector<Eigen::MatrixXd> residuals,
                       UsualResiduals(result.model, result.data, *rest));
  result.filters = FindFilters(
      residuals, result.data.sample_time(), IntegratingOutputs(result.model),
      SettlingTime(result.model), options.filter, options.threads);
  DisturbanceForm form = CombineFilters(result.filters, /*samples=*/1);
  if (result.state_space.model.has_value() && form.A.size() > 0) {
    result.state_space.model->disturbance_model = std::move(form);
  }
  return absl::OkStatus();
}

// What a user has to know of the length of the step responses.
void NoteHorizon(CorrectionResult& result) {
  const ProcessModel& model = result.initial;
  const StepResponse& response = result.initial_response;
  const auto samples = static_cast<double>(response.values.rows());
  if (result.options.response_horizon != 0.0 ||
      SettlingTime(model) <= samples * response.sample_time) {
    return;
  }
  result.notes.push_back(
      {MessageCode::kSampling,
       "",
       absl::StrFormat("Step responses are computed for %.6g %s: the records "
                       "are too short to show the %.6g %s in which the "
                       "model settles.",
                       (samples - 1.0) * response.sample_time,
                       model.time_unit(), SettlingTime(model),
                       model.time_unit()),
       {"response_horizon"}});
}

// Scores are of the likelihood's proposal. They say nothing of an output of
// which the instruments' estimate is taken in its place, and one that keeps its
// model predicts as it did.
void KeepScoresOfAccepted(const Verdict& verdict, Validation& validation) {
  if (verdict.decision != Decision::kCorrected) return;
  const auto keep = [&](std::vector<OutputScores>& scores) {
    for (std::size_t i = 0; i < scores.size(); ++i) {
      if (verdict.outputs[i] == Acceptance::kProposal) continue;
      for (HorizonScore* const score :
           {&scores[i].one_step, &scores[i].several_steps,
            &scores[i].simulated}) {
        *score = {.initial = score->initial};
        if (verdict.outputs[i] == Acceptance::kNothing) {
          score->corrected = score->initial;
        }
      }
    }
  };
  keep(validation.outputs);
  for (std::vector<OutputScores>& window : validation.windows) keep(window);
}

absl::StatusOr<CorrectionResult> Build(Candidates candidates,
                                       Validation validation, Verdict verdict) {
  MLE_ASSIGN_OR_RETURN(Estimate estimate, TakeAccepted(candidates, verdict));
  const int order = OrderOfModel(candidates);
  KeepScoresOfAccepted(verdict, validation);
  CorrectionResult result;
  result.initial = std::move(candidates.initial);
  result.options = std::move(candidates.options);
  result.data = std::move(candidates.data);
  result.decision = verdict.decision;
  result.reasons = std::move(verdict.reasons);
  result.accepted_outputs = std::move(verdict.outputs);
  result.proposed = std::move(candidates.estimate.fit.output_error.corrected);
  result.estimate = std::move(estimate);
  if (candidates.competition.has_value()) {
    result.explanations = candidates.competition->outputs();
  }
  result.information = std::move(candidates.information);
  result.validation = std::move(validation);
  result.initial_response = std::move(candidates.initial_response);
  result.notes = result.data.notes;
  result.warnings = result.data.warnings;
  NoteHorizon(result);
  const Stage making(result.options.progress, "making the corrected model");
  MLE_RETURN_IF_ERROR(making.status());
  MLE_RETURN_IF_ERROR(MakeModels(result));
  CheckCertificates(result);
  MLE_RETURN_IF_ERROR(ExamineWindows(candidates.windows, order, result));
  MLE_RETURN_IF_ERROR(EstimateFilters(result));
  return result;
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
  MLE_RETURN_IF_ERROR(filter.Validate());
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
    double largest = 0.0;
    for (int j = 0; j < from.num_inputs; ++j) {
      largest = std::max(largest, from.element(i, j).norm());
    }
    for (int j = 0; j < from.num_inputs; ++j) {
      const double own = from.element(i, j).norm();
      const double norm = own > 0.0 ? own : largest;
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
  if (data.windows.empty()) {
    return absl::InvalidArgumentError("there are no windows");
  }
  MLE_ASSIGN_OR_RETURN(Candidates candidates,
                       FindCandidates(model, std::move(data), options));
  MLE_ASSIGN_OR_RETURN(Validation validation, Judge(candidates));
  Verdict verdict =
      Decide(GatherEvidence(candidates, validation), options.decision);
  return Build(std::move(candidates), std::move(validation),
               std::move(verdict));
}

double DetectableGain(const CorrectionResult& result, int i, int j) {
  return DetectableGain(result.explanations, result.estimate, i, j);
}

double PValue(const CorrectionResult& result) {
  double p_value = result.estimate.fit.test.p_value;
  if (result.estimate.fit.change_proposed) return p_value;
  const auto outputs = static_cast<double>(result.explanations.size());
  for (const OutputExplanation& output : result.explanations) {
    for (const TakenExplanation& one : output.taken) {
      p_value = std::min(p_value, outputs * std::exp(-one.evidence));
    }
  }
  return p_value;
}

bool HasOtherShape(const CorrectionResult& result, int i, int j) {
  if (!result.corrected.process.has_value()) return false;
  const TransferFunction& from = result.initial.element(i, j);
  const TransferFunction& to = result.corrected.process->element(i, j);
  return from.IsZero() != to.IsZero() ||
         from.numerator().size() != to.numerator().size() ||
         from.denominator().size() != to.denominator().size();
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
