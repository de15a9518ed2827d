#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "apps/correct/report.h"
#include "apps/correct/result_json.h"
#include "apps/report/text.h"
#include "control/disturbance_observer.h"
#include "control/expected_operation.h"
#include "control/mpc.h"
#include "mle/base/status.h"
#include "mle/filter/disturbance_system.h"

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

// Whether the bias filter of an output is one to take: it predicts better and,
// where the tuning is told, leaves less variance in operation.
bool IsBiasBetter(const Result& result, std::size_t i) {
  if (!result.filters[i].bias.better) return false;
  return !result.request.controller_known() ||
         (result.filter_operation.ok() &&
          result.filter_operation->bias(static_cast<Eigen::Index>(i)) < 1.0);
}

std::string Change(double ratio) {
  const double percent = 100.0 * (ratio - 1.0);
  return absl::StrCat(percent < 0.0 ? "−" : "+",
                      FormatSignificant(std::abs(percent), 2), " %");
}

// Of more outputs a sentence has the range alone; the table names them.
constexpr std::size_t kMostNamed = 6;

// Outputs whose bias filter is to be taken, with its time constant.
std::string TimeConstants(const Result& result) {
  std::vector<std::string> texts;
  double least = std::numeric_limits<double>::infinity();
  double most = 0.0;
  for (std::size_t i = 0; i < result.filters.size(); ++i) {
    const OutputFilter& filter = result.filters[i];
    if (!IsBiasBetter(result, i)) continue;
    texts.push_back(absl::StrCat(result.initial.outputs()[i].name, " ",
                                 filter.bias_gain < 1.0
                                     ? TimeOf(result, filter.bias_time_constant)
                                     : "none (the plain bias update)"));
    least = std::min(least, filter.bias_time_constant);
    most = std::max(most, filter.bias_time_constant);
  }
  if (texts.size() <= kMostNamed) return absl::StrJoin(texts, ", ");
  return absl::StrCat(FormatSignificant(least, 3), " to ", TimeOf(result, most),
                      " (table)");
}

std::string NamedOutputs(const Result& result,
                         const std::vector<std::string>& names) {
  if (names.size() <= kMostNamed) return absl::StrJoin(names, ", ");
  return names.size() == result.filters.size()
             ? "all outputs"
             : absl::StrCat(names.size(), " of ", result.filters.size(),
                            " outputs");
}

// "of top impurity, side impurity err by 5.4 to 7.1 %": how much less the
// predictions with the better Kalman gains err.
std::string LessWithKalman(const Result& result) {
  std::vector<std::string> names;
  double least = std::numeric_limits<double>::infinity();
  double most = 0.0;
  for (std::size_t i = 0; i < result.filters.size(); ++i) {
    const OutputFilter& filter = result.filters[i];
    if (!filter.kalman.better) continue;
    names.push_back(result.initial.outputs()[i].name);
    const double less = 1.0 - filter.kalman.error / filter.error_in_use;
    least = std::min(least, less);
    most = std::max(most, less);
  }
  if (names.empty()) return "";
  const std::string from = FormatSignificant(100.0 * least, 2);
  const std::string to = FormatSignificant(100.0 * most, 2);
  return absl::StrCat("of ", NamedOutputs(result, names), " err by ", from,
                      from == to ? "" : absl::StrCat(" to ", to), " %");
}

const char* UseOf(const Result& result, std::size_t i) {
  const bool bias = IsBiasBetter(result, i);
  if (bias && result.filters[i].kalman.better) return "either";
  if (bias) return "bias filter";
  if (result.filters[i].kalman.better) return "Kalman gain";
  return "keep";
}

