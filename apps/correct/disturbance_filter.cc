#include <cmath>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "apps/correct/report.h"
#include "apps/correct/result_json.h"
#include "apps/report/text.h"
#include "control/disturbance_observer.h"

namespace mle::correct {
namespace {

using report::Align;
using report::FormatSignificant;

std::string TimeOf(const Result& result, double time) {
  return absl::StrCat(FormatSignificant(time, 3), " ",
                      result.initial.time_unit());
}

double PeriodOf(const Result& result, const OutputFilter& filter) {
  return filter.samples_of_period * result.data.sample_time();
}

double HorizonOf(const Result& result, const OutputFilter& filter) {
  return filter.horizon * PeriodOf(result, filter);
}

std::string InUse(const Result& result) {
  return result.request.controller_known()
             ? "the filter in use"
             : "the plain bias update at every sample";
}

double PercentLess(double error, double in_use) {
  return in_use > 0.0 ? 100.0 * (1.0 - error / in_use) : 0.0;
}

// What may be said of each output whose bias filter is better.
std::vector<std::string> TimeConstants(const Result& result) {
  std::vector<std::string> texts;
  for (std::size_t i = 0; i < result.filters.size(); ++i) {
    const OutputFilter& filter = result.filters[i];
    if (!filter.bias.better) continue;
    texts.push_back(absl::StrCat(
        result.initial.outputs()[i].name, " ",
        filter.bias_gain < 1.0 ? TimeOf(result, filter.bias_time_constant)
                               : "none (the plain bias update)",
        " (errors −",
        FormatSignificant(PercentLess(filter.bias.error, filter.error_in_use),
                          2),
        " %)"));
  }
  return texts;
}

std::vector<std::string> BetterKalman(const Result& result) {
  std::vector<std::string> texts;
  for (std::size_t i = 0; i < result.filters.size(); ++i) {
    const OutputFilter& filter = result.filters[i];
    if (!filter.kalman.better) continue;
    texts.push_back(absl::StrCat(
        result.initial.outputs()[i].name, " −",
        FormatSignificant(PercentLess(filter.kalman.error, filter.error_in_use),
                          2),
        " %"));
  }
  return texts;
}

const char* UseOf(const OutputFilter& filter) {
  if (filter.bias.better && filter.kalman.better) return "either";
  if (filter.bias.better) return "bias filter";
  if (filter.kalman.better) return "Kalman gain";
  return "keep";
}

nlohmann::ordered_json FormJson(const FilterForm& form) {
  return {{"better", form.better}, {"error", form.error}};
}

}  // namespace

FilterOptions FilterOptionsOf(const Request& request) {
  FilterOptions options = request.options.filter;
  if (!request.controller_known()) return options;
  const control::MpcOptions& controller = request.controller;
  options.control_period = controller.control_period;
  options.horizon = controller.prediction_horizon * controller.control_period;
  // A ratio of 0 corrects nothing: as slow as can be.
  constexpr double kLeastGain = 1e-6;
  options.gains_in_use = controller.VarianceRatios(request.model.num_outputs())
                             .unaryExpr(&control::StationaryGain)
                             .cwiseMax(kLeastGain);
  return options;
}

std::string FilterAdvice(const Result& result) {
  const std::vector<std::string> constants = TimeConstants(result);
  const std::vector<std::string> gains = BetterKalman(result);
  if (constants.empty() && gains.empty()) return "";
  const OutputFilter& first = result.filters.front();
  std::string text;
  if (!constants.empty()) {
    text = absl::StrCat("Time constants for the controller's bias filters: ",
                        absl::StrJoin(constants, ", "), ". ");
  }
  if (!gains.empty()) {
    text += absl::StrCat(
        "A controller with a state-space model takes K of "
        "state_space.json (errors: ",
        absl::StrJoin(gains, ", "), "). ");
  }
  return absl::StrCat(
      text, "Errors are those of predictions up to ",
      TimeOf(result, HorizonOf(result, first)),
      " ahead, on the half of the records that a filter was not estimated "
      "from, against ",
      InUse(result), ".");
}

report::Table FilterTable(const Result& result) {
  report::Table table{
      .caption = "Filters of the outputs' disturbances",
      .columns = {
          {"output", Align::kLeft},
          {"bias filter: gain"},
          {absl::StrCat("time constant (", result.initial.time_unit(), ")")},
          {"gain in use"},
          {"error in use"},
          {"of the bias filter"},
          {"of the Kalman gain"},
          {"use", Align::kLeft}}};
  for (std::size_t i = 0; i < result.filters.size(); ++i) {
    const OutputFilter& filter = result.filters[i];
    const std::string& name = result.initial.outputs()[i].name;
    if (!filter.estimated()) {
      table.AddRow({name, "–", "–", FormatSignificant(filter.gain_in_use), "–",
                    "–", "–", absl::StrCat("keep: ", filter.reason)});
      continue;
    }
    table.AddRow({name, FormatSignificant(filter.bias_gain, 3),
                  FormatSignificant(filter.bias_time_constant, 3),
                  FormatSignificant(filter.gain_in_use, 3),
                  FormatSignificant(filter.error_in_use, 3),
                  FormatSignificant(filter.bias.error, 3),
                  FormatSignificant(filter.kalman.error, 3), UseOf(filter)});
  }
  return table;
}

std::string FilterNote(const Result& result) {
  const OutputFilter& first = result.filters.front();
  return absl::StrCat(
      "The gain is that of a control period of ",
      TimeOf(result, PeriodOf(result, first)),
      "; errors are root mean squares over predictions up to ",
      TimeOf(result, HorizonOf(result, first)),
      " ahead, on the half of the records that the filter was not estimated "
      "from. A filter is better where both halves gain. ",
      result.request.controller_known()
          ? ""
          : "The controller's own filter was not given (--control_period, "
            "--prediction_horizon, --disturbance_variance_ratio): compared is "
            "the plain bias update at every sample. ",
      "state_space.json has the Kalman gain with the covariances of the "
      "disturbances.");
}

nlohmann::ordered_json FilterJson(const Result& result) {
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  const double sample_time = result.data.sample_time();
  for (std::size_t i = 0; i < result.filters.size(); ++i) {
    const OutputFilter& filter = result.filters[i];
    nlohmann::ordered_json row = {{"output", result.initial.outputs()[i].name},
                                  {"control_period", PeriodOf(result, filter)},
                                  {"horizon", HorizonOf(result, filter)},
                                  {"gain_in_use", filter.gain_in_use}};
    if (!filter.estimated()) {
      row["missing"] = filter.reason;
      json.push_back(std::move(row));
      continue;
    }
    const NoiseEstimate& noise = filter.noise;
    row["error_in_use"] = filter.error_in_use;
    row["bias"] = FormJson(filter.bias);
    row["bias"]["gain"] = filter.bias_gain;
    row["bias"]["time_constant"] = filter.bias_time_constant;
    row["kalman"] = FormJson(filter.kalman);
    row["kalman"]["gain"] = std::vector<double>(filter.stationary.gain.begin(),
                                                filter.stationary.gain.end());
    row["kalman"]["riccati_residual"] = filter.stationary.residual;
    row["measurement_variance"] = noise.variance;
    row["increment_variance"] = noise.increment_variance();
    if (noise.colour_ratio > 0.0) {
      row["coloured_variance"] = noise.colour_variance();
      row["coloured_time_constant"] = noise.colour_memory() * sample_time;
      if (noise.colour_damping > 0.0) {
        row["coloured_damping"] = noise.colour_damping;
      }
    }
    json.push_back(std::move(row));
  }
  return json;
}

}  // namespace mle::correct
