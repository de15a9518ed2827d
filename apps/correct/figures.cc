#include "apps/correct/figures.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "absl/strings/str_cat.h"
#include "apps/correct/advice.h"
#include "apps/correct/outputs.h"

namespace mle::correct {
namespace {

using report::Figure;
using report::HorizontalLine;
using report::MakeSeries;
using report::Panel;
using report::Role;
using report::Series;

constexpr double kPanelWidthCm = 8.5;
constexpr double kMaxWidthCm = 34.0;
constexpr int kMaxPoints = 1500;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

std::vector<double> ToVector(const Eigen::VectorXd& values) {
  return {values.data(), values.data() + values.size()};
}

std::string TimeLabel(const Result& result, const std::string& what) {
  return absl::StrCat(what, " (", result.initial().time_unit(), ")");
}

std::string Named(const std::string& name, const std::string& unit) {
  return unit.empty() ? name : absl::StrCat(name, " (", unit, ")");
}

Figure Grid(int rows, int columns, double row_height_cm) {
  Figure figure;
  figure.columns = columns;
  figure.width_cm =
      std::clamp(kPanelWidthCm * columns, 2.0 * kPanelWidthCm, kMaxWidthCm);
  figure.height_cm = std::min(1.5 + row_height_cm * rows, 100.0);
  return figure;
}

// The windows one after the other, with a break between them.
struct Strip {
  std::vector<double> time;  // from the start of the first window
  std::vector<double> ends;  // of all windows but the last
};

Strip MakeStrip(const RecordData& data) {
  Strip strip;
  double start = 0.0;
  for (const SetPointWindow& window : data.windows) {
    const Record& record = window.record;
    if (start > 0.0) strip.ends.push_back(start);
    for (int k = 0; k < record.samples(); ++k) {
      strip.time.push_back(start + k * record.sample_time);
    }
    start += record.samples() * record.sample_time;
    strip.time.push_back(start);
  }
  return strip;
}

// `values_of(w)` of every window, NaN between them.
template <typename Function>
std::vector<double> Join(const RecordData& data, const Function& values_of) {
  std::vector<double> joined;
  for (std::size_t w = 0; w < data.windows.size(); ++w) {
    const Eigen::RowVectorXd values = values_of(w);
    joined.insert(joined.end(), values.data(), values.data() + values.size());
    joined.push_back(kNaN);
  }
  return joined;
}

void AddStrip(Role role, const std::string& label, const Strip& strip,
              std::vector<double> values, Panel& panel, bool steps = false) {
  Series series = MakeSeries(role, label, strip.time, std::move(values));
  series.max_points = kMaxPoints;
  series.steps = steps;
  panel.series.push_back(std::move(series));
}

void MarkEnds(const Strip& strip, Panel& panel) {
  for (const double end : strip.ends) {
    panel.lines.push_back(VerticalLine(Role::kReference, "", end));
  }
}

// NaN where there are none.
Eigen::RowVectorXd SetPointsOf(const Record& record, int output) {
  if (record.set_points.size() > 0) return record.set_points.row(output);
  return Eigen::RowVectorXd::Constant(record.samples(), kNaN);
}

// y less what a model simulates, at the mean of what is measured.
Eigen::RowVectorXd Simulated(const Predictor& predictor, const Record& record,
                             int output) {
  return record.outputs.row(output) - predictor(record, 0).row(output);
}

}  // namespace

NamedFigure StepResponseFigure(const Result& result) {
  const ProcessModel& model = result.initial();
  const StepResponse& initial = result.initial_response;
  NamedFigure named;
  named.name = "step_responses";
  named.caption =
      "Response of each output (row) to a unit step of each input (column): "
      "the initial model and the one written, with its band where the records "
      "give one.";
  named.alt = named.caption;
  named.figure = Grid(model.num_outputs(), model.num_inputs(), 5.0);
  std::vector<double> time;
  for (int k = 0; k < initial.samples(); ++k) {
    time.push_back(k * initial.sample_time);
  }
  for (int i = 0; i < model.num_outputs(); ++i) {
    for (int j = 0; j < model.num_inputs(); ++j) {
      Panel& panel = named.figure.AddPanel(PairName(model, i, j));
      if (i + 1 == model.num_outputs())
        panel.x.label = TimeLabel(result, "time");
      const auto add = [&](Role role, const char* label,
                           const StepResponse& response) -> Series& {
        panel.series.push_back(
            MakeSeries(role, label, time, ToVector(response.element(i, j))));
        panel.series.back().max_points = kMaxPoints;
        return panel.series.back();
      };
      if (result.true_response.has_value()) {
        add(Role::kTrue, "true plant", *result.true_response);
      }
      add(Role::kInitial, "initial model", initial);
      Series& corrected =
          add(Role::kCorrected, result.accepted() ? "corrected" : "written",
              result.corrected.response);
      if (!result.corrected.errors.has_value()) continue;
      const Eigen::VectorXd half =
          BandFactor(result) * result.corrected.errors->element(i, j);
      if (!half.allFinite() || !(half.maxCoeff() > 0.0)) continue;
      const Eigen::VectorXd middle = result.corrected.response.element(i, j);
      corrected.lower = ToVector(middle - half);
      corrected.upper = ToVector(middle + half);
    }
  }
  return named;
}

NamedFigure RecordFigure(const Result& result) {
  const ProcessModel& model = result.initial();
  const RecordData& data = result.data;
  const Strip strip = MakeStrip(data);
  NamedFigure named;
  named.name = "records";
  named.caption =
      "The windows the correction rests on, one after the other: outputs with "
      "their set points, and inputs.";
  named.alt = named.caption;
  const int channels = model.num_outputs() + model.num_inputs();
  named.figure = Grid((channels + 1) / 2, 2, 4.0);
  for (int i = 0; i < model.num_outputs(); ++i) {
    Panel& panel = named.figure.AddPanel(
        Named(model.outputs()[i].name, model.outputs()[i].unit));
    AddStrip(Role::kMeasured, "measured", strip,
             Join(data,
                  [&](std::size_t w) -> Eigen::RowVectorXd {
                    return data.windows[w].record.outputs.row(i);
                  }),
             panel);
    AddStrip(Role::kSetPoint, "set point", strip,
             Join(data,
                  [&](std::size_t w) {
                    return SetPointsOf(data.windows[w].record, i);
                  }),
             panel, /*steps=*/true);
    MarkEnds(strip, panel);
  }
  for (int j = 0; j < model.num_inputs(); ++j) {
    Panel& panel = named.figure.AddPanel(
        Named(model.inputs()[j].name, model.inputs()[j].unit));
    AddStrip(Role::kMeasured, "measured", strip,
             Join(data,
                  [&](std::size_t w) -> Eigen::RowVectorXd {
                    return data.windows[w].record.inputs.row(j);
                  }),
             panel, /*steps=*/true);
    MarkEnds(strip, panel);
  }
  for (std::size_t n =
           named.figure.panels.size() >= 2 ? named.figure.panels.size() - 2 : 0;
       n < named.figure.panels.size(); ++n) {
    named.figure.panels[n].x.label =
        TimeLabel(result, "time from the first window's start");
  }
  return named;
}

NamedFigure PredictionFigure(const Result& result) {
  const ProcessModel& model = result.initial();
  const RecordData& data = result.data;
  const Strip strip = MakeStrip(data);
  const Fit& fit = result.estimate.fit;
  NamedFigure named;
  named.name = "predictions";
  named.caption =
      "Measured outputs and what both models simulate from the inputs alone, "
      "in all windows (the corrected model was fitted to them).";
  named.alt = named.caption;
  named.figure = Grid(model.num_outputs(), 1, 5.0);
  for (int i = 0; i < model.num_outputs(); ++i) {
    Panel& panel = named.figure.AddPanel(
        Named(model.outputs()[i].name, model.outputs()[i].unit));
    AddStrip(Role::kMeasured, "measured", strip,
             Join(data,
                  [&](std::size_t w) -> Eigen::RowVectorXd {
                    return data.windows[w].record.outputs.row(i);
                  }),
             panel);
    const auto add = [&](Role role, const char* label,
                         const Predictor& predictor) {
      AddStrip(role, label, strip,
               Join(data,
                    [&](std::size_t w) {
                      return Simulated(predictor, data.windows[w].record, i);
                    }),
               panel);
    };
    add(Role::kInitial, "initial model", fit.initial);
    if (result.accepted()) add(Role::kCorrected, "corrected", fit.corrected);
    MarkEnds(strip, panel);
  }
  named.figure.panels.back().x.label =
      TimeLabel(result, "time from the first window's start");
  return named;
}

bool HasLossFigure(const Result& result) {
  return result.estimate.fit.arx.has_value() &&
         result.estimate.fit.arx->selection().loss.size() > 1;
}

NamedFigure LossFigure(const Result& result) {
  const SelectionSummary& selection = result.estimate.fit.arx->selection();
  NamedFigure named;
  named.name = "loss_over_lambda";
  named.caption =
      "What the rule for λ minimises: the prediction loss on blocks held out, "
      "or the criterion. λ acts on outputs in units of their noise.";
  named.alt = named.caption;
  named.figure.width_cm = 14.0;
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

NamedFigure AutocorrelationFigure(const Result& result) {
  const ProcessModel& model = result.initial();
  const double sample_time = result.data.sample_time();
  NamedFigure named;
  named.name = "autocorrelation";
  named.caption =
      "Autocorrelation of the one-step prediction errors, with the 99 % limits "
      "of white noise.";
  named.alt = named.caption;
  named.figure = Grid((model.num_outputs() + 1) / 2, 2, 4.5);
  for (int i = 0; i < model.num_outputs(); ++i) {
    Panel& panel = named.figure.AddPanel(model.outputs()[i].name);
    panel.x.label = TimeLabel(result, "lag");
    const auto add = [&](Role role, const char* label,
                         const ResidualReport& report) {
      std::vector<double> lags;
      for (Eigen::Index a = 0; a < report.autocorrelation.size(); ++a) {
        lags.push_back(static_cast<double>(a + 1) * sample_time);
      }
      panel.series.push_back(
          MakeSeries(role, label, lags, ToVector(report.autocorrelation)));
      panel.series.back().max_points = kMaxPoints;
    };
    add(Role::kInitial, "initial model", result.initial_residuals[i]);
    if (result.accepted()) {
      add(Role::kCorrected, "corrected", result.corrected_residuals[i]);
    }
    const double limit = result.corrected_residuals[i].limit;
    panel.lines.push_back(HorizontalLine(Role::kReference, "99 %", limit));
    panel.lines.push_back(HorizontalLine(Role::kReference, "99 %", -limit));
  }
  return named;
}

NamedFigure CrossCorrelationFigure(const Result& result) {
  const ProcessModel& model = result.initial();
  const double sample_time = result.data.sample_time();
  NamedFigure named;
  named.name = "cross_correlation";
  named.caption =
      "Correlation of the one-step prediction errors with the inputs, with "
      "99 % limits. To the right of zero it shows dynamics that the model "
      "lacks; to the left the controller, which answers to what it measures.";
  named.alt = named.caption;
  named.figure = Grid(model.num_outputs(), model.num_inputs(), 4.5);
  for (int i = 0; i < model.num_outputs(); ++i) {
    for (int j = 0; j < model.num_inputs(); ++j) {
      Panel& panel = named.figure.AddPanel(PairName(model, i, j));
      if (i + 1 == model.num_outputs())
        panel.x.label = TimeLabel(result, "lag");
      const auto add = [&](Role role, const char* label,
                           const InputCorrelation& input) {
        std::vector<double> lags;
        for (int lag = -input.max_lag; lag <= input.max_lag; ++lag) {
          lags.push_back(lag * sample_time);
        }
        if (input.values.size() == 0) return;
        panel.series.push_back(
            MakeSeries(role, label, lags, ToVector(input.values)));
        panel.series.back().max_points = kMaxPoints;
      };
      add(Role::kInitial, "initial model",
          result.initial_residuals[i].inputs[j]);
      const InputCorrelation& corrected =
          result.corrected_residuals[i].inputs[j];
      if (result.accepted()) add(Role::kCorrected, "corrected", corrected);
      panel.lines.push_back(
          HorizontalLine(Role::kReference, "99 %", corrected.limit));
      panel.lines.push_back(
          HorizontalLine(Role::kReference, "99 %", -corrected.limit));
      panel.lines.push_back(VerticalLine(Role::kReference, "", 0.0));
    }
  }
  return named;
}

}  // namespace mle::correct
