#include <algorithm>
#include <cmath>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "apps/correct/report.h"
#include "apps/report/text.h"
#include "control/loop_analysis.h"
#include "control/prediction_model.h"
#include "control/retuning.h"
#include "mle/base/status.h"
#include "mle/model/process_model.h"

namespace mle::correct {
namespace {

using report::FormatSignificant;

// The corrected model's responses must have settled: they are followed for
// longer than they are compared.
constexpr double kAdviceSettlingTimes = 3.0;
constexpr double kMostAdvisedWindows = 1000.0;
// Significance level of the tests of residuals, over all pairs together.
constexpr double kResidualLevel = 0.01;
// With fewer of its samples than this share an output lacks those first.
constexpr double kFewSamples = 0.5;

control::RetuningOptions RetuningOptionsOf(const Result& result) {
  control::RetuningOptions options;
  options.threads = result.options.threads;
  options.time_unit = result.initial.time_unit();
  options.output_names = NamesOf(result.initial.outputs());
  options.input_names = NamesOf(result.initial.inputs());
  return options;
}

StepResponse SettledResponse(const Result& result) {
  const double sample_time = result.data.sample_time();
  const double settling =
      std::max(SettlingTime(result.corrected.process.has_value()
                                ? *result.corrected.process
                                : result.initial),
               SettlingTime(result.initial));
  const int samples = static_cast<int>(std::ceil(kAdviceSettlingTimes *
                                                 settling / sample_time)) +
                      1;
  return result.corrected.process.has_value()
             ? result.corrected.process->ComputeStepResponse(sample_time,
                                                             samples)
             : result.corrected.arx.ComputeStepResponse(samples);
}

absl::StatusOr<std::vector<std::string>> Retune(const Result& result) {
  const control::RetuningOptions options = RetuningOptionsOf(result);
  const control::MpcOptions& old_tuning = result.request.controller;
  const double settled =
      std::max(SettlingTime(result.initial), SettlingTime(result.model));
  if (!(settled <= control::kMostAnalysedPeriods * old_tuning.control_period)) {
    return absl::FailedPreconditionError(absl::StrCat(
        "responses settle only after ", FormatSignificant(settled, 3), " ",
        result.initial.time_unit(),
        ", too late for a loop to be analysed; a pair that hardly settles (a "
        "small damping, a time constant far beyond the others) makes them "
        "long"));
  }
  MLE_ASSIGN_OR_RETURN(
      const control::PredictionModel old_model,
      control::PredictFromProcess(result.initial, old_tuning.control_period));
  MLE_ASSIGN_OR_RETURN(
      const control::RetuningAdvice advice,
      control::AdviseRetuning(old_model, old_tuning, SettledResponse(result),
                              options));
  return advice.reasons;
}

// The names of the model's inputs with these numbers.
std::string InputNames(const ProcessModel& model,
                       const std::vector<int>& inputs) {
  std::vector<std::string> names;
  for (const int j : inputs) names.push_back(model.inputs()[j].name);
  return absl::StrJoin(names, ", ");
}

// The share of the samples in the windows that are there and good.
double KnownShare(const Result& result, int output) {
  double known = 0.0;
  double all = 0.0;
  for (const SetPointWindow& window : result.data.windows) {
    const auto samples = window.record.outputs.row(output);
    known += static_cast<double>(samples.array().isFinite().count());
    all += static_cast<double>(samples.size());
  }
  return all > 0.0 ? known / all : 0.0;
}

// Pairs that the records say little or nothing about.
void AddMissingInformation(const Result& result,
                           std::vector<std::string>& advice) {
  if (!result.data.obstacles.empty()) return;
  const ProcessModel& model = result.initial;
  std::vector<std::string> weak;
  std::vector<std::string> unknown;
  double worst = 0.0;
  for (int i = 0; i < model.num_outputs(); ++i) {
    const double known = KnownShare(result, i);
    bool lacks_samples = false;
    for (int j = 0; j < model.num_inputs(); ++j) {
      const PairErrors& pair = result.information.pair(i, j);
      if (pair.state == PairState::kNotInformed && known < kFewSamples) {
        lacks_samples = true;
      } else if (pair.state == PairState::kNotInformed) {
        unknown.push_back(PairName(model, i, j));
      } else if (pair.state == PairState::kWeak) {
        weak.push_back(PairName(model, i, j));
        worst = std::max(worst, pair.gain);
      }
    }
    if (lacks_samples) {
      advice.push_back(absl::StrCat(
          "Of ", model.outputs()[i].name, " only ",
          FormatSignificant(100.0 * known, 2),
          " % of the samples in the windows are there and good: its elements "
          "are kept, and its sensor or archive is to be mended first."));
    }
  }
  if (unknown.empty() && weak.empty()) return;
  if (!unknown.empty()) {
    advice.push_back(absl::StrCat(
        "The records do not determine the gain of ",
        absl::StrJoin(unknown, ", "),
        ": the input hardly moves, or only together with other inputs. The "
        "controller's model is kept there unless a change is significant."));
  }
  if (!weak.empty()) {
    const auto windows = static_cast<double>(result.data.windows.size());
    const double wanted = InformationOptions().informed;
    const double needed =
        std::ceil(windows * worst * worst / (wanted * wanted) - windows);
    advice.push_back(absl::StrCat(
        "The records show only large changes of the gain of ",
        absl::StrJoin(weak, ", "), ". For a standard error of ",
        FormatSignificant(100.0 * wanted, 2), " %, about ",
        static_cast<int>(std::clamp(needed, 1.0, kMostAdvisedWindows)),
        " more set-point changes like these are needed."));
  }
  advice.push_back(absl::StrCat(
      "A step test, or set-point changes that move these inputs independently, "
      "would be needed for: ",
      InputNames(model, result.information.inputs_to_test()), "."));
}

// Adds the doubt about each output.
void AddDoubts(const Result& result, std::vector<std::string>& advice) {
  for (const Message& reason : result.reasons) {
    if (!reason.place.empty() && reason.code != MessageCode::kPredictsBetter) {
      advice.push_back(reason.text);
    }
  }
}

void AddWhatTheModelLacks(const Result& result,
                          std::vector<std::string>& advice) {
  // Other channels, units or times explain all of them.
  if (!result.data.obstacles.empty()) return;
  std::vector<std::string> pairs;
  const ProcessModel& model = result.initial;
  for (int i = 0; i < model.num_outputs(); ++i) {
    const ResidualReport& report = result.corrected_residuals[i];
    for (int j = 0; j < model.num_inputs(); ++j) {
      const int tests = model.num_outputs() * model.num_inputs();
      if (report.inputs[j].p_value * tests < kResidualLevel)
        pairs.push_back(PairName(model, i, j));
    }
  }
  if (pairs.empty()) return;
  advice.push_back(absl::StrCat(
      "The residuals still depend on inputs (", absl::StrJoin(pairs, ", "),
      "): dynamics, a disturbance or a valve limit is missing in the model.",
      result.options.estimation.estimator == Estimator::kOutputError
          ? " --estimator=arx can fit any shape of response; compare the fits "
            "on held-out data."
          : ""));
}

// "model_corrected.csv has it in the form of the model given, ".
std::string ModelCorrectedText(const Result& result) {
  const std::string name = CorrectedName(result.request.model_file);
  if (name.empty()) return "";
  return absl::StrCat(name, " has it in the form of the model given, ");
}

}  // namespace

std::string_view NameOf(PairState state) {
  switch (state) {
    case PairState::kAbsent:
      return "absent";
    case PairState::kNotInformed:
      return "not_informed";
    case PairState::kWeak:
      return "weak";
    case PairState::kInformed:
      return "informed";
  }
  return "";
}

Tuning AdviseTuning(const Result& result) {
  Tuning tuning;
  if (!result.accepted() || !result.request.controller_known()) return tuning;
  const absl::StatusOr<std::vector<std::string>> reasons = Retune(result);
  if (!reasons.ok()) {
    tuning.heading = absl::StrCat("No advice on the controller's tuning: ",
                                  reasons.status().message(), ".");
    return tuning;
  }
  tuning.heading =
      "Controller tuning, from the tuning given by the flags to the tuning for "
      "the corrected model:";
  tuning.reasons = *reasons;
  return tuning;
}

std::vector<std::string> Advise(const Result& result) {
  std::vector<std::string> advice;
  switch (result.decision) {
    case Decision::kNoChange:
      advice.push_back("Keep the controller's model.");
      break;
    case Decision::kCannotTell:
      advice.push_back(
          "Keep the controller's model for now; the estimate is shown, but it "
          "is not validated.");
      AddDoubts(result, advice);
      break;
    case Decision::kCorrected:
      advice.push_back(absl::StrCat(
          "Use the corrected model in the controller: ",
          ModelCorrectedText(result),
          "model.json has its transfer functions, fopdt.json those of first "
          "order nearest to them, ",
          result.corrected.has_arx() ? "arx.json its ARX form for prediction, "
                                     : "",
          result.state_space.model.has_value()
              ? "state_space.json its discrete state-space form, "
              : "",
          "step_response.csv its step responses."));
      AddDoubts(result, advice);
      break;
  }
  AddMissingInformation(result, advice);
  AddWhatTheModelLacks(result, advice);
  if (std::string filter = FilterAdvice(result); !filter.empty()) {
    advice.push_back(std::move(filter));
  }
  return advice;
}

}  // namespace mle::correct
