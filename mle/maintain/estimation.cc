#include "mle/maintain/estimation.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "mle/base/status.h"
#include "mle/correction/robust_correction.h"
#include "mle/correction/smoothed_correction.h"
#include "mle/data/lagged_series.h"
#include "mle/maintain/fit_structure.h"
#include "mle/maintain/select_output.h"
#include "mle/model/process_simulator.h"
#include "mle/nonlinear/output_reconstruction.h"

namespace mle {
namespace {

// A probability that counts as none.
constexpr double kNever = 1e-300;

// Missing outputs filled in. Each window has an operating point of its own
// where the noise has one.
absl::StatusOr<std::vector<Record>> ScaledWindows(
    const EstimateSetting& setting, std::vector<Record> windows) {
  MLE_RETURN_IF_ERROR(
      FillOutputs(setting.filler, setting.noise, kLongestFill, windows)
          .status());
  const bool offsets =
      !setting.options.converter &&
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

ChannelScales UnitScales(const ProcessModel& model) {
  return {Eigen::VectorXd::Ones(model.num_outputs()),
          Eigen::VectorXd::Ones(model.num_inputs())};
}

// The rows that are ΔR's from `arx`, the others from `process`.
Predictor Mix(const std::vector<bool>& arx_outputs, const Predictor& process,
              const Predictor& arx) {
  return [=](const Record& record, int horizon) {
    Eigen::MatrixXd errors = process(record, horizon);
    const Eigen::MatrixXd own = arx(record, horizon);
    for (std::size_t i = 0; i < arx_outputs.size(); ++i) {
      const auto row = static_cast<Eigen::Index>(i);
      if (arx_outputs[i]) errors.row(row) = own.row(row);
    }
    return errors;
  };
}

// Of `process` in all outputs but those of `arx` (scaled), if there is one.
absl::StatusOr<Predictor> MakePredictor(const EstimateSetting& setting,
                                        const ProcessModel& process,
                                        const ArxModel* arx,
                                        double sample_time) {
  MLE_ASSIGN_OR_RETURN(Predictor predictor,
                       PredictWithProcess(process, setting.noise, sample_time));
  if (arx == nullptr) return predictor;
  MLE_ASSIGN_OR_RETURN(
      Predictor lagged,
      PredictFilled(setting.filler, setting.noise, sample_time,
                    PredictWithArx(Unscaled(*arx, setting.scales))));
  return Mix(setting.arx_outputs, predictor, lagged);
}

// R + ΔR at λ (one for each output) by the solver and the loss asked for.
absl::StatusOr<ArxModel> SolveArx(const EstimationOptions& options,
                                  const Correction& correction,
                                  const Eigen::VectorXd& lambdas, double& gap) {
  gap = correction.MaxRelativeGap();
  if (options.structured.robust_loss != RobustLoss::kNone) {
    RobustCorrectionOptions robust_options;
    robust_options.loss = options.structured.robust_loss;
    MLE_ASSIGN_OR_RETURN(RobustCorrection robust,
                         CorrectRobustly(correction, lambdas, robust_options));
    gap = std::max(gap, robust.MaxRelativeGap());
    return std::move(robust.model);
  }
  if (options.solve_by_ceres) {
    MLE_ASSIGN_OR_RETURN(SmoothedCorrection smoothed,
                         CorrectSmoothed(correction, lambdas, {}));
    gap = std::max(gap, smoothed.MaxRelativeGap());
    return std::move(smoothed.model);
  }
  return correction.Model(lambdas);
}

absl::Status SolveArx(const EstimationOptions& options, EstimateFit& fit) {
  MLE_ASSIGN_OR_RETURN(fit.arx_model,
                       SolveArx(options, *fit.arx,
                                fit.arx->selection().lambda_star, fit.arx_gap));
  return absl::OkStatus();
}

absl::Status AddPredictors(const EstimateSetting& setting, double sample_time,
                           EstimateFit& fit) {
  const ArxModel* const before =
      setting.conversion.has_value() ? &setting.conversion->model : nullptr;
  MLE_ASSIGN_OR_RETURN(fit.initial, MakePredictor(setting, setting.initial,
                                                  before, sample_time));
  if (!fit.arx.has_value()) {
    MLE_ASSIGN_OR_RETURN(fit.corrected,
                         MakePredictor(setting, fit.structured.corrected.model,
                                       before, sample_time));
    return absl::OkStatus();
  }
  MLE_ASSIGN_OR_RETURN(fit.corrected,
                       MakePredictor(setting, fit.structured.corrected.model,
                                     &fit.arx_model, sample_time));
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
  MLE_ASSIGN_OR_RETURN(
      const Eigen::MatrixXd response,
      SimulateResponse(held, record.sample_time, record.inputs));
  Record remainder = SelectOutput(record, output);
  remainder.outputs -= response.row(output);
  return remainder;
}

// The initial model with its aged elements fitted to `windows`.
absl::StatusOr<ProcessModel> FitAgedElements(
    const EstimateSetting& setting, const StructuredCorrection& full,
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
    options.offsets = setting.noise[i].offset ? WindowOffsets::kAlways
                                              : WindowOffsets::kNever;
    options.false_alarm_probability = kNever;
    MLE_ASSIGN_OR_RETURN(
        const StructuredCorrection fit,
        CorrectStructure(SelectOutput(split.aged, i), remainders, options));
    for (int j = 0; j < model.num_inputs(); ++j) {
      if (full.aged(i, j)) model.element(i, j) = fit.full.model.element(0, j);
    }
  }
  return model;
}

// ΔR for the whole model.
absl::Status AddArx(const std::vector<Record>& windows, SharedFits& shared,
                    Estimate& estimate) {
  EstimateSetting& setting = estimate.setting;
  EstimateFit& fit = estimate.fit;
  const EstimationOptions& options = setting.options;
  setting.arx_outputs.assign(setting.arx_outputs.size(), true);
  const double start = ThreadSeconds();
  MLE_ASSIGN_OR_RETURN(setting.conversion,
                       ConvertModel(setting, setting.initial, setting.scales,
                                    windows.front().sample_time));
  fit.seconds -= ThreadSeconds() - start;
  if (!fit.change_proposed) return absl::OkStatus();
  const auto correct = [&]() -> absl::StatusOr<Correction> {
    MLE_ASSIGN_OR_RETURN(const std::vector<Record> scaled,
                         ScaledWindows(setting, windows));
    return CorrectModel(setting.conversion->model, scaled, options.correction);
  };
  MLE_ASSIGN_OR_RETURN(const Correction* const made,
                       shared.arx.Get(correct, fit.seconds));
  fit.arx = *made;
  if (!(made->selection_options() == options.correction.selection)) {
    MLE_RETURN_IF_ERROR(fit.arx->Select(options.correction.selection));
  }
  return SolveArx(options, fit);
}

// ΔR for the outputs that structure does not explain.
absl::Status CompleteWithArx(const std::vector<Record>& windows,
                             Estimate& estimate) {
  EstimateSetting& setting = estimate.setting;
  EstimateFit& fit = estimate.fit;
  const EstimationOptions& options = setting.options;
  const double sample_time = windows.front().sample_time;
  CombinedOptions combined;
  combined.structured = options.structured;
  combined.false_alarm_probability = options.structured.false_alarm_probability;
  combined.correction = options.correction;
  // All in scaled units; back again, a model is converted as it is.
  const ChannelScales unit = UnitScales(setting.initial);
  StructuredCorrection scaled = fit.structured;
  scaled.corrected.model = Scaled(scaled.corrected.model, setting.scales);
  MLE_ASSIGN_OR_RETURN(const std::vector<Record> scaled_windows,
                       ScaledWindows(setting, windows));
  MLE_ASSIGN_OR_RETURN(CombinedCorrection result,
                       CompleteStructured(
                           Scaled(setting.initial, setting.scales),
                           std::move(scaled), scaled_windows,
                           [&](const ProcessModel& model) {
                             return ConvertModel(setting, model, unit,
                                                 sample_time);
                           },
                           combined));
  fit.adequacy = std::move(result.adequacy);
  if (!result.correction.has_value()) return absl::OkStatus();
  fit.change_proposed = true;
  fit.arx = std::move(result.correction);
  setting.conversion = std::move(result.conversion);
  setting.arx_outputs = std::move(result.outputs_corrected);
  return SolveArx(options, fit);
}

}  // namespace

Eigen::VectorXd DefaultLambdaGrid() {
  std::vector<double> lambdas = {0.0};
  for (int i = -84; i <= 12; ++i) lambdas.push_back(std::pow(10.0, i / 12.0));
  lambdas.push_back(kNoCorrectionLambda);
  return Eigen::Map<const Eigen::VectorXd>(
      lambdas.data(), static_cast<Eigen::Index>(lambdas.size()));
}

absl::StatusOr<Predictor> PredictFromPart(const EstimateSetting& setting,
                                          const EstimateFit& full,
                                          const std::vector<Record>& windows) {
  const double sample_time = windows.front().sample_time;
  ProcessModel process = setting.initial;
  if (setting.options.estimator != Estimator::kArx) {
    MLE_ASSIGN_OR_RETURN(process,
                         FitAgedElements(setting, full.structured, windows));
  }
  if (!full.arx.has_value()) {
    return MakePredictor(setting, process, nullptr, sample_time);
  }
  CorrectionOptions options = setting.options.correction;
  options.selection.rule = SelectionOptions::Rule::kAic;  // the cheapest
  MLE_ASSIGN_OR_RETURN(const std::vector<Record> scaled,
                       ScaledWindows(setting, windows));
  MLE_ASSIGN_OR_RETURN(
      const Correction correction,
      CorrectModel(setting.conversion->model, scaled, options));
  double gap = 0.0;
  MLE_ASSIGN_OR_RETURN(const ArxModel arx,
                       SolveArx(setting.options, correction,
                                full.arx->selection().lambda_star, gap));
  return MakePredictor(setting, process, &arx, sample_time);
}

double EstimateFit::PValue() const {
  const bool by_structure =
      change_proposed && adequacy.has_value() && !structured.change_proposed;
  return by_structure ? adequacy->p_value : test.p_value;
}

absl::Status EstimationOptions::Validate() const {
  if (change_test == ChangeTest::kAdequacy && estimator != Estimator::kArx) {
    return absl::InvalidArgumentError(
        absl::StrCat("change_test is adequacy, but estimator is ",
                     std::string(NameOf(estimator)),
                     ": that test is one of arx, as it has no structure"));
  }
  MLE_RETURN_IF_ERROR(structured.Validate());
  MLE_RETURN_IF_ERROR(calibration.Validate());
  MLE_RETURN_IF_ERROR(conversion.Validate());
  return correction.Validate();
}

absl::StatusOr<ConversionSummary> ConvertModel(const EstimateSetting& setting,
                                               const ProcessModel& model,
                                               const ChannelScales& scales,
                                               double sample_time) {
  if (setting.options.converter) return setting.options.converter(model);
  return ConvertUnderNoise(model, setting.noise, scales, sample_time,
                           setting.options.conversion);
}

absl::StatusOr<Estimate> EstimateModel(const ProcessModel& initial,
                                       const std::vector<Record>& windows,
                                       const EstimationOptions& options,
                                       const ProgressCallback& progress,
                                       SharedFits* shared) {
  const double start = ThreadSeconds();
  MLE_RETURN_IF_ERROR(options.Validate());
  SharedFits own;
  SharedFits& fits = shared == nullptr ? own : *shared;
  Estimate estimate;
  EstimateFit& fit = estimate.fit;
  MLE_RETURN_IF_ERROR(
      FitStructure(initial, windows, options, progress, fits, fit));
  EstimateSetting& setting = estimate.setting;
  setting.initial = initial;
  setting.options = options;
  setting.noise = fit.structured.full.noise;
  setting.filler = fit.structured.full.model;
  setting.scales = options.converter
                       ? UnitScales(initial)
                       : ChooseScales(initial, setting.noise, windows);
  setting.arx_outputs.assign(static_cast<std::size_t>(initial.num_outputs()),
                             false);
  if (options.estimator != Estimator::kStructured) {
    Stage correcting(progress, "correcting the ARX model");
    MLE_RETURN_IF_ERROR(correcting.status());
    MLE_RETURN_IF_ERROR(options.estimator == Estimator::kArx
                            ? AddArx(windows, fits, estimate)
                            : CompleteWithArx(windows, estimate));
  }
  MLE_RETURN_IF_ERROR(AddPredictors(setting, windows.front().sample_time, fit));
  fit.seconds += ThreadSeconds() - start;
  return estimate;
}

}  // namespace mle
