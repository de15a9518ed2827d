#include "mle/maintain/built_result.h"

#include <algorithm>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_format.h"
#include "mle/base/status.h"
#include "mle/data/segments.h"
#include "mle/maintain/certificates.h"
#include "mle/maintain/explained.h"
#include "mle/maintain/stage.h"
#include "mle/maintain/usual_residuals.h"

namespace mle {
namespace {

// The smallest time constant of fopdt_model, in Δt: that of a jump.
constexpr double kTimeFloor = 1e-3;
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

// Errors of stamps that are smaller than a sample are nothing to be told of.
void NoteStampErrors(CorrectionResult& result) {
  const ProcessModel& model = result.initial;
  const std::vector<NoiseEstimate>& noise =
      result.estimate.fit.output_error.full.noise;
  for (std::size_t i = 0; i < noise.size(); ++i) {
    const double deviation = noise[i].stamp_deviation;
    if (deviation < result.data.sample_time()) continue;
    const std::string& name = model.outputs()[i].name;
    result.notes.push_back(
        {MessageCode::kSampling,
         name,
         absl::StrFormat(
             "%s: its time stamps are off at random, it seems, by some %.2g %s "
             "(standard deviation): intervals take that in. What all have in "
             "common is part of its dead times.",
             name, deviation, model.time_unit()),
         {}});
  }
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

}  // namespace

absl::StatusOr<CorrectionResult> BuildResult(Candidates candidates,
                                             Validation validation,
                                             Verdict verdict) {
  MLE_ASSIGN_OR_RETURN(Estimate estimate, TakeAccepted(candidates, verdict));
  const int order = candidates.order();
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
  NoteStampErrors(result);
  const Stage making(result.options.progress, "making the corrected model");
  MLE_RETURN_IF_ERROR(making.status());
  MLE_RETURN_IF_ERROR(MakeModels(result));
  CheckCertificates(result);
  MLE_RETURN_IF_ERROR(ExamineWindows(candidates.windows, order, result));
  MLE_RETURN_IF_ERROR(EstimateFilters(result));
  return result;
}

}  // namespace mle
