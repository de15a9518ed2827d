// The records as they came, and what the models make of them.

#include <cmath>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/time/time.h"
#include "apps/correct/figure_parts.h"
#include "apps/correct/report.h"
#include "mle/base/double_limits.h"
#include "mle/data/civil_time.h"

namespace mle::correct {
namespace {

using report::Panel;
using report::Role;

// Pieces of record one after the other, with a break between them.
struct Strip {
  std::vector<const Record*> pieces;
  std::vector<double> starts;  // of each piece, on the strip
  std::vector<double> time;    // of each sample, and of the break after a piece
};

// From the first piece's own time, or from zero where there are several.
Strip MakeStrip(std::vector<const Record*> pieces) {
  Strip strip;
  double start = pieces.size() == 1 ? pieces.front()->start_time : 0.0;
  for (const Record* piece : pieces) {
    strip.starts.push_back(start);
    for (int k = 0; k <= piece->samples(); ++k) {
      strip.time.push_back(start + k * piece->sample_time);
    }
    start = strip.time.back();
  }
  strip.pieces = std::move(pieces);
  return strip;
}

// row_of(piece) of every piece, NaN at the breaks.
std::vector<double> Join(
    const Strip& strip,
    const std::function<Eigen::RowVectorXd(const Record&)>& row_of) {
  std::vector<double> joined;
  for (const Record* piece : strip.pieces) {
    const Eigen::RowVectorXd values = row_of(*piece);
    joined.insert(joined.end(), values.data(), values.data() + values.size());
    joined.push_back(kNaN);
  }
  return joined;
}

// Values of a channel as people know them.
Eigen::RowVectorXd Engineering(const Transform& transform,
                               Eigen::RowVectorXd values) {
  if (transform.IsNone()) return values;
  for (double& value : values) value = transform.Engineering(value);
  return values;
}

std::vector<double> SetPoints(const Strip& strip, int output,
                              const Transform& transform) {
  return Join(strip, [&](const Record& piece) -> Eigen::RowVectorXd {
    if (piece.set_points.size() > 0) {
      return Engineering(transform, piece.set_points.row(output));
    }
    return Eigen::RowVectorXd::Constant(piece.samples(), kNaN);
  });
}

// A mark at every sample that is not used, as high as the good one before it
// (or, at a start, after it).
void MarkUnusedSamples(const Strip& strip, const std::vector<double>& values,
                       Panel& panel) {
  std::vector<double> time;
  std::vector<double> height;
  double last = kNaN;
  for (const double value : values) {
    if (std::isnan(last) && std::isfinite(value)) last = value;
  }
  std::size_t n = 0;
  for (const Record* piece : strip.pieces) {
    for (int k = 0; k < piece->samples(); ++k, ++n) {
      if (std::isfinite(values[n])) {
        last = values[n];
      } else if (std::isfinite(last)) {
        time.push_back(strip.time[n]);
        height.push_back(last);
      }
    }
    ++n;  // the break
  }
  if (time.empty()) return;
  AddCurve(Role::kUnused, "not used", std::move(time), std::move(height),
           panel);
}

void MarkWindows(const RecordData& data, const Strip& strip, Panel& panel) {
  for (const SetPointWindow& window : data.windows) {
    const Record& record = data.records[window.source];
    const double shift = strip.starts[window.source] - record.start_time;
    panel.spans.push_back(report::MakeSpan(Role::kWindow, "window used",
                                           BeginOf(window) + shift,
                                           EndOf(window) + shift));
  }
}

// " They reach from … to ….", where there are dates.
std::string DatesOf(const RecordData& data, const ProcessModel& model) {
  const TimeNames times = data.Times(model);
  if (!times.has_dates() || data.records.empty()) return "";
  const Record& last = data.records.back();
  return absl::StrCat(" They reach from ",
                      times.Span(data.records.front().start_time,
                                 last.time(last.samples() - 1)),
                      " (", TimeUnit(data, model), ").");
}

// Dates on the axis, where the records have them and follow each other in time.
std::optional<report::DateScale> DateScaleOf(const RecordData& data,
                                             const ProcessModel& model,
                                             const Strip& strip) {
  const std::optional<double> unit = SecondsPerUnit(model.time_unit());
  if (!data.report.time_origin || !unit || strip.pieces.size() > 1) {
    return std::nullopt;
  }
  report::DateScale dates{.origin = *data.report.time_origin,
                          .seconds_per_unit = *unit};
  absl::TimeZone zone;
  const std::string& name = data.report.time_zone;
  if (!name.empty() && absl::LoadTimeZone(name, &zone)) dates.zone = zone;
  return dates;
}

std::string UnitOr(const std::string& unit, const char* otherwise) {
  return unit.empty() ? otherwise : unit;
}

}  // namespace

report::NamedFigure RecordFigure(const Result& result) {
  const ProcessModel& model = result.initial;
  const RecordData& data = result.data;
  std::vector<const Record*> records;
  for (const Record& record : data.records) records.push_back(&record);
  const Strip strip = MakeStrip(std::move(records));
  const int channels = model.num_outputs() + model.num_inputs();
  report::NamedFigure named = NewFigure(
      "records",
      absl::StrCat(
          "The records: outputs with their set points, and inputs. "
          "The correction uses the shaded windows; samples that it does "
          "not use have a cross at the last good value.",
          strip.pieces.size() > 1
              ? " Records are joined without the time between them."
              : "",
          DatesOf(data, model)),
      (channels + 1) / 2, 2, 4.0);
  const std::optional<report::DateScale> dates =
      DateScaleOf(data, model, strip);
  const std::string x_label =
      strip.pieces.size() > 1 ? TimeLabel(result, "time from the first start")
      : dates ? absl::StrCat("time (", TimeUnit(data, model), "), from ",
                             data.Times(model).Short(strip.starts[0]))
              : TimeLabel(result, "time");
  for (int c = 0; c < channels; ++c) {
    const bool output = c < model.num_outputs();
    const int j = c - model.num_outputs();
    Panel& panel = named.figure.AddPanel(output ? model.outputs()[c].name
                                                : model.inputs()[j].name);
    panel.y.label =
        UnitOr(output ? model.outputs()[c].unit : model.inputs()[j].unit,
               output ? "measured" : "input");
    panel.x.dates = dates;
    if (c + 2 >= channels) panel.x.label = x_label;
    const Transform& transform =
        output ? model.outputs()[c].transform : model.inputs()[j].transform;
    const std::vector<double> values =
        Join(strip, [&](const Record& piece) -> Eigen::RowVectorXd {
          return Engineering(
              transform, output ? piece.outputs.row(c) : piece.inputs.row(j));
        });
    MarkWindows(data, strip, panel);
    AddCurve(Role::kMeasured, "recorded", strip.time, values, panel).steps =
        !output;
    if (output) {
      AddCurve(Role::kSetPoint, "set point", strip.time,
               SetPoints(strip, c, transform), panel)
          .steps = true;
    }
    MarkUnusedSamples(strip, values, panel);
  }
  return named;
}

report::NamedFigure PredictionFigure(const Result& result) {
  const ProcessModel& model = result.initial;
  std::vector<const Record*> windows;
  for (const SetPointWindow& window : result.data.windows) {
    windows.push_back(&window.record);
  }
  const Strip strip = MakeStrip(std::move(windows));
  const EstimateFit& fit = result.estimate.fit;
  report::NamedFigure named =
      NewFigure("predictions",
                result.accepted()
                    ? "Measured outputs and simulations of both models from "
                      "the inputs alone, in all windows, one after the other "
                      "(the corrected model was fitted to these windows)."
                    : "Measured outputs and what the controller's model makes "
                      "of the inputs alone, in all windows, one after the "
                      "other.",
                model.num_outputs(), 1, 3.4);
  for (int i = 0; i < model.num_outputs(); ++i) {
    Panel& panel = named.figure.AddPanel(model.outputs()[i].name);
    panel.y.label = UnitOr(model.outputs()[i].unit, "measured");
    const Transform& transform = model.outputs()[i].transform;
    AddCurve(Role::kMeasured, "recorded", strip.time,
             Join(strip,
                  [&](const Record& piece) -> Eigen::RowVectorXd {
                    return Engineering(transform, piece.outputs.row(i));
                  }),
             panel);
    const auto add = [&](Role role, const char* label,
                         const Predictor& predictor) {
      // The simulated output is the measured one less the model's error.
      AddCurve(role, label, strip.time,
               Join(strip,
                    [&](const Record& piece) -> Eigen::RowVectorXd {
                      return Engineering(
                          transform,
                          piece.outputs.row(i) - predictor(piece, 0).row(i));
                    }),
               panel);
    };
    add(Role::kInitial,
        result.curves.empty() ? "controller's model"
                              : "controller's model, with the curve",
        fit.initial);
    if (result.accepted()) add(Role::kCorrected, "corrected", fit.corrected);
    for (std::size_t n = 1; n < strip.starts.size(); ++n) {
      panel.lines.push_back(
          VerticalLine(Role::kReference, "", strip.starts[n]));
    }
  }
  named.figure.panels.back().x.label = TimeLabel(
      result, strip.pieces.size() > 1 ? "time in the windows" : "time");
  return named;
}

}  // namespace mle::correct
