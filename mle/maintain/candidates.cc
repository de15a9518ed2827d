#include "mle/maintain/candidates.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "mle/base/option_error.h"
#include "mle/base/status.h"
#include "mle/data/segments.h"
#include "mle/maintain/means.h"
#include "mle/maintain/outlier_search.h"
#include "mle/maintain/stage.h"
#include "mle/maintain/stamps.h"
#include "mle/maintain/steady_records.h"
#include "mle/maintain/unfitted.h"

namespace mle {
namespace {

constexpr double kFewestResponseSamples = 5.0;
constexpr double kMostResponseSamples = 1e6;
// By default, whatever the model's settling time, where records cannot be used
// or are shorter than half of it.
constexpr double kMostShownSamples = 1e4;
constexpr double kMostRecords = 2.0;

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

// The parts of steady operation, for the noise; the others are noted.
absl::StatusOr<std::vector<Record>> SteadyRecordsOf(const ProcessModel& model,
                                                    RecordData& data) {
  MLE_ASSIGN_OR_RETURN(SteadyRecords rest,
                       FindSteadyRecords(model, data.AtRest()));
  data.operated_as_usual = rest.left_out.empty();
  for (const auto& [from, to] : rest.left_out) {
    data.notes.push_back(
        {MessageCode::kUnmeasured,
         "",
         absl::StrCat("The plant was not operated as usual from ",
                      data.Times(model).Span(from, to),
                      ": what its outputs did there is not taken for noise."),
         {}});
  }
  return std::move(rest.usual);
}

// All that needs fits to the windows, whose outliers are marked first.
absl::Status FitWindows(Candidates& candidates) {
  for (const Message& obstacle : candidates.data.obstacles) {
    // The model is not of these channels, units or times.
    if (obstacle.code == MessageCode::kMistake) {
      return absl::FailedPreconditionError(obstacle.text);
    }
  }
  const ProcessModel& model = candidates.initial;
  CorrectOptions& options = candidates.options;
  EstimationOptions& estimation = options.estimation;
  MLE_RETURN_IF_ERROR(SearchOutliers(model, options.records,
                                     estimation.output_error, options.progress,
                                     candidates.data));
  candidates.windows = candidates.data.Records();
  MLE_ASSIGN_OR_RETURN(std::vector<Record> rest,
                       SteadyRecordsOf(model, candidates.data));
  estimation.output_error.at_rest =
      std::make_shared<const std::vector<Record>>(std::move(rest));
  MLE_ASSIGN_OR_RETURN(
      candidates.estimate,
      EstimateModel(model, candidates.windows, estimation, options.progress));
  if (!options.examine) return absl::OkStatus();
  MLE_ASSIGN_OR_RETURN(
      candidates.information,
      AssessInformation(model, JoinAdjoining(candidates.windows).records,
                        candidates.estimate.setting.noise,
                        {.output_error = estimation.output_error}));
  return absl::OkStatus();
}

absl::Status LeaveOutSmallChanges(Candidates& candidates) {
  const StepResponse& initial = candidates.initial_response;
  Estimate& estimate = candidates.estimate;
  MLE_ASSIGN_OR_RETURN(
      const CorrectedModel proposed,
      MakeCorrectedModel(estimate, true, candidates.sample_time(),
                         static_cast<int>(initial.values.rows()),
                         /*make_arx=*/false));
  for (int i = 0; i < initial.num_outputs; ++i) {
    double largest = 0.0;
    for (int j = 0; j < initial.num_inputs; ++j) {
      largest = std::max(largest, initial.element(i, j).norm());
    }
    bool any = false;
    for (int j = 0; j < initial.num_inputs; ++j) {
      const double norm = initial.element(i, j).norm();
      const double change =
          (proposed.response.element(i, j) - initial.element(i, j)).norm();
      const bool small = change <= LeastChange(candidates, i, j) *
                                       (norm > 0.0 ? norm : largest);
      any = any || !small;
      if (small && ProposesElement(estimate, i, j) &&
          !ProposesByArx(estimate, i)) {
        KeepInitialElement(i, j, estimate);
      }
    }
    if (!any) KeepInitialOutput(i, estimate);
  }
  return absl::OkStatus();
}

// Of data that may be other than the candidates' (means.h).
absl::StatusOr<std::optional<Competition>> Compete(const Candidates& candidates,
                                                   const RecordData& data) {
  const CorrectOptions& options = candidates.options;
  if (!options.examine || !data.obstacles.empty() ||
      options.estimation.estimator == Estimator::kArx) {
    return std::optional<Competition>();
  }
  const Stage stage(options.progress, "comparing explanations");
  MLE_RETURN_IF_ERROR(stage.status());
  // Whole records have more placebos than their windows; a shutdown between
  // these is nothing to be explained, nor is what a user leaves out.
  const bool whole = data.operated_as_usual && !data.records.empty() &&
                     options.records.leave_out.empty();
  ExplainOptions explain = options.explain;
  explain.threads = options.threads;
  explain.expected.resize(candidates.initial.num_outputs(),
                          candidates.initial.num_inputs());
  for (int i = 0; i < candidates.initial.num_outputs(); ++i) {
    for (int j = 0; j < candidates.initial.num_inputs(); ++j) {
      explain.expected(i, j) = ProposesElement(candidates.estimate, i, j);
    }
  }
  for (const Sampling& sampling : data.sampling) {
    explain.averages.push_back(sampling.average);
  }
  for (const NoiseEstimate& noise :
       candidates.estimate.fit.output_error.full.noise) {
    explain.stamp_errors.push_back(noise.stamp_deviation);
  }
  MLE_ASSIGN_OR_RETURN(
      Competition competition,
      Competition::Run(
          candidates.initial,
          whole ? data.records : JoinAdjoining(data.Records()).records,
          explain));
  return std::optional<Competition>(std::move(competition));
}

absl::StatusOr<Candidates> CandidatesOf(const ProcessModel& model,
                                        RecordData data,
                                        const CorrectOptions& options) {
  Candidates candidates;
  candidates.initial = model;
  candidates.options = options;
  candidates.options.estimation.output_error.threads = options.threads;
  candidates.given = data;
  candidates.data = std::move(data);
  MLE_ASSIGN_OR_RETURN(const int samples,
                       ResponseSamples(model, candidates.data, options));
  candidates.initial_response =
      model.ComputeStepResponse(candidates.sample_time(), samples);
  const absl::Status fitted = FitWindows(candidates);
  if (!fitted.ok()) {
    // Records that say nothing of the plant may defeat any fit.
    if (candidates.data.obstacles.empty() || absl::IsCancelled(fitted)) {
      return fitted;
    }
    candidates.windows = candidates.data.Records();
    candidates.estimate = UnfittedEstimate(model, candidates.windows,
                                           candidates.options.estimation);
    if (options.examine) candidates.information = NoInformation(model);
  }
  MLE_RETURN_IF_ERROR(LeaveOutSmallChanges(candidates));
  MLE_ASSIGN_OR_RETURN(candidates.competition,
                       Compete(candidates, candidates.data));
  return candidates;
}

// Whether there is anything to be explained.
bool IsExplained(const Competition& competition) {
  return std::any_of(competition.outputs().begin(), competition.outputs().end(),
                     [](const OutputExplanation& output) {
                       return !output.taken.empty() ||
                              output.left() > kMuchLeft;
                     });
}

// Whether all samples are means over Δt.
absl::StatusOr<bool> HasMeans(const Candidates& candidates) {
  if (candidates.options.in_use || !candidates.competition.has_value() ||
      !MayBeMeans(candidates.data) || !IsExplained(*candidates.competition)) {
    return false;
  }
  MLE_ASSIGN_OR_RETURN(const std::optional<Competition> as_means,
                       Compete(candidates, AsMeans(candidates.data)));
  return AreMeans(*candidates.competition, *as_means);
}

Message MeansWarning(const RecordData& data, const ProcessModel& model) {
  return {
      MessageCode::kSampling,
      "",
      absl::StrFormat(
          "All samples seem to be means over the %.6g %s from one to the "
          "next, and are used as such: what set points drive needs less to "
          "be explained. The sampling of the tags would settle it (average, "
          "stamp).",
          data.sample_time(), model.time_unit()),
      {}};
}

}  // namespace

absl::StatusOr<Candidates> FindCandidates(const ProcessModel& model,
                                          RecordData data,
                                          const CorrectOptions& options) {
  MLE_ASSIGN_OR_RETURN(Candidates candidates,
                       CandidatesOf(model, std::move(data), options));
  MLE_ASSIGN_OR_RETURN(const bool are_means, HasMeans(candidates));
  if (!are_means) return candidates;
  RecordData means = AsMeans(std::move(candidates.given));
  means.warnings.push_back(MeansWarning(candidates.data, model));
  return CandidatesOf(model, std::move(means), options);
}

double DetectableGain(const std::vector<OutputExplanation>& explanations,
                      const Estimate& estimate, int i, int j) {
  if (!explanations.empty() && explanations[i].judged()) {
    return explanations[i].detectable[j];
  }
  const ElementEstimate& element = estimate.fit.output_error.full.element(i, j);
  return element.detectable_gain / std::abs(element.gain.initial);
}

}  // namespace mle
