#include <algorithm>
#include <cmath>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "apps/correct/report.h"
#include "apps/report/text.h"

namespace mle::correct {
namespace {

using report::Align;
using report::FormatFixed;
using report::FormatHalfWidth;
using report::FormatInteger;
using report::FormatProbability;
using report::FormatScientific;
using report::FormatSignificant;
using report::ShortProbability;
using report::Table;

std::string PercentOrDash(double value) {
  return std::isfinite(value) ? absl::StrCat(FormatFixed(value, 1), " %") : "–";
}

std::string WithInterval(const ParameterEstimate& estimate) {
  const double half = 0.5 * (estimate.upper - estimate.lower);
  if (!std::isfinite(half)) {
    return absl::StrCat(FormatSignificant(estimate.value, 4),
                        " (not determined)");
  }
  return absl::StrCat(FormatSignificant(estimate.value, 4), " ± ",
                      FormatHalfWidth(half));
}

// `error` is a standard error.
std::string WithError(const Result& result, double value, double error) {
  if (!std::isfinite(error)) {
    return absl::StrCat(FormatSignificant(value, 4), " (not determined)");
  }
  return error > 0.0 ? absl::StrCat(FormatSignificant(value, 4), " ± ",
                                    FormatHalfWidth(BandFactor(result) * error))
                     : FormatSignificant(value, 4);
}

// Behind the gain of an element that integrates.
std::string SlopeMark(const FopdtElement& element) {
  return element.integrating ? " (slope)" : "";
}

// Former values of the parameters of an element that have moved. Where first
// order is only near, they stretch with the element's own time scale.
std::vector<std::string> Before(const Result& result, int output, int input) {
  const TransferFunction& given = result.initial.element(output, input);
  const FopdtElement& now =
      result.fopdt[output * result.initial.num_inputs() + input];
  const ElementEstimate& element =
      result.estimate.fit.output_error.corrected.element(output, input);
  const double stretch =
      element.time_scale.value > 0.0
          ? element.time_scale.initial / element.time_scale.value
          : 1.0;
  std::vector<std::string> before;
  const auto add = [&](const char* name, bool moved, double value) {
    if (!moved) return;
    before.push_back(absl::StrCat(name, " ", FormatSignificant(value, 4)));
  };
  const bool is_near = !given.IsFirstOrder() && !given.IsIntegrating();
  add("gain", HasMoved(element.gain), element.gain.initial);
  add("time constant", HasMoved(element.time_scale),
      is_near ? now.time_constant * stretch : element.time_scale.initial);
  add("dead time",
      HasMoved(element.delay) || (is_near && HasMoved(element.time_scale)),
      is_near
          ? element.delay.initial + (now.delay - element.delay.value) * stretch
          : element.delay.initial);
  if (before.empty()) before.emplace_back("another response");
  return before;
}

// Of an output whose correction is the instruments' estimate.
std::string WithoutScores(const Result& result) {
  const std::vector<Acceptance>& accepted = result.accepted_outputs;
  return std::find(accepted.begin(), accepted.end(), Acceptance::kExplained) ==
                 accepted.end()
             ? ""
             : " (–: the reason for the correction has its errors)";
}

}  // namespace

Table ParameterTable(const Result& result) {
  const ProcessModel& model = result.initial;
  const OutputErrorCorrection& output_error = result.estimate.fit.output_error;
  const bool shown = result.accepted() && result.corrected.process.has_value();
  Table table{.caption = absl::StrCat("Elements; times in ", model.time_unit()),
              .columns = {{"element", Align::kLeft},
                          {"value", Align::kLeft},
                          {"controller's model"},
                          {"all elements free"},
                          {"written"},
                          {"p, no change"},
                          {"records", Align::kLeft}}};
  for (const auto& [i, j] : Pairs(model)) {
    const ElementEstimate& full = output_error.full.element(i, j);
    const ElementEstimate& written = output_error.corrected.element(i, j);
    if (full.state == ElementState::kAbsent) continue;
    const bool fitted = full.state == ElementState::kFitted;
    const bool changed = shown && output_error.aged(i, j);
    const struct {
      const char* name;
      const ParameterEstimate& full;
      const ParameterEstimate& written;
    } rows[] = {{model.element(i, j).IsIntegrating() ? "gain (slope)" : "gain",
                 full.gain, written.gain},
                {"time constant", full.time_scale, written.time_scale},
                {"dead time", full.delay, written.delay}};
    bool first = true;
    for (const auto& row : rows) {
      // An integrator without lag has no time constant.
      if (&row.full == &full.time_scale && row.full.initial == 0.0) continue;
      table.AddRow(
          {first ? PairName(model, i, j) : "", row.name,
           FormatSignificant(row.full.initial, 4),
           fitted ? WithInterval(row.full) : "–",
           changed ? WithInterval(row.written)
           : result.corrected.process.has_value()
               ? FormatSignificant(row.full.initial, 4)
               : "–",
           first && fitted
               ? FormatProbability(output_error.element_p_values(i, j))
               : "",
           first ? std::string(NameOf(result.information.pair(i, j).state))
                 : ""});
      first = false;
    }
  }
  return table;
}

Table FopdtTable(const Result& result) {
  const ProcessModel& model = result.initial;
  Table table{.caption = absl::StrCat(
                  "The model written as first-order elements with dead time, "
                  "and of second order where these are not near; times in ",
                  model.time_unit()),
              .columns = {{"element", Align::kLeft},
                          {"gain"},
                          {"time constant"},
                          {"dead time"},
                          {"fit", Align::kLeft}}};
  for (const auto& [i, j] : Pairs(model)) {
    const FopdtElement& element = result.fopdt[i * model.num_inputs() + j];
    if (element.shape == FopdtShape::kNoResponse) continue;
    table.AddRow(
        {PairName(model, i, j),
         WithError(result, element.gain, element.gain_error) +
             SlopeMark(element),
         WithError(result, element.time_constant, element.time_constant_error),
         WithError(result, element.delay, element.delay_error),
         element.exact
             ? "exact"
             : absl::StrCat(
                   element.shape == FopdtShape::kPoorFit ? "poor, " : "",
                   "residual ", PercentOrDash(100.0 * element.relative_rms),
                   ", at most ",
                   PercentOrDash(100.0 * element.largest_difference))});
    if (!element.second_order.has_value()) continue;
    const SopdtFit& second = *element.second_order;
    table.AddRow(
        {"… of second order", FormatSignificant(second.gain, 4),
         absl::StrCat(FormatSignificant(second.time_constant, 4), ", damping ",
                      FormatSignificant(second.damping, 3)),
         FormatSignificant(second.delay, 4),
         absl::StrCat("at most ",
                      PercentOrDash(100.0 * second.largest_difference))});
  }
  return table;
}

Table ValidationTable(const Result& result) {
  const Validation& validation = result.validation;
  const bool held_out = validation.held_out;
  Table table{.caption = absl::StrCat(
                  held_out ? "Fit on parts of windows held out"
                           : "Fit of the controller's model on all windows",
                  ": 100 % is a perfect prediction, 0 % as good as the mean",
                  WithoutScores(result)),
              .columns = {{"output, model", Align::kLeft},
                          {"one step ahead"},
                          {Ahead(result)},
                          {"simulated"}}};
  const auto add = [&](int i, const char* row, const auto& cell) {
    const OutputScores& scores = validation.outputs[i];
    table.AddRow({absl::StrCat(result.initial.outputs()[i].name, ", ", row),
                  cell(scores.one_step), cell(scores.several_steps),
                  cell(scores.simulated)});
  };
  for (int i = 0; i < result.initial.num_outputs(); ++i) {
    add(i, "controller's",
        [](const auto& score) { return PercentOrDash(score.initial); });
    if (!held_out) continue;
    add(i, "corrected",
        [](const auto& score) { return PercentOrDash(score.corrected); });
    add(i, "gain", [&](const HorizonScore& score) {
      return std::isfinite(score.gain)
                 ? absl::StrCat(WithError(result, 100.0 * score.gain,
                                          100.0 * score.error),
                                " %")
                 : std::string("–");
    });
  }
  return table;
}

Table ResidualTable(const Result& result) {
  const ProcessModel& model = result.initial;
  Table table{
      .caption =
          "Residual tests, one step ahead (p-values): whiteness; independence "
          "of past inputs",
      .columns = {
          {"output, model", Align::kLeft}, {"variance"}, {"whiteness"}}};
  for (const InputChannel& input : model.inputs()) {
    table.columns.push_back({input.name});
  }
  const auto add = [&](const char* name, const ResidualReport& report, int i) {
    std::vector<std::string> row = {
        absl::StrCat(model.outputs()[i].name, ", ", name),
        FormatSignificant(report.variance), ShortProbability(report.p_value)};
    for (const InputCorrelation& input : report.inputs) {
      row.push_back(ShortProbability(input.p_value));
    }
    table.AddRow(std::move(row));
  };
  for (int i = 0; i < model.num_outputs(); ++i) {
    add("controller's", result.initial_residuals[i], i);
    if (result.accepted()) add("corrected", result.corrected_residuals[i], i);
  }
  return table;
}

Table NoiseTable(const Result& result) {
  const ProcessModel& model = result.initial;
  Table table{.caption = "Estimated noise of the outputs",
              .columns = {{"output", Align::kLeft},
                          {"white: standard deviation"},
                          {"drift: standard deviation after 100 samples"},
                          {"coloured: standard deviation"},
                          {"coloured: time constant"},
                          {"coloured: damping"},
                          {"periods"},
                          {"steps"},
                          {"offset of each window", Align::kLeft}}};
  const TimeNames times = result.data.Times(model);
  for (int i = 0; i < model.num_outputs(); ++i) {
    const NoiseEstimate& noise = result.estimate.setting.noise[i];
    const bool coloured = noise.ar_ratio > 0.0;
    std::vector<std::string> periods;
    for (const PeriodicLine& line : noise.lines) {
      periods.push_back(absl::StrCat(FormatSignificant(line.period),
                                     " (amplitude ",
                                     FormatSignificant(line.amplitude), ")"));
    }
    std::vector<std::string> steps;
    for (const LevelStep& step : noise.steps) {
      steps.push_back(absl::StrCat(FormatSignificant(step.size), " at ",
                                   times.Short(step.time)));
    }
    table.AddRow(
        {model.outputs()[i].name, FormatSignificant(std::sqrt(noise.variance)),
         FormatSignificant(std::sqrt(100.0 * noise.increment_variance())),
         coloured ? FormatSignificant(std::sqrt(noise.ar_variance())) : "–",
         coloured ? FormatSignificant(noise.ar_memory() *
                                      result.initial_response.sample_time)
                  : "–",
         noise.ar_damping > 0.0 ? FormatSignificant(noise.ar_damping) : "–",
         periods.empty() ? "–" : absl::StrJoin(periods, ", "),
         steps.empty() ? "–" : absl::StrJoin(steps, ", "),
         noise.offset ? "yes" : "no"});
  }
  return table;
}

std::string IntervalNote(const Result& result) {
  return absl::StrCat(
      "± is half a ",
      absl::StrFormat(
          "%.4g", 100.0 * result.options.estimation.output_error.confidence),
      " % confidence interval.");
}

std::string WhereFirstOrderIsNotNear(const Result& result) {
  const ProcessModel& model = result.initial;
  std::vector<std::string> pairs;
  for (const auto& [i, j] : Pairs(model)) {
    const FopdtElement& element = result.fopdt[i * model.num_inputs() + j];
    if (element.shape == FopdtShape::kNoResponse || element.exact ||
        !(element.largest_difference > kNearFopdt)) {
      continue;
    }
    pairs.push_back(
        absl::StrCat(PairName(model, i, j), " (by up to ",
                     FormatSignificant(100.0 * element.largest_difference, 2),
                     " % of its response)"));
  }
  if (pairs.empty()) return "";
  const std::string given = CorrectedName(result.request.model_file);
  return absl::StrCat(
      "Not of first order are ", absl::StrJoin(pairs, ", "),
      "; the table has the nearest first-order elements. If the controller "
      "takes transfer functions or step responses, use ",
      given.empty() ? "" : absl::StrCat(given, ", "),
      "model.json or step_response.csv instead, which have these responses as "
      "they are",
      result.request.model_file.form == ModelForm::kElementTable
          ? " (a table as near as second order allows)"
          : "",
      "; if it takes first order only, type the table.");
}

Table ControllerTable(const Result& result, bool with_intervals) {
  const ProcessModel& model = result.initial;
  const std::string time = absl::StrCat(" (", model.time_unit(), ")");
  Table table{.caption =
                  "The model as first-order elements with dead time, changed "
                  "ones coloured",
              .columns = {{"output", Align::kLeft},
                          {"input", Align::kLeft},
                          {"gain"},
                          {"time constant" + time},
                          {"dead time" + time},
                          {"before", Align::kLeft}},
              .stacked = true};
  for (int i = 0; i < model.num_outputs(); ++i) {
    for (int j = 0; j < model.num_inputs(); ++j) {
      const FopdtElement& element = result.fopdt[i * model.num_inputs() + j];
      if (element.shape == FopdtShape::kNoResponse) continue;
      const bool changed = HasChanged(result, i, j);
      const std::vector<std::string> before =
          changed ? Before(result, i, j) : std::vector<std::string>();
      const auto shown = [&](double value, double error) {
        return changed && with_intervals ? WithError(result, value, error)
                                         : FormatSignificant(value, 4);
      };
      table.AddRow(
          {model.outputs()[i].name, model.inputs()[j].name,
           shown(element.gain, element.gain_error) + SlopeMark(element),
           shown(element.time_constant, element.time_constant_error),
           shown(element.delay, element.delay_error),
           absl::StrJoin(before, ", ")});
      table.levels.emplace_back(6, changed ? 2 : 0);
    }
  }
  return table;
}

Table FitTable(const Result& result) {
  const Validation& validation = result.validation;
  Table table{
      .caption = absl::StrCat(
          "How well each output is predicted, ", Ahead(result),
          validation.held_out ? ", in data held out" : ", in all windows",
          " (100 %: perfectly, 0 %: as by the mean)", WithoutScores(result)),
      .columns = {{"output", Align::kLeft}, {"controller's model"}}};
  if (validation.held_out) table.columns.push_back({"corrected model"});
  for (int i = 0; i < result.initial.num_outputs(); ++i) {
    const HorizonScore& score = validation.outputs[i].several_steps;
    std::vector<std::string> row = {result.initial.outputs()[i].name,
                                    PercentOrDash(score.initial)};
    if (validation.held_out) row.push_back(PercentOrDash(score.corrected));
    table.AddRow(std::move(row));
  }
  return table;
}

Table CertificateTable(const Result& result) {
  const OutputErrorFit& fit = result.estimate.fit.output_error.corrected;
  Table table{.caption = "Certificate of the output-error fits",
              .columns = {{"output", Align::kLeft},
                          {"step to the optimum (standard deviations)"},
                          {"rank"},
                          {"condition"},
                          {"iterations"},
                          {"dead-time search", Align::kLeft}}};
  for (int i = 0; i < result.initial.num_outputs(); ++i) {
    const FitCertificate& certificate = fit.certificates[i];
    const bool free = certificate.num_parameters > 0;
    table.AddRow(
        {result.initial.outputs()[i].name,
         free ? FormatScientific(certificate.gradient, 2) : "–",
         absl::StrCat(certificate.rank, " of ", certificate.num_parameters),
         free ? FormatSignificant(certificate.condition, 2) : "–",
         FormatInteger(certificate.iterations),
         certificate.search_confirmed ? "confirmed" : "–"});
  }
  return table;
}

}  // namespace mle::correct
