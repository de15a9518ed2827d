#include "apps/experiment/experiment.h"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <string>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "apps/experiment/distance_curve.h"
#include "apps/experiment/outliers.h"
#include "apps/experiment/plants.h"
#include "apps/experiment/records.h"
#include "mle/base/status.h"
#include "mle/correction/combined.h"
#include "mle/correction/smoothed_correction.h"
#include "mle/nonlinear/output_reconstruction.h"

namespace mle::experiment {
double ThreadSeconds() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) +
         1e-9 * static_cast<double>(time.tv_nsec);
}

absl::StatusOr<const ConversionSummary*> SharedConversion::Get(
    const ExperimentOptions& options) {
  double seconds = 0.0;
  const auto conversion = conversion_.Get(
      [&] { return ConvertInitialModel(initial_, seed_, options); }, seconds);
  if (conversion.ok()) return *conversion;
  return absl::Status(
      conversion.status().code(),
      absl::StrCat("conversion: ", conversion.status().message()));
}

absl::StatusOr<std::unique_ptr<Experiment>> Experiment::Create(
    const Campaign& campaign, const Scenario& scenario, std::uint64_t seed,
    const ProcessModel& initial, SharedConversion& conversion) {
  std::unique_ptr<Experiment> made(
      new Experiment(campaign, scenario, seed, initial, conversion));
  MLE_ASSIGN_OR_RETURN(made->base_,
                       OptionsOf(campaign, scenario, initial.num_outputs(),
                                 initial.num_inputs()));
  made->options_ = made->base_;
  const Ablation* const ablation = campaign.ablations[scenario.ablation];
  if (ablation != nullptr) ablation->apply(made->options_);
  MLE_ASSIGN_OR_RETURN(
      made->plant_,
      AgeModel(initial, campaign.mismatches[scenario.mismatch], seed));
  const ExperimentOptions& options = made->options_;
  made->truth_ = made->plant_.ComputeStepResponse(options.sample_time,
                                                  options.response_samples());
  MLE_ASSIGN_OR_RETURN(made->truth_judged_, Judge(made->truth_, made->truth_));
  MLE_ASSIGN_OR_RETURN(made->windows_,
                       SimulateWindows(initial, made->plant_, seed, options));
  AddOutliers(options.windows, options.noise_variance, seed, made->windows_);
  if (options.windows.robust == OutlierTreatment::kModel) {
    MLE_RETURN_IF_ERROR(MarkOutliers(initial, {}, {}, made->windows_).status());
  }
  return made;
}

StepResponse Experiment::InitialResponse() const {
  return initial_.ComputeStepResponse(options_.sample_time, truth_.samples());
}

CorrectionOptions Experiment::CorrectionOf(const Method& method) const {
  ExperimentOptions options = base_;
  options.correction.solver = campaign_.solvers[method.solver].options;
  options.correction.selection = campaign_.selections[method.selection].options;
  const Ablation* const ablation = campaign_.ablations[scenario_.ablation];
  if (ablation != nullptr) ablation->apply(options);
  return options.correction;
}

absl::StatusOr<StructuredCorrection*> Experiment::StructuredFitOf(
    double& seconds) {
  return structured_.Get(
      [&] {
        return CorrectStructure(initial_, windows_,
                                StructuredOptionsFor(options_.windows.robust));
      },
      seconds);
}

// Without gaps where outliers were marked.
absl::StatusOr<std::vector<Record>> Experiment::WindowsOfArx() {
  if (options_.windows.robust != OutlierTreatment::kModel) return windows_;
  double seconds = 0.0;
  MLE_ASSIGN_OR_RETURN(const StructuredCorrection* const structured,
                       StructuredFitOf(seconds));
  return FillMarked(structured->full, windows_);
}

absl::StatusOr<Path> Experiment::SolvePath(const Method& method) {
  MLE_ASSIGN_OR_RETURN(const ConversionSummary* const conversion,
                       conversion_.Get(options_));
  const CorrectionOptions options = CorrectionOf(method);
  MLE_ASSIGN_OR_RETURN(const std::vector<Record> windows, WindowsOfArx());
  const double start = ThreadSeconds();
  Path path;
  MLE_ASSIGN_OR_RETURN(path.correction,
                       CorrectModel(conversion->model, windows, options));
  path.correction_seconds = ThreadSeconds() - start;
  path.conversion_gap = conversion->max_relative_gap;
  path.lambdas = options.lambdas;
  path.selections[method.selection] = path.correction.selection();
  DistanceCurve curve(path.correction, path.lambdas, truth_);
  const Eigen::Index best = curve.Best();
  path.best_lambda = path.lambdas(best);
  path.best_E = curve(best);
  path.zero_E = curve(0);
  return path;
}

// The path of the method's solver, with λ chosen by its rule.
absl::StatusOr<Path*> Experiment::PathOf(const Method& method) {
  double seconds = 0.0;
  MLE_ASSIGN_OR_RETURN(
      Path* const path,
      paths_[method.solver].Get([&] { return SolvePath(method); }, seconds));
  if (path->selections.count(method.selection) == 0) {
    MLE_ASSIGN_OR_RETURN(
        path->selections[method.selection],
        path->correction.Select(CorrectionOf(method).selection));
  }
  return path;
}

absl::Status Experiment::Guard(Estimate& estimate) {
  MLE_ASSIGN_OR_RETURN(const ModelAdequacy* const adequacy,
                       adequacy_.Get(
                           [&] {
                             return TestAdequacy(initial_, windows_, {},
                                                 AdequacyOptions());
                           },
                           estimate.seconds));
  estimate.change_proposed = !adequacy->adequate;
  estimate.p_value = adequacy->p_value;
  return absl::OkStatus();
}

