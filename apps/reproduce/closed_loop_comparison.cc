#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "apps/experiment/experiment.h"
#include "apps/report/text.h"
#include "apps/reproduce/summary.h"
#include "control/mpc.h"
#include "control/prediction_model.h"
#include "mle/base/random.h"
#include "mle/base/status.h"
#include "nlohmann/json.hpp"

namespace mle::reproduce {
namespace {

using control::PredictionModel;
using experiment::ExperimentOptions;
using Json = nlohmann::ordered_json;
using report::FormatSignificant;

constexpr double kSettlingBand = 0.05;  // of the step

// The measures of a change by their names in results.json.
struct LoopMeasure {
  const char* name;
  double LoopPerformance::*value;
  bool with_noise;  // whether it says something there
};

constexpr LoopMeasure kLoopMeasures[] = {
    {"integrated_squared_error", &LoopPerformance::integrated_squared_error,
     true},
    {"input_movement", &LoopPerformance::input_movement, true},
    {"overshoot", &LoopPerformance::overshoot, false},
    {"settling_time", &LoopPerformance::settling_time, false}};

LoopPerformance Measure(const Record& record, int output,
                        const ExperimentOptions& options) {
  const auto sample = [&](double time) {
    return static_cast<int>(std::lround(time / options.sample_time));
  };
  const int begin = sample(options.windows.step_time);
  const int end =
      std::min(sample(options.windows.step_time + options.windows.window),
               record.samples() - 1);
  LoopPerformance result;
  int settled = begin;
  for (int k = begin; k <= end; ++k) {
    const Eigen::VectorXd error =
        record.outputs.col(k) - record.set_points.col(k);
    result.integrated_squared_error +=
        error.squaredNorm() * options.sample_time;
    if (k > begin) {
      result.input_movement +=
          (record.inputs.col(k) - record.inputs.col(k - 1)).cwiseAbs().sum();
    }
    result.overshoot = std::max(result.overshoot,
                                error[output] / options.windows.setpoint_step);
    if (error.cwiseAbs().maxCoeff() >
        kSettlingBand * std::abs(options.windows.setpoint_step)) {
      settled = k + 1;
    }
  }
  result.settling_time = settled > end
                             ? std::numeric_limits<double>::infinity()
                             : (settled - begin) * options.sample_time;
  return result;
}

// From a twentieth of the window before the change to half of it after.
absl::StatusOr<Record> AboutTheChange(const Record& record,
                                      const ExperimentOptions& options) {
  const auto change = static_cast<int>(
      std::lround(options.windows.step_time / options.sample_time));
  return CutWindow(record, change, 0.05 * options.windows.window,
                   0.5 * options.windows.window);
}

LoopRun RunModel(const absl::StatusOr<PredictionModel>& model,
                 const ProcessModel& plant, double noise_variance,
                 std::uint64_t seed, bool keep_records,
                 const ExperimentOptions& options) {
  LoopRun run;
  const auto run_changes = [&]() -> absl::Status {
    MLE_RETURN_IF_ERROR(model.status());
    MLE_ASSIGN_OR_RETURN(const control::Mpc mpc,
                         control::Mpc::Create(*model, options.controller));
    for (int e = 0; e < plant.num_outputs(); ++e) {
      MLE_ASSIGN_OR_RETURN(
          const Record record,
          experiment::SimulateLoop(
              mpc, plant, experiment::StepOf(e, options.windows),
              noise_variance, seed,
              kComparisonStream + static_cast<std::uint64_t>(e),
              /*conditions=*/{}, options));
      run.changes.push_back(Measure(record, e, options));
      if (noise_variance > 0.0) run.changes.back().settling_time = 0.0;
      if (!keep_records) continue;
      MLE_ASSIGN_OR_RETURN(Record kept, AboutTheChange(record, options));
      run.records.push_back(std::move(kept));
    }
    return absl::OkStatus();
  };
  run.status = run_changes();
  return run;
}

// Means over the comparisons; empty if any of them has no run.
std::vector<LoopPerformance> Mean(
    const std::vector<const ClosedLoopComparison*>& comparisons, bool noisy,
    std::size_t model) {
  std::vector<LoopPerformance> mean;
  const double count = static_cast<double>(comparisons.size());
  for (const ClosedLoopComparison* comparison : comparisons) {
    const LoopRun& run =
        noisy ? comparison->noisy[model] : comparison->noise_free[model];
    if (!run.status.ok()) return {};
    mean.resize(run.changes.size());
    for (std::size_t e = 0; e < mean.size(); ++e) {
      for (const LoopMeasure& measure : kLoopMeasures) {
        mean[e].*measure.value += run.changes[e].*measure.value / count;
      }
    }
  }
  return mean;
}

double TotalError(const std::vector<LoopPerformance>& changes) {
  double total = 0.0;
  for (const LoopPerformance& change : changes) {
    total += change.integrated_squared_error;
  }
  return total;
}

// The measures of all changes as JSON. It is null where there are no changes; a
// number that is not finite is null.
Json ChangesToJson(const std::vector<LoopPerformance>& changes, bool noisy) {
  Json json;
  for (const LoopMeasure& measure : kLoopMeasures) {
    if (changes.empty() || (noisy && !measure.with_noise)) continue;
    for (const LoopPerformance& change : changes) {
      json[measure.name].push_back(change.*measure.value);
    }
  }
  return json;
}

std::string FormatTime(double time) {
  return std::isfinite(time) ? FormatSignificant(time) : "not settled";
}

}  // namespace

absl::StatusOr<ClosedLoopComparison> CompareClosedLoops(
    const ProcessModel& initial, const ArxModel& corrected,
    const ProcessModel& plant, std::uint64_t seed, bool in_full,
    const ExperimentOptions& options) {
  const control::MpcOptions& mpc = options.controller;
  MLE_RETURN_IF_ERROR(mpc.Validate(plant.num_outputs(), plant.num_inputs()));
  const std::array<absl::StatusOr<PredictionModel>, 3> models = {
      control::PredictFromProcess(initial, mpc.control_period),
      control::PredictFromArx(corrected, InputRoles(initial),
                              mpc.control_period),
      control::PredictFromProcess(plant, mpc.control_period)};
  ClosedLoopComparison comparison;
  for (std::size_t i = 0; i < models.size(); ++i) {
    comparison.noise_free[i] =
        RunModel(models[i], plant, 0.0, seed, in_full, options);
    comparison.noisy[i] =
        RunModel(models[i], plant, options.noise_variance, seed,
                 /*keep_records=*/false, options);
  }
  return comparison;
}

report::Table ClosedLoopTable(
    const std::string& case_name, const ProcessModel& plant,
    const std::vector<const ClosedLoopComparison*>& comparisons) {
  report::Table table{
      .caption = absl::StrCat("Case ", case_name,
                              ": the plant under control, by the model in the "
                              "controller"),
      .columns = {{"set-point change, model", report::Align::kLeft},
                  {"squared error"},
                  {"of the true model's"},
                  {"input movement"},
                  {"overshoot"},
                  {absl::StrCat("settling (", plant.time_unit(), ")")},
                  {"squared error, noisy"}}};
  std::array<std::vector<LoopPerformance>, 3> quiet, noisy;
  for (std::size_t i = 0; i < quiet.size(); ++i) {
    quiet[i] = Mean(comparisons, false, i);
    noisy[i] = Mean(comparisons, true, i);
  }
  for (int e = 0; e < plant.num_outputs(); ++e) {
    for (std::size_t i = 0; i < quiet.size(); ++i) {
      std::vector<std::string> row = {
          absl::StrCat(plant.outputs()[e].name, ", ", kLoopModelNames[i])};
      if (quiet[i].empty()) {
        row.push_back("not usable");
      } else {
        const LoopPerformance& change = quiet[i][e];
        const double truth =
            quiet[2].empty() ? 0.0 : quiet[2][e].integrated_squared_error;
        row.push_back(FormatSignificant(change.integrated_squared_error, 4));
        row.push_back(truth > 0.0
                          ? absl::StrFormat(
                                "%.1f %%",
                                100.0 * change.integrated_squared_error / truth)
                          : "");
        row.push_back(FormatSignificant(change.input_movement));
        row.push_back(absl::StrFormat("%.1f %%", 100.0 * change.overshoot));
        row.push_back(FormatTime(change.settling_time));
        row.push_back(
            noisy[i].empty()
                ? "not usable"
                : FormatSignificant(noisy[i][e].integrated_squared_error, 4));
      }
      table.AddRow(row);
    }
  }
  return table;
}

Json ClosedLoopJson(
    const std::vector<const ClosedLoopComparison*>& comparisons) {
  Json json;
  for (const bool noisy : {false, true}) {
    const char* const name = noisy ? "noisy" : "noise_free";
    std::array<std::vector<LoopPerformance>, 3> mean;
    for (std::size_t i = 0; i < mean.size(); ++i) {
      mean[i] = Mean(comparisons, noisy, i);
      Json runs = Json::array();
      for (const ClosedLoopComparison* comparison : comparisons) {
        const LoopRun& run =
            noisy ? comparison->noisy[i] : comparison->noise_free[i];
        runs.push_back(
            run.status.ok()
                ? ChangesToJson(run.changes, noisy)
                : Json{{"error", std::string(run.status.message())}});
      }
      json[name][kLoopModelNames[i]] = {{"mean", ChangesToJson(mean[i], noisy)},
                                        {"runs", std::move(runs)}};
    }
    const double truth = TotalError(mean[2]);
    for (const std::size_t i : {0, 1}) {
      json[name][absl::StrCat(kLoopModelNames[i], "_over_true")] =
          mean[i].empty() || !(truth > 0.0) ? Json()
                                            : Json(TotalError(mean[i]) / truth);
    }
  }
  return json;
}

}  // namespace mle::reproduce
