#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "apps/correct/figure_parts.h"
#include "apps/correct/report.h"
#include "apps/report/figure.h"
#include "mle/correction/correction.h"
#include "mle/correction/selection.h"

namespace mle::correct {
namespace {

using report::HorizontalLine;
using report::NamedFigure;
using report::Panel;
using report::Role;
using report::VerticalLine;

// From 0, kept, to 1.
double Shade(const Result& result, int output, int input) {
  constexpr double kLeast = 0.2;
  constexpr double kFull = 0.5;  // of the response's size
  const double change = result.change.elements(output, input);
  if (!result.accepted() || change == 0.0) return 0.0;
  if (!std::isfinite(change)) return 1.0;
  return kLeast + (1.0 - kLeast) * std::min(change / kFull, 1.0);
}

// A square for each pair, inputs along x, the first output at the top.
NamedFigure MismatchFigure(const Result& result) {
  constexpr double kCellWidthCm = 3.9;
  constexpr double kCellHeightCm = 2.3;
  const ProcessModel& model = result.initial;
  const int p = model.num_outputs();
  const int m = model.num_inputs();
  NamedFigure named = NewFigure(
      "mismatch_map",
      "Mismatch by element: changes, and the p-value of the controller's "
      "values. White: kept. The darker, the larger the relative change of the "
      "step response; half or more is darkest.",
      p, 1, kCellHeightCm);
  named.alt = absl::StrCat(named.caption,
                           " The table of elements has the same numbers.");
  named.figure.width_cm = std::clamp(3.0 + kCellWidthCm * m, 8.5, 60.0);
  named.figure.legend = false;
  Panel& panel = named.figure.AddPanel("");
  panel.x.label = "input";
  panel.y.label = "output";
  panel.x.names = NamesOf(model.inputs());
  for (int i = p - 1; i >= 0; --i) {
    panel.y.names.push_back(model.outputs()[i].name);
    for (int j = 0; j < m; ++j) {
      panel.cells.push_back(
          {static_cast<double>(j), static_cast<double>(p - 1 - i),
           Shade(result, i, j), DescribeMismatch(result, i, j)});
    }
  }
  return named;
}

bool HasLossFigure(const Result& result) {
  return result.estimate.fit.arx != nullptr &&
         result.estimate.fit.arx->selection().loss.size() > 1;
}

NamedFigure LossFigure(const Result& result) {
  const SelectionSummary& selection = result.estimate.fit.arx->selection();
  NamedFigure named = NewFigure(
      "loss_over_lambda",
      "Criterion of the choice of λ: the prediction loss on held-out blocks, "
      "or an information criterion. λ acts on outputs in units of their noise.",
      1, 1, 6.5);
  Panel& panel = named.figure.AddPanel("");
  panel.x = {.label = "penalty λ", .log = true};
  panel.y = {.label = "loss", .log = true};
  // The last λ corrects nothing, and lies far off.
  const Eigen::Index shown = selection.lambdas.size() - 1;
  panel.lines.push_back(
      HorizontalLine(Role::kInitial, "no correction", selection.loss(shown)));
  panel.series.push_back(MakeSeries(Role::kCorrected, "loss",
                                    ToVector(selection.lambdas.head(shown)),
                                    ToVector(selection.loss.head(shown))));
  const double chosen = selection.lambda_star(0);
  Eigen::Index nearest = 0;
  (selection.lambdas.array() - chosen).abs().minCoeff(&nearest);
  panel.markers.push_back(
      MakeMarker(Role::kChosen, "λ* chosen", chosen, selection.loss(nearest)));
  return named;
}

void AddLimits(double limit, Panel& panel) {
  for (const double side : {limit, -limit}) {
    panel.lines.push_back(HorizontalLine(Role::kReference, "99 %", side));
  }
}

NamedFigure AutocorrelationFigure(const Result& result) {
  const ProcessModel& model = result.initial;
  const double sample_time = result.data.sample_time();
  NamedFigure named = NewFigure(
      "autocorrelation",
      "Autocorrelation of the one-step prediction errors, with the 99 % limits "
      "of white noise.",
      (model.num_outputs() + 1) / 2, 2, 4.5);
  for (int i = 0; i < model.num_outputs(); ++i) {
    Panel& panel = named.figure.AddPanel(model.outputs()[i].name);
    panel.x.label = TimeLabel(result, "lag");
    panel.y.label = "autocorrelation";
    const auto add = [&](Role role, const char* label,
                         const ResidualReport& report) {
      AddCurve(role, label,
               Times(sample_time, sample_time, report.autocorrelation.size()),
               ToVector(report.autocorrelation), panel);
    };
    add(Role::kInitial, "controller's model", result.initial_residuals[i]);
    if (result.accepted()) {
      add(Role::kCorrected, "corrected", result.corrected_residuals[i]);
    }
    AddLimits(result.corrected_residuals[i].limit, panel);
  }
  return named;
}

NamedFigure CrossCorrelationFigure(const Result& result) {
  const ProcessModel& model = result.initial;
  const double sample_time = result.data.sample_time();
  NamedFigure named = NewFigure(
      "cross_correlation",
      "Correlation of the one-step prediction errors with the inputs, with "
      "99 % limits. At positive lags it indicates missing dynamics; at "
      "negative lags the feedback of the controller.",
      model.num_outputs(), model.num_inputs(), 4.5);
  const auto fill = [&](int i, int j, Panel& panel) {
    panel.y.label = "correlation";
    const auto add = [&](Role role, const char* label,
                         const InputCorrelation& input) {
      if (input.values.size() == 0) return;
      AddCurve(
          role, label,
          Times(-input.max_lag * sample_time, sample_time, input.values.size()),
          ToVector(input.values), panel);
    };
    const InputCorrelation& corrected = result.corrected_residuals[i].inputs[j];
    add(Role::kInitial, "controller's model",
        result.initial_residuals[i].inputs[j]);
    if (result.accepted()) add(Role::kCorrected, "corrected", corrected);
    AddLimits(corrected.limit, panel);
    panel.lines.push_back(VerticalLine(Role::kReference, "", 0.0));
  };
  AddPairPanels(result, TimeLabel(result, "lag"), named.figure, fill);
  return named;
}

}  // namespace

std::vector<report::NamedFigure> MakeFigures(const Result& result) {
  std::vector<NamedFigure> figures;
  const auto add = [&figures](std::optional<NamedFigure> figure) {
    if (figure.has_value()) figures.push_back(*std::move(figure));
  };
  add(StepResponseFigure(result));
  figures.push_back(MismatchFigure(result));
  figures.push_back(RecordFigure(result));
  figures.push_back(PredictionFigure(result));
  add(ChangedResponseFigure(result));
  add(CurveFigure(result));
  add(ControlFigure(result));
  add(NextMoveFigure(result));
  if (HasLossFigure(result)) figures.push_back(LossFigure(result));
  figures.push_back(AutocorrelationFigure(result));
  figures.push_back(CrossCorrelationFigure(result));
  return figures;
}

}  // namespace mle::correct