absl::Status Experiment::Arx(const Method& method, Estimate& estimate) {
  MLE_ASSIGN_OR_RETURN(const Path* const path, PathOf(method));
  const SelectionSummary& selection = path->selections.at(method.selection);
  estimate.path = path;
  estimate.lambda = selection.lambda_star;
  estimate.seconds += path->correction_seconds;
  // Not of the rule that happened to be asked for first.
  double gap = std::max(path->conversion_gap, selection.max_relative_gap);
  for (const LassoSolution& fit : path->correction.fits()) {
    gap = std::max(gap, fit.MaxRelativeGap());
  }
  estimate.max_relative_gap = gap;
  estimate.response = path->correction.Model(selection.lambda_star)
                          .ComputeStepResponse(truth_.samples());
  return absl::OkStatus();
}

absl::Status Experiment::Ceres(const Method& method, Estimate& estimate) {
  MLE_ASSIGN_OR_RETURN(const Path* const path, PathOf(method));
  const double start = ThreadSeconds();
  estimate.path = path;
  estimate.lambda = path->selections.at(method.selection).lambda_star;
  MLE_ASSIGN_OR_RETURN(const SmoothedCorrection smoothed,
                       CorrectSmoothed(path->correction, estimate.lambda, {}));
  estimate.max_relative_gap = smoothed.MaxRelativeGap();
  estimate.response = smoothed.model.ComputeStepResponse(truth_.samples());
  estimate.seconds += ThreadSeconds() - start;
  return absl::OkStatus();
}

absl::Status Experiment::Structured(bool all_free, Estimate& estimate) {
  MLE_ASSIGN_OR_RETURN(estimate.structured, StructuredFitOf(estimate.seconds));
  const StructuredCorrection& structured = *estimate.structured;
  estimate.change_proposed = structured.change_proposed;
  estimate.p_value = structured.p_value;
  const StructuredFit& fit = all_free ? structured.full : structured.corrected;
  estimate.response =
      fit.model.ComputeStepResponse(options_.sample_time, truth_.samples());
  return absl::OkStatus();
}

absl::Status Experiment::Combined(const Method& method, Estimate& estimate) {
  MLE_RETURN_IF_ERROR(Structured(/*all_free=*/false, estimate));
  const double start = ThreadSeconds();
  CombinedOptions combined_options;
  combined_options.correction = CorrectionOf(method);
  MLE_ASSIGN_OR_RETURN(const CombinedCorrection combined,
                       CompleteStructured(
                           initial_, *estimate.structured, windows_,
                           [this](const ProcessModel& model) {
                             return ConvertInitialModel(model, seed_, options_);
                           },
                           combined_options));
  estimate.change_proposed = combined.change_proposed();
  if (combined.correction.has_value()) {
    estimate.lambda = combined.correction->selection().lambda_star;
    estimate.max_relative_gap = std::max(combined.conversion->max_relative_gap,
                                         combined.correction->MaxRelativeGap());
  }
  estimate.response =
      combined.ComputeStepResponse(options_.sample_time, truth_.samples());
  estimate.seconds += ThreadSeconds() - start;
  return absl::OkStatus();
}

absl::Status Experiment::Dispatch(const Method& method, Estimate& estimate) {
  switch (method.estimator) {
    case Estimator::kNone:
      estimate.response = InitialResponse();
      return absl::OkStatus();
    case Estimator::kArx:
      return Arx(method, estimate);
    case Estimator::kArxTested:
      MLE_RETURN_IF_ERROR(Guard(estimate));
      return Arx(method, estimate);
    case Estimator::kCeres:
      MLE_RETURN_IF_ERROR(Guard(estimate));
      return Ceres(method, estimate);
    case Estimator::kStructured:
      return Structured(/*all_free=*/false, estimate);
    case Estimator::kStructuredFree:
      return Structured(/*all_free=*/true, estimate);
    case Estimator::kCombined:
      return Combined(method, estimate);
  }
  return absl::InternalError("unknown estimator");
}

absl::StatusOr<Estimate> Experiment::Run(const Method& method) {
  Estimate estimate;
  MLE_RETURN_IF_ERROR(Dispatch(method, estimate));
  const bool guarded = method.estimator == Estimator::kArxTested ||
                       method.estimator == Estimator::kCeres;
  if (guarded && !estimate.change_proposed) {
    estimate.response = InitialResponse();
  }
  if (!std::isfinite(SquaredDistance(truth_, estimate.response))) {
    return absl::FailedPreconditionError(absl::StrFormat(
        "the model estimated is unstable: its step response leaves the range "
        "of numbers within %g",
        options_.response_horizon));
  }
  MLE_ASSIGN_OR_RETURN(estimate.judgement, Judge(truth_, estimate.response));
  return estimate;
}

double Experiment::ComputeLimit() const {
  const double variance = options_.noise_variance;
  if (!(variance > 0.0)) return 0.0;
  const Eigen::VectorXd& drift =
      options_.conditions.output_disturbance.drift_variance;
  std::vector<NoiseEstimate> noise(plant_.num_outputs());
  for (int i = 0; i < plant_.num_outputs(); ++i) {
    noise[i].variance = variance;
    noise[i].ratio = drift.size() > 0 ? drift(i) / variance : 0.0;
    noise[i].offset = noise[i].ratio > 0.0;
  }
  const auto limit =
      ComputeStructuredLimit(plant_, windows_, noise, StructuredOptions());
  if (!limit.ok()) return 0.0;
  const double E =
      limit->ExpectedSquaredDistance(options_.sample_time, truth_.samples());
  return std::isfinite(E) ? E : 0.0;
}

double Experiment::Limit() {
  if (!limit_.has_value()) limit_ = ComputeLimit();
  return *limit_;
}

}  // namespace mle::experiment
