#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "apps/experiment/campaign.h"
#include "apps/experiment/study.h"
#include "mle/model/element_response.h"

namespace mle::experiment {
namespace {

absl::StatusOr<ProcessModel> InitialModel(const Campaign& campaign, int model,
                                          std::uint64_t seed) {
  const ModelSpec& spec = campaign.models[model];
  if (!spec.random.has_value()) return spec.model;
  return DrawModel(*spec.random, seed, campaign.controllers);
}

// Gains and dead times of first-order fits, over the elements that are not
// zero.
void AddElementErrors(const Experiment& experiment, const Judgement& judged,
                      Row& row) {
  const ProcessModel& plant = experiment.plant();
  double gain_squares = 0.0;
  double delay_squares = 0.0;
  double gain_max = 0.0;
  double delay_max = 0.0;
  int count = 0;
  for (const auto& [i, j] : Pairs(plant)) {
    if (plant.element(i, j).IsZero()) continue;
    const int pair = i * plant.num_inputs() + j;
    const FopdtFit& wanted = experiment.truth_judged().fopdt[pair];
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
  if (count == 0) return;
  row[Metric::kGainErrorRms] = std::sqrt(gain_squares / count);
  row[Metric::kDelayErrorRms] = std::sqrt(delay_squares / count);
  row[Metric::kGainErrorMax] = gain_max;
  row[Metric::kDelayErrorMax] = delay_max;
}

// Gain, time scale and dead time, where the element can be written so.
std::optional<std::array<double, 3>> ParametersOf(
    const TransferFunction& element) {
  if (element.IsZero()) return std::nullopt;
  const auto response = ElementResponse::Create(element);
  if (!response.ok()) return std::nullopt;
  return std::array<double, 3>{element.StaticGain(),
                               response->initial_values().time_scale,
                               element.delay()};
}

// By gain, time constant, dead time or shape.
bool Differs(const TransferFunction& a, const TransferFunction& b) {
  return a.numerator() != b.numerator() || a.denominator() != b.denominator() ||
         a.delay() != b.delay();
}

// Whether the elements named as aged are those that differ, and the share of
// the intervals of all fitted parameters that hold the plant's.
void AddParameters(const Experiment& experiment,
                   const OutputErrorCorrection& output_error, Row& row) {
  const ProcessModel& initial = experiment.initial();
  const ProcessModel& plant = experiment.plant();
  bool named = true;
  double covered = 0.0;
  double count = 0.0;
  for (const auto& [i, j] : Pairs(plant)) {
    const auto truth = ParametersOf(plant.element(i, j));
    named = named && output_error.aged(i, j) ==
                         Differs(initial.element(i, j), plant.element(i, j));
    const ElementEstimate& element = output_error.full.element(i, j);
    if (element.state != ElementState::kFitted || !truth.has_value()) {
      continue;
    }
    const std::array<const ParameterEstimate*, 3> estimates = {
        &element.gain, &element.time_scale, &element.delay};
    for (std::size_t k = 0; k < estimates.size(); ++k) {
      const double value = (*truth)[k];
      covered += estimates[k]->lower <= value && value <= estimates[k]->upper
                     ? 1.0
                     : 0.0;
      count += 1.0;
    }
  }
  row[Metric::kNamed] = named ? 1.0 : 0.0;
  if (count > 0.0) row[Metric::kCovered] = covered / count;
}

}  // namespace

Row RowOf(const Outcome& outcome) {
  Row row;
  row.run = outcome.run;
  row.seconds = outcome.seconds;
  if (!outcome.status.ok()) {
    row.status = absl::StrCat("failed: ", outcome.status.message());
    return row;
  }
  Experiment& experiment = *outcome.experiment;
  const Evaluation& evaluation = *outcome.evaluation;
  row[Metric::kInitialE] =
      DistanceOrInfinity(experiment.truth(), experiment.InitialResponse());
  row[Metric::kE] = evaluation.E();
  AddElementErrors(experiment, evaluation.judgement, row);
  if (evaluation.p_value.has_value()) {
    row[Metric::kProposed] = evaluation.change_proposed ? 1.0 : 0.0;
    row[Metric::kPValue] = *evaluation.p_value;
  }
  if (evaluation.lambda.size() > 0) {
    row[Metric::kLambdaMin] = evaluation.lambda.minCoeff();
    row[Metric::kLambdaMax] = evaluation.lambda.maxCoeff();
  }
  row[Metric::kGap] = evaluation.max_relative_gap;
  if (const Hindsight* const hindsight = evaluation.hindsight) {
    row[Metric::kBestE] = hindsight->best_E;
    row[Metric::kBestLambda] = hindsight->best_lambda;
    row[Metric::kZeroE] = hindsight->zero_E;
    if (hindsight->best_E > 0.0) {
      row[Metric::kRatio] = row[Metric::kE] / hindsight->best_E;
    }
  }
  const std::optional<Estimate>& estimate = evaluation.estimate;
  if (estimate.has_value() &&
      estimate->setting.options.estimator != Estimator::kArx) {
    AddParameters(experiment, estimate->fit.output_error, row);
    const double limit = experiment.Limit();
    if (limit > 0.0) row[Metric::kLimitE] = limit;
  }
  return row;
}

void RunUnit(const Campaign& campaign, const Grid& grid,
             const std::vector<std::int64_t>& runs,
             const std::atomic<bool>& stop,
             const std::function<void(const Outcome&)>& emit) {
  if (runs.empty()) return;
  double start = ThreadSeconds();
  const Coordinates first = grid.At(runs.front());
  const std::uint64_t seed = campaign.seeds[first.seed];
  const absl::StatusOr<ProcessModel> initial =
      InitialModel(campaign, first.scenario.model, seed);
  std::optional<SharedConversion> conversion;
  if (initial.ok()) conversion.emplace(*initial, seed);

  std::optional<Scenario> current;
  absl::StatusOr<std::unique_ptr<Experiment>> experiment =
      absl::InternalError("not run");
  for (const std::int64_t run : runs) {
    if (stop.load(std::memory_order_relaxed)) return;
    Outcome outcome;
    outcome.run = run;
    outcome.at = grid.At(run);
    if (initial.ok() && current != outcome.at.scenario) {
      current = outcome.at.scenario;
      experiment =
          Experiment::Create(campaign, *current, seed, *initial, *conversion);
    }
    std::optional<Evaluation> evaluation;
    if (!initial.ok()) {
      outcome.status =
          absl::Status(initial.status().code(),
                       absl::StrCat("model: ", initial.status().message()));
    } else if (!experiment.ok()) {
      outcome.status = experiment.status();
    } else {
      outcome.experiment = experiment->get();
      absl::StatusOr<Evaluation> made =
          (*experiment)->Run(campaign.methods[outcome.at.method]);
      outcome.status = made.status();
      if (made.ok()) evaluation = *std::move(made);
      outcome.evaluation = evaluation.has_value() ? &*evaluation : nullptr;
    }
    const double now = ThreadSeconds();
    outcome.seconds = now - start;
    start = now;
    emit(outcome);
  }
}

}  // namespace mle::experiment
