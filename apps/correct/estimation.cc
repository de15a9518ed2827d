#include "apps/correct/estimation.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "mle/base/status.h"
#include "mle/data/lagged_series.h"

namespace mle::correct {
namespace {

// A probability that counts as none.
constexpr double kNever = 1e-300;

// Each window has an operating point of its own where the noise has one.
std::vector<Record> ScaledWindows(const Setting& setting,
                                  const std::vector<Record>& windows) {
  const bool offsets =
      std::any_of(setting.noise.begin(), setting.noise.end(),
                  [](const NoiseEstimate& noise) { return noise.offset; });
  std::vector<Record> scaled;
  for (const Record& window : windows) {
    Record& record = scaled.emplace_back(Scaled(window, setting.scales));
    if (!offsets) continue;
    const Eigen::VectorXd means = ChannelMeans({record});
    record.outputs.colwise() -= means.head(record.num_outputs());
    record.inputs.colwise() -= means.tail(record.num_inputs());
  }
  return scaled;
}

absl::Status AddPredictors(const Setting& setting, double sample_time,
                           Fit& fit) {
  if (setting.options.estimator == Estimator::kArx) {
    fit.initial =
        PredictWithArx(Unscaled(setting.conversion->model, setting.scales));
    fit.corrected =
        fit.arx.has_value()
            ? PredictWithArx(Unscaled(fit.arx->Model(), setting.scales))
            : fit.initial;
    return absl::OkStatus();
  }
  MLE_ASSIGN_OR_RETURN(
      fit.initial,
      PredictWithProcess(setting.initial, setting.noise, sample_time));
  MLE_ASSIGN_OR_RETURN(fit.corrected,
                       PredictWithProcess(fit.structured.corrected.model,
                                          setting.noise, sample_time));
  return absl::OkStatus();
}

// The model's elements that have aged, and the others.
struct Split {
  ProcessModel aged;
  ProcessModel held;
};

Split SplitElements(const ProcessModel& model,
                    const StructuredCorrection& full) {
  Split split = {model, model};
  for (int i = 0; i < model.num_outputs(); ++i) {
    for (int j = 0; j < model.num_inputs(); ++j) {
      (full.aged(i, j) ? split.held : split.aged).element(i, j) =
          TransferFunction();
    }
  }
  return split;
}

// One output of a record, less what the held elements make of it.
absl::StatusOr<Record> Remainder(const ProcessModel& held, const Record& record,
                                 int output) {
  MLE_ASSIGN_OR_RETURN(const Eigen::MatrixXd response,
                       SimulateResponse(held, record));
  Record remainder;
  remainder.start_time = record.start_time;
  remainder.sample_time = record.sample_time;
  remainder.inputs = record.inputs;
  remainder.outputs = record.outputs.row(output) - response.row(output);
  return remainder;
}

ProcessModel RowOf(const ProcessModel& model, int output) {
  ProcessModel row(model.name(), model.time_unit(), model.inputs(),
                   {model.outputs()[output]});
  for (int j = 0; j < model.num_inputs(); ++j) {
    row.element(0, j) = model.element(output, j);
  }
  return row;
}

// The initial model with its aged elements fitted to `windows`.
absl::StatusOr<ProcessModel> FitAgedElements(
    const Setting& setting, const StructuredCorrection& full,
    const std::vector<Record>& windows) {
  const Split split = SplitElements(setting.initial, full);
  ProcessModel model = setting.initial;
  for (int i = 0; i < model.num_outputs(); ++i) {
    if (!full.aged.row(i).any()) continue;
    std::vector<Record> remainders;
    for (const Record& window : windows) {
      MLE_ASSIGN_OR_RETURN(Record remainder, Remainder(split.held, window, i));
      remainders.push_back(std::move(remainder));
    }
    StructuredOptions options = setting.options.structured;
    // Offsets as in the full fit, and no selection.
    options.offset_test_level = setting.noise[i].offset ? 1.0 : kNever;
    options.false_alarm_probability = kNever;
    MLE_ASSIGN_OR_RETURN(
        const StructuredCorrection fit,
        CorrectStructure(RowOf(split.aged, i), remainders, options));
    for (int j = 0; j < model.num_inputs(); ++j) {
      if (full.aged(i, j)) model.element(i, j) = fit.full.model.element(0, j);
    }
  }
  return model;
}

}  // namespace

std::string_view NameOf(Estimator estimator) {
  return estimator == Estimator::kArx ? "arx" : "structured";
}

absl::StatusOr<Predictor> PredictFromPart(const Setting& setting,
                                          const Fit& full,
                                          const std::vector<Record>& windows) {
  if (setting.options.estimator == Estimator::kArx) {
    MLE_ASSIGN_OR_RETURN(
        const Correction correction,
        CorrectModel(setting.conversion->model, ScaledWindows(setting, windows),
                     setting.options.correction));
    return PredictWithArx(Unscaled(correction.Model(), setting.scales));
  }
  MLE_ASSIGN_OR_RETURN(const ProcessModel model,
                       FitAgedElements(setting, full.structured, windows));
  return PredictWithProcess(model, setting.noise, windows.front().sample_time);
}

absl::StatusOr<Estimate> EstimateModel(const ProcessModel& initial,
                                       const std::vector<Record>& windows,
                                       const EstimationOptions& options) {
  MLE_ASSIGN_OR_RETURN(StructuredCorrection structured,
                       CorrectStructure(initial, windows, options.structured));
  Estimate estimate;
  Fit& fit = estimate.fit;
  MLE_ASSIGN_OR_RETURN(
      fit.test, CalibrateTest(initial, windows, structured, options.structured,
                              options.calibration));
  if (structured.change_proposed &&
      fit.test.p_value >= options.structured.false_alarm_probability) {
    StructuredOptions without = options.structured;
    without.false_alarm_probability = kNever;
    MLE_ASSIGN_OR_RETURN(structured,
                         CorrectStructure(initial, windows, without));
  }
  Setting& setting = estimate.setting;
  setting.initial = initial;
  setting.options = options;
  setting.noise = structured.full.noise;
  setting.scales = ChooseScales(initial, setting.noise, windows);
  if (options.estimator == Estimator::kArx) {
    MLE_ASSIGN_OR_RETURN(
        setting.conversion,
        ConvertUnderNoise(initial, setting.noise, setting.scales,
                          windows.front().sample_time, options.conversion));
  }
  fit.structured = std::move(structured);
  fit.change_proposed = fit.structured.change_proposed;
  if (options.estimator == Estimator::kArx && fit.change_proposed) {
    MLE_ASSIGN_OR_RETURN(fit.arx, CorrectModel(setting.conversion->model,
                                               ScaledWindows(setting, windows),
                                               options.correction));
  }
  MLE_RETURN_IF_ERROR(AddPredictors(setting, windows.front().sample_time, fit));
  return estimate;
}

absl::StatusOr<CorrectedModel> MakeCorrectedModel(const Estimate& estimate,
                                                  bool accepted,
                                                  double sample_time,
                                                  int response_samples) {
  const Setting& setting = estimate.setting;
  const Fit& fit = estimate.fit;
  CorrectedModel corrected;
  if (setting.options.estimator == Estimator::kArx) {
    corrected.max_relative_gap = setting.conversion->max_relative_gap;
    ArxModel scaled = setting.conversion->model;
    if (accepted && fit.arx.has_value()) {
      scaled = fit.arx->Model();
      corrected.max_relative_gap =
          std::max(corrected.max_relative_gap, fit.arx->MaxRelativeGap());
    }
    corrected.arx = Unscaled(scaled, setting.scales);
    corrected.response = corrected.arx.ComputeStepResponse(response_samples);
    return corrected;
  }
  const StructuredFit& structured = fit.structured.corrected;
  corrected.process = accepted ? structured.model : setting.initial;
  corrected.response =
      corrected.process->ComputeStepResponse(sample_time, response_samples);
  corrected.errors =
      accepted ? structured.StepResponseErrors(sample_time, response_samples)
               : StepResponse(sample_time, setting.initial.num_outputs(),
                              setting.initial.num_inputs(), response_samples);
  MLE_ASSIGN_OR_RETURN(
      const ConversionSummary conversion,
      ConvertUnderNoise(*corrected.process, setting.noise, setting.scales,
                        sample_time, setting.options.conversion));
  corrected.max_relative_gap = conversion.max_relative_gap;
  corrected.arx = Unscaled(conversion.model, setting.scales);
  return corrected;
}

}  // namespace mle::correct