// By control period.
control::OutputConditions ConditionsOf(const OutputFilter& filter) {
  control::OutputConditions met;
  const NoiseEstimate& noise = filter.noise;
  met.noise_variance = noise.variance;
  met.walk_variance = filter.samples_of_period * noise.increment_variance();
  met.walk_lag = filter.walk_lag / filter.samples_of_period;
  met.covariances = Autocovariances(noise, filter.samples_of_period);
  return met;
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

absl::StatusOr<FilterOperation> CompareFilters(const Result& result) {
  if (!result.request.controller_known()) {
    return absl::FailedPreconditionError("the controller's tuning is not told");
  }
  const auto p = static_cast<Eigen::Index>(result.filters.size());
  if (p == 0) return absl::FailedPreconditionError("there is no filter");
  std::vector<control::OutputConditions> conditions;
  control::MpcOptions bias = result.request.controller;
  bias.disturbance_variance_ratios = bias.VarianceRatios(static_cast<int>(p));
  for (Eigen::Index i = 0; i < p; ++i) {
    const OutputFilter& filter = result.filters[static_cast<std::size_t>(i)];
    if (!filter.estimated()) {
      return absl::FailedPreconditionError(absl::StrCat(
          result.initial.outputs()[static_cast<std::size_t>(i)].name, ": ",
          filter.reason));
    }
    conditions.push_back(ConditionsOf(filter));
    if (!filter.bias.better) continue;
    const double g = filter.bias_gain;
    bias.disturbance_variance_ratios(i) = g * g / (1.0 - g);
  }
  // At rest at the operating point of transforms, where there are any.
  const ProcessModel plant = WithoutTransforms(result.model);
  const auto variances = [&](const control::MpcOptions& tuning)
      -> absl::StatusOr<Eigen::VectorXd> {
    MLE_ASSIGN_OR_RETURN(const control::Mpc mpc,
                         control::Mpc::Create(plant, tuning));
    MLE_ASSIGN_OR_RETURN(const control::ExpectedOperation operation,
                         control::ExpectOperation(mpc, plant, conditions));
    return operation.resting_variance;
  };
  MLE_ASSIGN_OR_RETURN(const Eigen::VectorXd in_use,
                       variances(result.request.controller));
  FilterOperation operation;
  MLE_ASSIGN_OR_RETURN(operation.bias, variances(bias));
  operation.bias = operation.bias.cwiseQuotient(in_use);
  operation.kalman = Eigen::VectorXd::Ones(p);
  const DisturbanceForm form =
      CombineFilters(result.filters, result.filters.front().samples_of_period);
  if (form.A.size() == 0) return operation;
  control::MpcOptions kalman = result.request.controller;
  kalman.disturbance_model = form;
  MLE_ASSIGN_OR_RETURN(operation.kalman, variances(kalman));
  operation.kalman = operation.kalman.cwiseQuotient(in_use);
  return operation;
}

std::string FilterAdvice(const Result& result) {
  const std::string constants = TimeConstants(result);
  const std::string less = LessWithKalman(result);
  std::vector<std::string> sentences;
  if (!less.empty()) {
    sentences.push_back(absl::StrCat(
        "Give a controller with a state-space model the disturbance model and "
        "K of state_space.json: on data held out predictions ",
        less, " less than with ", InUse(result), "."));
  }
  if (!constants.empty()) {
    sentences.push_back(absl::StrCat(
        result.filter_operation.ok()
            ? "Give bias filters these time constants: "
            : "Bias filters predict best with these time constants, but "
              "whether the loop gains depends on the tuning "
              "(--control_period and others): ",
        constants, "."));
  }
  return absl::StrJoin(sentences, " ");
}

report::Table FilterTable(const Result& result) {
  const bool told = result.filter_operation.ok();
  report::Table table{
      .caption = "Filters of the outputs' disturbances",
      .columns = {
          {"output", Align::kLeft},
          {"gain in use"},
          {"bias filter: gain"},
          {absl::StrCat("time constant (", result.initial.time_unit(), ")")},
          {"error: filter in use"},
          {"bias filter"},
          {"Kalman gain"}}};
  if (told) {
    table.columns.push_back({"variance in operation: bias filter"});
    table.columns.push_back({"Kalman gain"});
  }
  table.columns.push_back({"use", Align::kLeft});
  for (std::size_t i = 0; i < result.filters.size(); ++i) {
    const OutputFilter& filter = result.filters[i];
    std::vector<std::string> row = {result.initial.outputs()[i].name,
                                    FormatSignificant(filter.gain_in_use, 3)};
    if (!filter.estimated()) {
      row.resize(table.columns.size() - 1, "–");
      row.push_back(absl::StrCat("keep: ", filter.reason));
      table.AddRow(std::move(row));
      continue;
    }
    for (const double value :
         {filter.bias_gain, filter.bias_time_constant, filter.error_in_use,
          filter.bias.error, filter.kalman.error}) {
      row.push_back(FormatSignificant(value, 3));
    }
    if (told) {
      const auto at = static_cast<Eigen::Index>(i);
      row.push_back(Change(result.filter_operation->bias(at)));
      row.push_back(Change(result.filter_operation->kalman(at)));
    }
    row.emplace_back(UseOf(result, i));
    table.AddRow(std::move(row));
  }
  return table;
}

std::string FilterNote(const Result& result) {
  const OutputFilter& first = result.filters.front();
  std::string text = absl::StrCat(
      "Gains are those of a control period of ",
      TimeOf(result, PeriodOf(result, first)),
      "; errors are root mean squares of predictions up to ",
      TimeOf(result, HorizonOf(result, first)),
      " ahead, on the half of the records that the filter was not estimated "
      "from. A filter is better where its errors are less by more than chance");
  if (!result.request.controller_known()) {
    return absl::StrCat(
        text,
        ". The controller's own filter was not given (--control_period, "
        "--prediction_horizon, --disturbance_variance_ratio): compared is the "
        "plain bias update at every sample.");
  }
  absl::StrAppend(&text,
                  "; a bias filter, where the variance in operation falls, "
                  "too. ");
  if (!result.filter_operation.ok()) {
    return absl::StrCat(text, "That variance is not known: ",
                        result.filter_operation.status().message(), ".");
  }
  return absl::StrCat(text,
                      "It is computed for the controller as it is tuned, "
                      "against its filter as it is.");
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
    if (noise.ar_ratio > 0.0) {
      row["coloured_variance"] = noise.ar_variance();
      row["coloured_time_constant"] = noise.ar_memory() * sample_time;
      if (noise.ar_damping > 0.0) {
        row["coloured_damping"] = noise.ar_damping;
      }
    }
    if (filter.walk_lag > 0.0) {
      row["walk_time_constant"] = filter.walk_lag * sample_time;
    }
    // Of ln q/r, ln s/r, ln 1/ω and ln ζ.
    row["log_standard_errors"] = noise.log_deviations;
    if (result.filter_operation.ok()) {
      const auto at = static_cast<Eigen::Index>(i);
      row["bias"]["variance_ratio"] = result.filter_operation->bias(at);
      row["kalman"]["variance_ratio"] = result.filter_operation->kalman(at);
    }
    json.push_back(std::move(row));
  }
  return json;
}

}  // namespace mle::correct
