// Step responses of the models, and what a controller makes of them.

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "apps/correct/figure_parts.h"
#include "apps/correct/report.h"

namespace mle::correct {
namespace {

using report::NamedFigure;
using report::Panel;
using report::Role;
using report::Series;

constexpr int kColumns = 3;
// At most this many changed pairs, and outputs of a loop, are drawn.
constexpr std::size_t kMostChanged = 6;
constexpr std::size_t kMostLoops = 6;

// "% per t/h": of a step response; "-" is no unit.
std::string ResponseUnit(const ProcessModel& model, const PairPlace& pair) {
  const std::string& y = model.outputs()[pair.output].unit;
  const std::string& u = model.inputs()[pair.input].unit;
  if (y.empty() || u.empty() || (y == "-" && u == "-")) return "step response";
  return absl::StrCat(y == "-" ? "1" : y, " per ", u == "-" ? "1" : u);
}

int RowsFor(std::size_t panels, int columns) {
  return (static_cast<int>(panels) + columns - 1) / columns;
}

int ColumnsFor(std::size_t panels) {
  return std::min(static_cast<int>(panels), kColumns);
}

void AddResponses(const Result& result, const PairPlace& pair, Panel& panel) {
  const std::vector<double> time =
      Times(0.0, result.initial_response.sample_time,
            result.initial_response.samples());
  const auto add = [&](Role role, const char* label,
                       const StepResponse& response) -> Series& {
    return AddCurve(role, label, time,
                    ToVector(response.element(pair.output, pair.input)), panel);
  };
  if (result.true_response.has_value()) {
    add(Role::kTrue, "true plant", *result.true_response);
  }
  // The dashes of the initial model lie on top: of curves that coincide both
  // are seen.
  Series& corrected =
      add(Role::kCorrected, result.accepted() ? "corrected" : "written",
          result.corrected.response);
  if (result.corrected.errors.has_value()) {
    const Eigen::VectorXd half =
        BandFactor(result) *
        result.corrected.errors->element(pair.output, pair.input);
    if (half.allFinite() && half.maxCoeff() > 0.0) {
      const Eigen::VectorXd middle =
          result.corrected.response.element(pair.output, pair.input);
      corrected.lower = ToVector(middle - half);
      corrected.upper = ToVector(middle + half);
    }
  }
  add(Role::kInitial, "controller's model", result.initial_response);
}

NamedFigure ResponsesOf(const Result& result, const std::string& name,
                        const std::string& caption,
                        const std::vector<PairPlace>& pairs) {
  const int columns = ColumnsFor(pairs.size());
  const int rows = RowsFor(pairs.size(), columns);
  NamedFigure named = NewFigure(name, caption, rows, columns, 4.6);
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    Panel& panel = named.figure.AddPanel(
        PairName(result.initial, pairs[k].output, pairs[k].input));
    if (k + static_cast<std::size_t>(columns) >= pairs.size()) {
      panel.x.label = TimeLabel(result, "time");
    }
    panel.y.label = ResponseUnit(result.initial, pairs[k]);
    AddResponses(result, pairs[k], panel);
  }
  return named;
}

bool IsZero(const Result& result, const PairPlace& pair) {
  const auto none = [&](const StepResponse& response) {
    return response.element(pair.output, pair.input).isZero(0.0);
  };
  return none(result.initial_response) && none(result.corrected.response) &&
         (!result.true_response.has_value() || none(*result.true_response));
}

// As many as a figure shows, in the order of the outputs.
std::vector<const LoopStep*> MostChanged(const std::vector<LoopStep>& steps) {
  std::vector<const LoopStep*> chosen;
  for (const LoopStep& step : steps) chosen.push_back(&step);
  if (chosen.size() <= kMostLoops) return chosen;
  const auto change = [](const LoopStep* step) {
    return std::abs(step->error_ratio - 1.0);
  };
  std::stable_sort(chosen.begin(), chosen.end(),
                   [&](const LoopStep* a, const LoopStep* b) {
                     return change(a) > change(b);
                   });
  chosen.resize(kMostLoops);
  std::sort(chosen.begin(), chosen.end());
  return chosen;
}

}  // namespace

