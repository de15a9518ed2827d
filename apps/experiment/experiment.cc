#include "apps/experiment/experiment.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "absl/strings/str_format.h"
#include "apps/experiment/campaign.h"
#include "mle/base/option_error.h"
#include "mle/base/random.h"
#include "mle/base/status.h"
#include "mle/correction/excitation.h"
#include "mle/maintain/corrected_model.h"
#include "mle/nonlinear/output_error_correction.h"
#include "mle/nonlinear/output_reconstruction.h"
#include "sim/closed_loop.h"

namespace mle::experiment {
namespace {

// Sizes of outliers, in standard deviations of the noise.
constexpr double kSmallestOutlier = 10.0;
constexpr double kLargestOutlier = 50.0;

// Adds outliers to a share of the samples of every output, singly or in bursts
// to the same side. In the records alone: the loop and its noise are those of
// the run without outliers.
void AddOutliers(const WindowSpec& spec, double noise_variance,
                 std::uint64_t seed, std::vector<Record>& windows) {
  if (!(spec.outlier_share > 0.0)) return;
  const double deviation = std::sqrt(noise_variance);
  const int longest = spec.longest_outlier;
  std::mt19937_64 engine(seed);
  std::uniform_real_distribution<double> size(kSmallestOutlier,
                                              kLargestOutlier);
  for (Record& window : windows) {
    const int samples = window.samples();
    for (int i = 0; i < window.num_outputs(); ++i) {
      for (int changed = 0; changed < spec.outlier_share * samples;) {
        const int length =
            longest == 1 ? 1
                         : std::uniform_int_distribution<int>(
                               WindowSpec::kShortestBurst, longest)(engine);
        const int first =
            std::uniform_int_distribution<int>(0, samples - length)(engine);
        const double side = engine() % 2 == 0 ? 1.0 : -1.0;
        for (int k = first; k < first + length; ++k) {
          window.outputs(i, k) += side * size(engine) * deviation;
        }
        changed += length;
      }
    }
  }
}

// The loss of the output-error correction.
OutputErrorOptions OutputErrorOptionsFor(OutlierTreatment treatment) {
  OutputErrorOptions options;
  if (treatment == OutlierTreatment::kHuber) {
    options.robust_loss = RobustLoss::kHuber;
  } else if (treatment == OutlierTreatment::kCauchy) {
    options.robust_loss = RobustLoss::kCauchy;
  }
  return options;
}

// R for one seed.
absl::StatusOr<ConversionSummary> ConvertInitialModel(
    const ProcessModel& initial, std::uint64_t seed,
    const ExperimentOptions& options) {
  ExcitationOptions excitation;
  excitation.sample_time = options.sample_time;
  excitation.duration = options.conversion_duration;
  excitation.noise_variance =
      options.conversion_noise_variance.value_or(options.noise_variance);
  excitation.seed = seed;
  excitation.stream = kConversionStream;
  MLE_ASSIGN_OR_RETURN(const Record record,
                       SimulateExcitation(initial, excitation));
  return ConvertToArx(record, options.conversion);
}

// A run of the closed loop, and the times of the changes that are kept of it.
struct LoopPlan {
  sim::SetPointProfile set_points;
  std::vector<double> changes;
  std::uint64_t stream = kRunStream;
};

// A run for each output, or one of many changes.
std::vector<LoopPlan> PlanLoops(const WindowSpec& spec, int outputs) {
  std::vector<LoopPlan> plans;
  if (spec.changes == 0) {
    for (int e = 0; e < outputs; ++e) {
      plans.push_back(
          {StepOf(e, spec), {spec.step_time}, static_cast<std::uint64_t>(e)});
    }
    return plans;
  }
  LoopPlan& plan = plans.emplace_back();
  for (int change = 0; change < spec.changes; ++change) {
    const double time = spec.window + change * spec.spacing;
    const bool up = (change / outputs) % 2 == 0;
    plan.set_points.steps.push_back(
        {change % outputs, time, up ? spec.setpoint_step : 0.0});
    plan.changes.push_back(time);
  }
  return plans;
}

// The records of the closed loop, a window for each set-point change.
absl::StatusOr<std::vector<Record>> SimulateWindows(
    const ProcessModel& initial, const ProcessModel& plant, std::uint64_t seed,
    const ExperimentOptions& options) {
  MLE_ASSIGN_OR_RETURN(const control::Mpc mpc,
                       control::Mpc::Create(initial, options.controller));
  const WindowSpec& spec = options.windows;
  std::vector<Record> windows;
  for (const LoopPlan& plan : PlanLoops(spec, plant.num_outputs())) {
    MLE_ASSIGN_OR_RETURN(
        const Record record,
        SimulateLoop(mpc, plant, plan.set_points, options.noise_variance, seed,
                     plan.stream, options.conditions, options));
    for (const double time : plan.changes) {
      const auto change =
          static_cast<int>(std::lround(time / options.sample_time));
      MLE_ASSIGN_OR_RETURN(windows.emplace_back(),
                           CutWindow(record, change, spec.window, spec.window));
    }
  }
  return windows;
}

}  // namespace

sim::SetPointProfile StepOf(int output, const WindowSpec& windows) {
  sim::SetPointProfile set_points;
  for (int before = 0; before < output; ++before) {
    set_points.steps.push_back({before, 0.0, windows.setpoint_step});
  }
  set_points.steps.push_back(
      {output, windows.step_time, windows.setpoint_step});
  return set_points;
}

absl::StatusOr<Record> SimulateLoop(control::Mpc mpc, const ProcessModel& plant,
                                    const sim::SetPointProfile& set_points,
                                    double noise_variance, std::uint64_t seed,
                                    std::uint64_t stream,
                                    const sim::PlantConditions& conditions,
                                    const ExperimentOptions& options) {
  sim::ClosedLoopOptions loop;
  loop.sample_time = options.sample_time;
  loop.control_period = options.controller.control_period;
  loop.duration = options.windows.run_duration();
  loop.noise_variance = noise_variance;
  loop.seed = seed;
  loop.stream = stream;
  sim::PlantConditions all = conditions;
  options.effects.AddTo(all);
  sim::SetPointProfile moved = set_points;
  MLE_RETURN_IF_ERROR(
      options.effects.AddTo(moved, loop.duration, seed, stream));
  return sim::SimulateClosedLoop(
      plant,
      [&mpc](const auto& measured, const auto& wanted, auto next) {
        mpc.Step(measured, wanted, next);
      },
      moved, loop, all);
}

absl::StatusOr<std::unique_ptr<Experiment>> Experiment::Create(
    const Campaign& campaign, const Scenario& scenario, std::uint64_t seed,
    const ProcessModel& initial, Shared<ConversionSummary>& conversion) {
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

EstimationOptions Experiment::EstimationOf(const Method& method) {
  EstimationOptions estimation;
  estimation.estimator = *method.estimator;
  estimation.change_test = method.change_test;
  estimation.solve_by_ceres = method.solve_by_ceres;
  estimation.output_error = OutputErrorOptionsFor(options_.windows.robust);
  estimation.calibration.seed = seed_;
  // The noise is known, the initial model converted once.
  estimation.converter =
      [this, initial = *method.estimator == Estimator::kArx](
          const ProcessModel& model) -> absl::StatusOr<ConversionSummary> {
    if (!initial) return ConvertInitialModel(model, seed_, options_);
    double seconds = 0.0;
    const absl::StatusOr<const ConversionSummary*> made = conversion_.Get(
        [&] { return ConvertInitialModel(initial_, seed_, options_); },
        seconds);
    if (!made.ok()) return WithPrefix(made.status(), "conversion: ");
    return **made;
  };
  ExperimentOptions options = base_;
  if (method.UsesLambda()) {
    options.correction.solver = campaign_.solvers[method.solver].options;
    options.correction.selection =
        campaign_.selections[method.selection].options;
  }
  const Ablation* const ablation = campaign_.ablations[scenario_.ablation];
  if (ablation != nullptr) ablation->apply(options);
  estimation.correction = std::move(options.correction);
  return estimation;
}

const Hindsight& Experiment::HindsightOf(int solver,
                                         const Correction& correction) {
  const auto [found, added] = hindsights_.try_emplace(solver);
  Hindsight& hindsight = found->second;
  if (added) {
    const Eigen::VectorXd& lambdas = correction.fits().front().lambdas;
    DistanceCurve curve(correction, lambdas, truth_);
    const Eigen::Index best = curve.Best();
    hindsight = {lambdas(best), curve(best), curve(0)};
  }
  return hindsight;
}

absl::Status Experiment::RunEstimator(const Method& method,
                                      Evaluation& evaluation) {
  const int solver = std::max(method.solver, 0);
  MLE_ASSIGN_OR_RETURN(evaluation.estimate,
                       EstimateModel(initial_, windows_, EstimationOf(method),
                                     {}, &fits_[solver]));
  const EstimateFit& fit = evaluation.estimate->fit;
  evaluation.change_proposed = fit.change_proposed;
  evaluation.seconds = fit.seconds;
  if (method.change_test != ChangeTest::kNone)
    evaluation.p_value = fit.test.p_value;
  if (fit.arx != nullptr) {
    evaluation.lambda = fit.arx->selection().lambda_star;
    if (*method.estimator == Estimator::kArx) {
      evaluation.hindsight = &HindsightOf(solver, *fit.arx);
    }
  }
  MLE_ASSIGN_OR_RETURN(
      CorrectedModel model,
      MakeCorrectedModel(*evaluation.estimate, fit.change_proposed,
                         options_.sample_time, truth_.samples(),
                         /*make_arx=*/false));
  evaluation.response = std::move(model.response);
  if (evaluation.estimate->setting.conversion.has_value()) {
    evaluation.max_relative_gap = model.max_relative_gap;
  }
  return absl::OkStatus();
}

absl::StatusOr<Evaluation> Experiment::Run(const Method& method) {
  Evaluation evaluation;
  if (method.estimator.has_value()) {
    MLE_RETURN_IF_ERROR(RunEstimator(method, evaluation));
  } else {
    evaluation.response = InitialResponse();
  }
  if (!std::isfinite(SquaredDistance(truth_, evaluation.response))) {
    return absl::FailedPreconditionError(absl::StrFormat(
        "the model estimated is unstable: its step response leaves the range "
        "of numbers within %g",
        options_.response_horizon));
  }
  MLE_ASSIGN_OR_RETURN(evaluation.judgement,
                       Judge(truth_, evaluation.response));
  return evaluation;
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
      ComputeOutputErrorLimit(plant_, windows_, noise, OutputErrorOptions());
  if (!limit.ok()) return 0.0;
  const double E =
      limit->ExpectedSquaredDistance(options_.sample_time, truth_.samples());
  return std::isfinite(E) ? E : 0.0;
}

double Experiment::Limit() {
  if (!limit_.has_value()) limit_ = ComputeLimit();
  return *limit_;
}

namespace {

constexpr double kSpacing = 1.01;

}  // namespace

double DistanceOrInfinity(const StepResponse& truth,
                          const StepResponse& response) {
  const double distance = SquaredDistance(truth, response);
  return std::isfinite(distance) ? distance
                                 : std::numeric_limits<double>::infinity();
}

DistanceCurve::DistanceCurve(const Correction& correction,
                             const Eigen::VectorXd& lambdas,
                             const StepResponse& truth)
    : correction_(correction),
      lambdas_(lambdas),
      truth_(truth),
      model_(correction.initial()) {}

double DistanceCurve::operator()(Eigen::Index i) {
  correction_.Model(Eigen::VectorXd::Constant(model_.num_outputs, lambdas_(i)),
                    model_);
  return DistanceOrInfinity(truth_,
                            model_.ComputeStepResponse(truth_.samples()));
}

Eigen::VectorXd DistanceCurve::Whole() {
  Eigen::VectorXd distances(lambdas_.size());
  for (Eigen::Index i = 0; i < distances.size(); ++i) {
    distances(i) = (*this)(i);
  }
  return distances;
}

Eigen::Index DistanceCurve::Best() {
  std::vector<Eigen::Index> coarse = {0};
  for (Eigen::Index i = 1; i < lambdas_.size(); ++i) {
    if (lambdas_(i) >= kSpacing * lambdas_(coarse.back())) {
      coarse.push_back(i);
    }
  }
  std::size_t best = 0;
  double smallest = std::numeric_limits<double>::infinity();
  for (std::size_t n = 0; n < coarse.size(); ++n) {
    const double distance = (*this)(coarse[n]);
    if (distance < smallest) {
      smallest = distance;
      best = n;
    }
  }
  Eigen::Index found = coarse[best];
  const Eigen::Index first = coarse[best > 0 ? best - 1 : 0];
  const Eigen::Index last = coarse[std::min(best + 1, coarse.size() - 1)];
  for (Eigen::Index i = first; i <= last; ++i) {
    const double distance = (*this)(i);
    if (distance < smallest) {
      smallest = distance;
      found = i;
    }
  }
  return found;
}

}  // namespace mle::experiment
