#include "apps/reproduce/summary.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "apps/report/text.h"
#include "mle/base/status.h"
#include "mle/nonlinear/low_order_fit.h"

namespace mle::reproduce {
namespace {

using report::FormatScientific;
using report::FormatSignificant;

// Dead time of an element as a first-order one: its own, or the best fit's.
absl::StatusOr<double> FirstOrderDelay(const TransferFunction& element,
                                       const StepResponse& response, int output,
                                       int input) {
  if (element.IsZero() || element.IsFirstOrder()) return element.delay();
  MLE_ASSIGN_OR_RETURN(const FopdtFit fit,
                       FitFopdt(response.element(output, input),
                                response.sample_time, FopdtOptions()));
  return fit.delay;
}

std::string NumberedPair(const ProcessModel& plant, int output, int input) {
  return absl::StrCat("(", output + 1, ",", input + 1, ") ",
                      PairName(plant, output, input));
}

}  // namespace

std::vector<const ClosedLoopComparison*> CaseResult::ClosedLoops() const {
  std::vector<const ClosedLoopComparison*> loops;
  for (const RunResult& run : runs) loops.push_back(&run.closed_loop);
  return loops;
}

absl::Status SummariseCase(const ProcessModel& initial_model,
                           CaseResult& result) {
  const auto over_runs = [&result](double RunResult::*value) {
    std::vector<double> values;
    for (const RunResult& run : result.runs) values.push_back(run.*value);
    return experiment::Describe(values, 0);
  };
  result.E_star = over_runs(&RunResult::E_star);
  result.E_zero = over_runs(&RunResult::E_zero);
  result.E_oracle = over_runs(&RunResult::E_oracle);
  result.lambda_star = over_runs(&RunResult::lambda_star);
  result.max_relative_gap =
      std::max(0.0, over_runs(&RunResult::max_relative_gap).max);

  const ProcessModel& plant = result.plant;
  for (const auto& [i, j] : Pairs(plant)) {
    ElementErrors errors;
    errors.true_gain = plant.element(i, j).StaticGain();
    errors.initial_gain = initial_model.element(i, j).StaticGain();
    MLE_ASSIGN_OR_RETURN(
        errors.true_delay,
        FirstOrderDelay(plant.element(i, j), result.truth, i, j));
    MLE_ASSIGN_OR_RETURN(
        errors.initial_delay,
        FirstOrderDelay(initial_model.element(i, j), result.initial, i, j));
    const auto runs = static_cast<double>(result.runs.size());
    double end = 0.0, gain = 0.0, delay = 0.0;
    for (const RunResult& run : result.runs) {
      const FopdtFit& fit = run.judgement.fopdt[i * plant.num_inputs() + j];
      end += std::pow(run.judgement.static_gain_error(i, j), 2);
      gain += std::pow(fit.gain - errors.true_gain, 2);
      delay += std::pow(fit.delay - errors.true_delay, 2);
      errors.delay_impulse_peak_mean +=
          run.judgement.delay_impulse_peak(i, j) / runs;
    }
    errors.static_gain_error_rms = std::sqrt(end / runs);
    errors.fopdt_gain_error_rms = std::sqrt(gain / runs);
    errors.fopdt_delay_error_rms = std::sqrt(delay / runs);
    result.elements.push_back(errors);
  }
  return absl::OkStatus();
}

MethodSummary SummariseRuns(const std::vector<MethodRun>& runs) {
  MethodSummary summary;
  std::vector<double> E;
  std::vector<double> lambda;
  for (const MethodRun& run : runs) {
    if (!run.status.ok()) {
      summary.failure = std::string(run.status.message());
      continue;
    }
    E.push_back(run.E);
    lambda.push_back(run.lambda);
    summary.max_relative_gap =
        std::max(summary.max_relative_gap, run.max_relative_gap);
    summary.proposed += run.change_proposed ? 1 : 0;
    summary.seconds += run.seconds;
  }
  summary.E = experiment::Describe(std::move(E), 0);
  summary.lambda = experiment::Describe(std::move(lambda), 0);
  return summary;
}

std::string Extremes(const experiment::Distribution& values,
                     std::string (*format)(double value, int digits)) {
  const std::string from = format(values.min, 2);
  const std::string to = format(values.max, 2);
  return from == to ? from : absl::StrCat(from, " … ", to);
}

report::Table DistanceTable(const CaseResult& result) {
  report::Table table{
      .caption = absl::StrCat(
          "Case ", result.name, ": squared distance E of the step responses, ",
          result.runs.size(), result.runs.size() == 1 ? " seed" : " seeds"),
      .columns = {{"model", report::Align::kLeft}, {"λ"}}};
  const bool several = result.runs.size() > 1;
  if (several) {
    for (const char* name : {"E mean", "best", "worst", "deviation"}) {
      table.columns.push_back({name});
    }
  } else {
    table.columns.push_back({"E"});
  }
  const auto add = [&](const char* model, const std::string& lambda,
                       const experiment::Distribution& E) {
    std::vector<std::string> row = {model, lambda, FormatSignificant(E.mean)};
    if (several) {
      row.push_back(FormatSignificant(E.min));
      row.push_back(FormatSignificant(E.max));
      row.push_back(FormatSignificant(E.deviation));
    }
    table.AddRow(row);
  };
  const RunResult& first = result.runs.front();
  table.AddRow(
      {"before: initial model", "", FormatSignificant(result.E_initial, 5)});
  add("corrected, λ* from the records", Extremes(result.lambda_star),
      result.E_star);
  add("corrected, best λ in hindsight",
      several ? "" : FormatScientific(first.lambda_oracle, 2), result.E_oracle);
  if (first.other_rule.has_value()) {
    const std::string rule = first.other_rule->name == "paper"
                                 ? "corrected, λ by the paper's rule"
                                 : "corrected, λ by the default rule (blocks)";
    std::vector<std::string> row = {
        several ? absl::StrCat(rule, ", first seed") : rule,
        FormatScientific(first.other_rule->lambda, 2),
        FormatSignificant(first.other_rule->E)};
    table.AddRow(row);
  }
  add("corrected, without penalty", "0", result.E_zero);
  return table;
}

namespace {

// "12.8 → 6.40", or one number where nothing changes.
std::string Change(double before, double after) {
  if (before == after) return FormatSignificant(after);
  return absl::StrCat(FormatSignificant(before), " → ",
                      FormatSignificant(after));
}

// A row for each pair: its name, then what `cells` gives.
template <typename Cells>
void AddPairs(const CaseResult& result, const Cells& cells,
              report::Table& table) {
  const ProcessModel& plant = result.plant;
  for (const auto& [i, j] : Pairs(plant)) {
    std::vector<std::string> row = {NumberedPair(plant, i, j)};
    for (std::string& cell : cells(result.elements[i * plant.num_inputs() + j],
                                   FindPaperFigure(result, i, j))) {
      row.push_back(std::move(cell));
    }
    table.AddRow(std::move(row));
  }
}

std::string OverSeeds(const CaseResult& result) {
  return result.runs.size() > 1 ? ", root mean square errors over the seeds"
                                : "";
}

}  // namespace

report::Table GainTable(const CaseResult& result) {
  report::Table table{
      .caption = absl::StrCat("Case ", result.name, ": corrected gains",
                              OverSeeds(result)),
      .columns = {{"output ← input", report::Align::kLeft},
                  {"before → true"},
                  {"error, step response"},
                  {"error, FOPDT fit"},
                  {"paper"}}};
  AddPairs(
      result,
      [](const ElementErrors& e, const PaperFigure* paper) {
        return std::vector<std::string>{
            Change(e.initial_gain, e.true_gain),
            FormatSignificant(e.static_gain_error_rms, 2),
            FormatSignificant(e.fopdt_gain_error_rms, 2),
            paper != nullptr && paper->gain_error > 0.0
                ? FormatSignificant(paper->gain_error)
                : ""};
      },
      table);
  return table;
}

report::Table DelayTable(const CaseResult& result) {
  report::Table table{
      .caption = absl::StrCat("Case ", result.name, ": corrected dead times (",
                              result.plant.time_unit(), ")", OverSeeds(result)),
      .columns = {{"output ← input", report::Align::kLeft},
                  {"before → true"},
                  {"at impulse peak"},
                  {"paper, at peak"},
                  {"error, FOPDT fit"}}};
  AddPairs(
      result,
      [](const ElementErrors& e, const PaperFigure* paper) {
        return std::vector<std::string>{
            Change(e.initial_delay, e.true_delay),
            FormatSignificant(e.delay_impulse_peak_mean),
            paper != nullptr && paper->delay > 0.0
                ? FormatSignificant(paper->delay)
                : "",
            FormatSignificant(e.fopdt_delay_error_rms, 2)};
      },
      table);
  return table;
}

namespace {

using experiment::Describe;
using experiment::Distribution;

// The runs of an estimator, of all seeds.
std::vector<MethodRun> RunsOf(const CaseResult& result,
                              const std::string& name) {
  std::vector<MethodRun> runs;
  for (const RunResult& run : result.runs) {
    for (const MethodRun& one : run.estimators) {
      if (one.name == name) runs.push_back(one);
    }
  }
  return runs;
}

std::vector<std::string> AblationRow(const AblationResult& result) {
  const MethodSummary runs = SummariseRuns(result.runs);
  const char* const what = result.ablation->what;
  if (runs.E.count == 0) return {what, absl::StrCat("failed: ", runs.failure)};
  return {what, FormatSignificant(runs.E.mean), FormatSignificant(runs.E.max),
          Extremes(runs.lambda), FormatScientific(runs.max_relative_gap, 1)};
}

}  // namespace

report::Table EstimatorTable(const CaseResult& result, bool with_times) {
  report::Table table{.caption = absl::StrCat("Case ", result.name,
                                              ": estimators side by side"),
                      .columns = {{"estimator", report::Align::kLeft},
                                  {"runs"},
                                  {"E mean"},
                                  {"E worst"},
                                  {"change proposed"}}};
  if (with_times) table.columns.push_back({"s a run"});
  // In the order of the first run, which has them all.
  for (const MethodRun& one : result.runs.front().estimators) {
    const MethodSummary runs = SummariseRuns(RunsOf(result, one.name));
    const Distribution& E = runs.E;
    if (E.count == 0) {
      table.AddRow({one.name, "0", runs.failure});
      continue;
    }
    std::vector<std::string> row = {
        one.name, absl::StrCat(E.count), FormatSignificant(E.mean),
        FormatSignificant(E.max), absl::StrCat(runs.proposed, " of ", E.count)};
    if (with_times) {
      row.push_back(FormatSignificant(runs.seconds / E.count, 2));
    }
    table.AddRow(std::move(row));
  }
  std::vector<double> limits;
  for (const RunResult& run : result.runs) {
    if (run.E_limit > 0.0) limits.push_back(run.E_limit);
  }
  if (!limits.empty()) {
    table.AddRow({"information bound, all elements free",
                  absl::StrCat(limits.size()),
                  FormatSignificant(Describe(limits, 0).mean)});
  }
  return table;
}

report::Table AblationTable(const CaseResult& result) {
  std::vector<double> E;
  for (std::size_t s = 0; s < result.ablations.front().runs.size(); ++s) {
    E.push_back(result.runs[s].E_star);
  }
  report::Table table{
      .caption = absl::StrCat("Case ", result.name,
                              ": one decision taken differently, ", E.size(),
                              E.size() == 1 ? " seed" : " seeds"),
      .columns = {{"what differs", report::Align::kLeft},
                  {"E mean"},
                  {"E worst"},
                  {"λ*"},
                  {"largest duality gap"}}};
  const Distribution method = Describe(E, 0);
  table.AddRow({"nothing", FormatSignificant(method.mean),
                FormatSignificant(method.max)});
  for (const AblationResult& ablation : result.ablations) {
    table.AddRow(AblationRow(ablation));
  }
  return table;
}

}  // namespace mle::reproduce