std::optional<NamedFigure> CurveFigure(const Result& result) {
  constexpr int kPoints = 81;
  if (result.curves.empty()) return std::nullopt;
  const int columns = ColumnsFor(result.curves.size());
  NamedFigure named = NewFigure(
      "curves",
      "Gains over the values that the records visited, relative to where they "
      "began, with 95 % bands. Beyond these values the curve is a guess.",
      RowsFor(result.curves.size(), columns), columns, 4.6);
  for (const FoundCurve& curve : result.curves) {
    const ProcessModel& model = result.initial;
    const int c = curve.channel;
    const std::string& name =
        curve.is_output ? model.outputs()[c].name : model.inputs()[c].name;
    const std::string& unit =
        curve.is_output ? model.outputs()[c].unit : model.inputs()[c].unit;
    Panel& panel = named.figure.AddPanel(name);
    panel.x.label = unit.empty() || unit == "-"
                        ? name
                        : absl::StrCat(name, " (", unit, ")");
    panel.y.label = "gain, relative";
    const std::vector<double> values =
        Times(curve.low, (curve.high - curve.low) / (kPoints - 1.0), kPoints);
    std::vector<double> gains;
    std::vector<double> lower;
    std::vector<double> upper;
    for (const double value : values) {
      const FoundCurve::Gain gain = curve.GainAt(value);
      gains.push_back(gain.value);
      lower.push_back(gain.lower);
      upper.push_back(gain.upper);
    }
    Series& corrected =
        AddCurve(Role::kCorrected, "corrected", values, gains, panel);
    corrected.lower = std::move(lower);
    corrected.upper = std::move(upper);
    AddCurve(Role::kInitial, "controller's model", values,
             std::vector<double>(values.size(), 1.0), panel);
  }
  return named;
}

std::optional<NamedFigure> StepResponseFigure(const Result& result) {
  std::vector<PairPlace> pairs;
  for (const auto& [i, j] : Pairs(result.initial)) {
    if (!IsZero(result, {i, j})) pairs.push_back({i, j});
  }
  // A horizon that ends within all dead times.
  if (pairs.empty()) return std::nullopt;
  return ResponsesOf(result, "step_responses",
                     "Response of each output to a unit step of each input: "
                     "the controller's model and the model written, with a "
                     "confidence band where available. Pairs without a "
                     "response are left out.",
                     pairs);
}

std::optional<NamedFigure> ChangedResponseFigure(const Result& result) {
  std::vector<ElementChange> changes = ElementChanges(result);
  if (changes.empty()) return std::nullopt;
  const bool all = changes.size() <= kMostChanged;
  if (!all) changes.resize(kMostChanged);
  std::vector<PairPlace> pairs;
  for (const ElementChange& change : changes) {
    pairs.push_back({change.output, change.input});
  }
  return ResponsesOf(
      result, "changed_responses",
      absl::StrCat("Response to a unit step before and after, with a "
                   "confidence band, of the pairs that have changed",
                   all ? "." : " most."),
      pairs);
}

std::optional<NamedFigure> ControlFigure(const Result& result) {
  if (!result.loops.ok() || result.loops->steps.empty()) {
    return std::nullopt;
  }
  const std::vector<const LoopStep*> steps = MostChanged(result.loops->steps);
  const std::size_t shown = steps.size();
  const bool all = shown == result.loops->steps.size();
  const int columns = ColumnsFor(shown);
  NamedFigure named = NewFigure(
      "control",
      absl::StrCat("A step of ",
                   all ? std::string("each set point")
                       : absl::StrCat("the ", shown,
                                      " set points whose control error changes "
                                      "most"),
                   ", with the controller's and the corrected model, tuned as "
                   "told. Deviations from the operating point, without noise."),
      RowsFor(shown, columns), columns, 4.6);
  for (std::size_t k = 0; k < shown; ++k) {
    const LoopStep& step = *steps[k];
    const OutputChannel& output = result.initial.outputs()[step.output];
    Panel& panel = named.figure.AddPanel(output.name);
    panel.y.label = output.unit.empty() ? "output" : output.unit;
    if (k + static_cast<std::size_t>(columns) >= shown) {
      panel.x.label = TimeLabel(result, "time");
    }
    const std::vector<double> time =
        Times(0.0, step.before.sample_time, step.before.samples());
    AddCurve(Role::kSetPoint, "set point", time,
             ToVector(step.before.set_points.row(step.output)), panel)
        .steps = true;
    AddCurve(Role::kCorrected, "with the corrected model", time,
             ToVector(step.after.outputs.row(step.output)), panel);
    AddCurve(Role::kInitial, "with the controller's model", time,
             ToVector(step.before.outputs.row(step.output)), panel);
  }
  return named;
}

}  // namespace mle::correct
