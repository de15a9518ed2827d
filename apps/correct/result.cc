#include "apps/correct/result.h"

#include <algorithm>
#include <cmath>
#include <iostream>
#include <limits>
#include <utility>

#include "absl/strings/str_cat.h"
#include "apps/correct/advice.h"
#include "apps/correct/verdict.h"
#include "apps/report/number.h"
#include "mle/base/status.h"
#include "mle/data/outliers.h"
#include "mle/model/process_model.h"

namespace mle::correct {
namespace {

using report::FormatScientific;

constexpr double kAcceptedGap = 1e-6;       // relative duality gap
constexpr double kAcceptedGradient = 1e-2;  // standard deviations
constexpr double kMaxResponseSamples = 1e6;

void Say(const std::string& what) { std::cerr << what << " …\n"; }

absl::StatusOr<int> ResponseSamples(const Request& request,
                                    double sample_time) {
  const double horizon = request.response_horizon > 0.0
                             ? request.response_horizon
                             : SettlingTime(request.model);
  const double samples = std::round(horizon / sample_time) + 1.0;
  if (!(samples >= 5.0) || !(samples <= kMaxResponseSamples)) {
    return absl::InvalidArgumentError(
        absl::StrCat("--response_horizon=", request.response_horizon, " gives ",
                     samples, " samples at a sample time of ", sample_time,
                     "; from 5 to 1,000,000 are possible"));
  }
  return static_cast<int>(samples);
}

Decision Decide(const Fit& fit, const Validation& validation) {
  if (!fit.change_proposed) return Decision::kNoChange;
  return validation.worsens() ? Decision::kRefused : Decision::kCorrected;
}

void CheckCertificates(Result& result) {
  const StructuredFit& fit = result.estimate.fit.structured.corrected;
  const ProcessModel& model = result.initial();
  for (int i = 0; i < model.num_outputs(); ++i) {
    const FitCertificate& certificate = fit.certificates[i];
    const std::string name =
        absl::StrCat("the fit of ", model.outputs()[i].name);
    const bool any_free = [&] {
      for (int j = 0; j < model.num_inputs(); ++j) {
        if (fit.element(i, j).state == ElementState::kFitted) return true;
      }
      return false;
    }();
    if (!any_free) continue;
    if (certificate.termination == FitTermination::kFailed) {
      result.failures.push_back(
          absl::StrCat(name, " failed: ", certificate.message));
    } else if (certificate.gradient > kAcceptedGradient) {
      result.warnings.push_back(absl::StrCat(
          "In ", name, " the optimum is reached only within ",
          FormatScientific(certificate.gradient, 1), " standard deviations."));
    }
    if (certificate.at_bound) {
      result.warnings.push_back(absl::StrCat(
          "In ", name,
          " a time constant or dead time lies at the bound of "
          "what is searched (--max_time_constant_factor, --max_delay): the "
          "optimum may lie beyond it."));
    }
    if (certificate.rank < certificate.num_parameters) {
      result.warnings.push_back(absl::StrCat(
          "In ", name, " the records determine only ", certificate.rank, " of ",
          certificate.num_parameters,
          " parameters: inputs that move together cannot be told apart."));
    }
  }
  if (!(result.corrected.max_relative_gap <= kAcceptedGap)) {
    result.failures.push_back(
        absl::StrCat("a lasso fit is not exact: its relative duality gap is ",
                     FormatScientific(result.corrected.max_relative_gap, 1)));
  }
}

void WarnOfValidation(Result& result) {
  const Validation& validation = result.validation;
  const auto warn = [&](const std::optional<HeldOut>& held_out) {
    if (held_out.has_value() && !held_out->available()) {
      result.warnings.push_back(absl::StrCat(
          "The correction could not be tried on what it had not seen: ",
          held_out->missing, "."));
    }
  };
  warn(validation.windows);
  warn(validation.blocks);
}

void CheckResponse(Result& result) {
  if (!result.corrected.response.values.allFinite() ||
      result.corrected.response.values.cwiseAbs().maxCoeff() > 1e50) {
    result.failures.push_back("the corrected model is unstable");
  }
}

void WarnOfShapes(Result& result) {
  const ProcessModel& model = result.initial();
  for (int i = 0; i < model.num_outputs(); ++i) {
    for (int j = 0; j < model.num_inputs(); ++j) {
      const FopdtElement& element = result.fopdt[i * model.num_inputs() + j];
      if (element.shape != FopdtShape::kPoorFit) continue;
      result.warnings.push_back(absl::StrCat(
          PairName(model, i, j),
          " is described badly by a gain, a time constant and a dead time: "
          "use its step response rather than fopdt.json."));
    }
  }
}

// Of the samples on each side, for bursts of up to ten.
constexpr int kWideHalfWidth = 12;

// Where neighbours find an outlier there may be more; and where a robust loss
// is asked for.
bool LooksForOutliers(const Request& request, const RecordData& data) {
  if (!request.records.mark.outliers) return false;
  if (request.estimation.structured.robust_loss != RobustLoss::kNone) {
    return true;
  }
  for (const ChannelHealth& channel : data.health.channels) {
    if (channel.is_output && !channel.outliers.empty()) return true;
  }
  for (const SetPointWindow& window : data.windows) {
    for (int i = 0; i < window.record.num_outputs(); ++i) {
      if (!FindOutliers(window.record.outputs.row(i),
                        {.half_width = kWideHalfWidth})
               .empty()) {
        return true;
      }
    }
  }
  return false;
}

absl::Status AddResponses(const Request& request, Result& result) {
  const double sample_time = result.data.sample_time();
  MLE_ASSIGN_OR_RETURN(const int samples,
                       ResponseSamples(request, sample_time));
  result.initial_response =
      request.model.ComputeStepResponse(sample_time, samples);
  Say("making the corrected model");
  MLE_ASSIGN_OR_RETURN(result.corrected,
                       MakeCorrectedModel(result.estimate, result.accepted(),
                                          sample_time, samples));
  CheckResponse(result);
  if (!result.failures.empty()) {
    return absl::FailedPreconditionError(result.failures.front());
  }
  result.change = Compare(result.initial_response, result.corrected.response);
  if (request.truth.has_value()) {
    result.true_response =
        request.truth->ComputeStepResponse(sample_time, samples);
    result.initial_to_truth =
        Compare(*result.true_response, result.initial_response);
    result.corrected_to_truth =
        Compare(*result.true_response, result.corrected.response);
  }
  MLE_ASSIGN_OR_RETURN(
      result.fopdt,
      DescribeAsFopdt(result.estimate, result.accepted(), result.corrected));
  return absl::OkStatus();
}

}  // namespace

std::string_view NameOf(Decision decision) {
  switch (decision) {
    case Decision::kNoChange:
      return "no_change";
    case Decision::kCorrected:
      return "corrected";
    case Decision::kRefused:
      return "refused";
  }
  return "";
}

Distance Compare(const StepResponse& from, const StepResponse& to) {
  Distance distance;
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

int Result::exit_code() const {
  return failures.empty() && decision != Decision::kRefused ? 0 : 1;
}

absl::StatusOr<Result> CorrectFromRecords(const Request& request,
                                          RecordData data) {
  Result result;
  result.request = request;
  result.data = std::move(data);
  if (LooksForOutliers(request, result.data)) {
    Say("looking for outliers");
    MLE_RETURN_IF_ERROR(MarkOutliersByModel(
        request.model, request.estimation.structured, result.data));
  }
  result.warnings = result.data.warnings;
  const std::vector<Record> windows = result.data.Records();
  const double sample_time = result.data.sample_time();
  MLE_RETURN_IF_ERROR(ResponseSamples(request, sample_time).status());
  Say(absl::StrCat("fitting ", windows.size(),
                   windows.size() == 1 ? " window" : " windows"));
  MLE_ASSIGN_OR_RETURN(result.estimate, EstimateModel(request.model, windows,
                                                      request.estimation));
  InformationOptions information;
  information.structured = request.estimation.structured;
  MLE_ASSIGN_OR_RETURN(
      result.information,
      AssessInformation(request.model, windows, result.estimate.setting.noise,
                        information));
  ValidationOptions options;
  options.max_folds = request.validation_folds;
  options.horizon = request.prediction_samples;
  options.order = request.estimation.conversion.order > 0
                      ? request.estimation.conversion.order
                      : ChooseOrder(request.model, sample_time);
  options.threads = request.threads;
  if (result.estimate.fit.change_proposed) Say("predicting what is held out");
  MLE_ASSIGN_OR_RETURN(result.validation,
                       Validate(result.estimate, windows, options));
  result.decision = Decide(result.estimate.fit, result.validation);
  MLE_RETURN_IF_ERROR(AddResponses(request, result));
  Say("examining what is left");
  const Fit& fit = result.estimate.fit;
  result.max_lag = options.order;
  result.initial_residuals =
      ExamineResiduals(fit.initial, windows, result.max_lag);
  result.corrected_residuals =
      result.accepted()
          ? ExamineResiduals(fit.corrected, windows, result.max_lag)
          : result.initial_residuals;
  CheckCertificates(result);
  WarnOfValidation(result);
  WarnOfShapes(result);
  result.verdict = Verdict(result);
  result.findings = Findings(result);
  result.advice = Advise(result);
  result.tuning = AdviseTuning(result);
  return result;
}

}  // namespace mle::correct
